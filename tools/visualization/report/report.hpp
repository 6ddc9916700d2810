#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hal/types/result.hpp"
#include "planner/grasp_candidate.hpp"

namespace colift::picture {

struct ReportPicture {
  std::vector<std::uint8_t> png;  ///< Bytes of a PNG file, for example from scene_picture_png().
  std::string caption;
};

/// A row of the decision table.
struct ReportCandidate {
  int id = 0;
  std::string kind = {};  ///< "ega5", "edge", "wrap".
  planner::Verdict verdict = planner::Verdict::Ok;
  std::optional<double> share = std::nullopt;  ///< The robot's part of the load, 0 to 1.
  std::optional<double> cost = std::nullopt;
  std::optional<double> stability = std::nullopt;
  double width_m = 0.0;
  std::string reason = {};
};

struct ReportTime {
  std::string stage;
  double ms = 0.0;
};

/// What a report says. Everything is plain text; empty parts are left out of the page.
struct Report {
  std::string title;
  std::vector<std::string> summary;  ///< Paragraphs: what was seen and what was decided.
  std::vector<ReportPicture> pictures;
  std::vector<ReportCandidate> candidates;
  std::vector<std::string> surfaces;  ///< One sentence each.
  std::vector<ReportTime> timing;
  std::vector<std::pair<std::string, std::string>> facts;   ///< File, method, version, ...
  std::vector<std::pair<std::string, std::string>> config;  ///< What differs from the defaults: key, value.
  std::vector<std::string> notes;
  std::string command;  ///< The command line that makes this report again.
};

/// The report as one HTML page that needs nothing else: pictures and style are inside, there is no script.
/// Candidates come in the order chosen, possible by cost, refused by reason.
[[nodiscard]] std::string report_html(const Report& report);

/// The same as a file. Errors: BadInput when it cannot be written.
[[nodiscard]] hal::Result<> write_report(const std::filesystem::path& html, const Report& report);

/// Text as it stands in HTML: &, <, >, " and ' are escaped, control characters and bytes that are no UTF-8
/// replaced.
[[nodiscard]] std::string html_escaped(const std::string& text);

}  // namespace colift::picture
