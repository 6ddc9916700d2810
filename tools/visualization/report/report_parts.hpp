#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tools/visualization/report/report.hpp"

namespace colift::picture {

// Sections of a report page as HTML. Every text is escaped; an empty part gives an empty section.

/// A figure that stands out: "49 %", "robot's share", "wanted 50 %".
struct ReportCard {
  std::string value, name, note;
};

/// How a state of the time line is coloured.
enum class ReportTone { Plain, Good, Bad, Odd };

struct ReportStep {
  double from_s = 0.0, to_s = 0.0;
  std::string state, reason;
  ReportTone tone = ReportTone::Plain;
};

struct ReportTable {
  std::string heading;
  std::vector<std::string> columns;  ///< The first is text, the others are figures.
  std::vector<std::vector<std::string>> rows;
};

/// A whole page around a body; `outcome` becomes a chip beside the title where it is not empty.
[[nodiscard]] std::string report_page(const std::string& title, const std::string& outcome, ReportTone tone,
                                      const std::string& body);
[[nodiscard]] std::string report_heading(const std::string& heading);
/// Paragraphs, the first one larger.
[[nodiscard]] std::string report_paragraphs(const std::vector<std::string>& paragraphs);
/// In red: what nobody may overlook.
[[nodiscard]] std::string report_warning(const std::string& sentence);
[[nodiscard]] std::string report_figure(const ReportPicture& picture);
/// A film (animated PNG); who asked for reduced motion sees `still` (PNG).
[[nodiscard]] std::string report_film(const ReportPicture& film, const std::vector<std::uint8_t>& still);
/// Pictures beside each other where the page is wide enough.
[[nodiscard]] std::string report_figures(const std::vector<ReportPicture>& pictures);
[[nodiscard]] std::string report_cards(const std::vector<ReportCard>& cards);
[[nodiscard]] std::string report_time_line(const std::vector<ReportStep>& steps);
[[nodiscard]] std::string report_table(const ReportTable& table);
/// Every candidate in the order chosen, possible by cost, refused by reason.
[[nodiscard]] std::string report_candidates(const std::vector<ReportCandidate>& candidates);
[[nodiscard]] std::string report_times(const std::vector<ReportTime>& timing);
[[nodiscard]] std::string report_list(const char* heading, const std::vector<std::string>& sentences);
[[nodiscard]] std::string report_pairs(const char* heading,
                                       const std::vector<std::pair<std::string, std::string>>& rows);
[[nodiscard]] std::string report_command(const std::string& command);

}  // namespace colift::picture
