#include "tools/experiments/outcome.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "tools/visualization/file_output.hpp"
#include "tools/visualization/report/report.hpp"
#include "tools/visualization/report/report_parts.hpp"

namespace colift::experiments {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

// with the unit that people read
std::string shown(double value, const std::string& unit) {
  if (!std::isfinite(value)) return "–";
  if (unit == "%") return fmt::format("{:.1f} %", 100.0 * value);
  const int digits = std::abs(value) >= 100.0  ? 0
                     : std::abs(value) >= 10.0 ? 1
                     : std::abs(value) >= 0.1  ? 2
                                               : 3;
  return fmt::format("{:.{}f}{}{}", value, digits, unit.empty() ? "" : " ", unit);
}

std::string interval(const Figure& f) {
  if (f.estimate.n == 0) return "–";
  return fmt::format("{} to {}", shown(f.estimate.low, f.unit), shown(f.estimate.high, f.unit));
}

std::string goal_text(const Figure& f) {
  if (!f.goal) return "";
  return fmt::format("{} {}", f.at_least ? "≥" : "≤", shown(*f.goal, f.unit));
}

std::string verdict(const Figure& f) {
  if (!f.goal) return "";
  if (f.estimate.n == 0) return "not measured";
  if (f.met()) return "met";
  return fmt::format("missed by {}", shown(std::abs(f.estimate.value - *f.goal), f.unit));
}

std::string seed_of(const Campaign& campaign) {
  return header_value(campaign, "seed").value_or("");
}

std::size_t trials_of(const Campaign& campaign) {
  std::set<int> all;
  for (const Row& row : campaign.trials.rows()) all.insert(TrialTable::trial_of(row));
  return all.size();
}

hal::Result<> write_text(const fs::path& file, const std::string& text) {
  return picture::write_file(file, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

/// The same figure by each method; all methods have the same figures in the same order.
std::vector<const Figure*> row_of(const std::vector<MethodFigures>& all, std::size_t i) {
  std::vector<const Figure*> row;
  for (const MethodFigures& m : all) row.push_back(&m.figures[i]);
  return row;
}

std::string verdicts(const std::vector<MethodFigures>& all, std::size_t i) {
  std::string text;
  for (const MethodFigures& m : all) {
    const std::string one = verdict(m.figures[i]);
    if (one.empty()) continue;
    text += fmt::format("{}{}{}", text.empty() ? "" : "; ", all.size() > 1 ? m.method + " " : "", one);
  }
  return text;
}

picture::ReportTable side_by_side(const std::vector<MethodFigures>& all) {
  picture::ReportTable table;
  table.columns = {"figure"};
  for (const MethodFigures& m : all)
    table.columns.insert(table.columns.end(), {m.method + " method", "95 % interval", "of"});
  table.columns.insert(table.columns.end(), {"thesis", "goal", ""});
  for (std::size_t i = 0; i < all.front().figures.size(); ++i) {
    const Figure& first = all.front().figures[i];
    std::vector<std::string> cells{first.name};
    for (const Figure* f : row_of(all, i))
      cells.insert(cells.end(),
                   {shown(f->estimate.value, f->unit), interval(*f), std::to_string(f->estimate.n)});
    cells.insert(cells.end(), {first.thesis, goal_text(first), verdicts(all, i)});
    table.rows.push_back(std::move(cells));
  }
  return table;
}

/// The command that makes such a campaign.
std::string command_of(const Experiment& e, const Campaign& campaign) {
  std::string command = fmt::format("colift experiment {} --trials {}", e.name, trials_of(campaign));
  std::istringstream words(campaign.trials.header());
  for (std::string word; words >> word;)
    if (const std::size_t is = word.find('='); is != std::string::npos)
      command += fmt::format(" --{} {}", word.substr(0, is), word.substr(is + 1));
  return command;
}

}  // namespace

std::vector<MethodFigures> figures_of(const Experiment& e, const Campaign& campaign) {
  std::vector<MethodFigures> all;
  for (const std::string& method : methods_of(campaign)) {
    const Campaign mine = of_method(campaign, method);
    all.push_back({method, e.figures({mine.trials, mine.details})});
  }
  return all;
}

std::string experiment_document(const Experiment& e, const Campaign& campaign) {
  Json doc = {{"schema", "colift.experiment/1"},
              {"name", e.name},
              {"title", e.title},
              {"thesis", e.thesis},
              {"campaign", campaign.trials.header()},
              {"trials", trials_of(campaign)},
              {"complete", campaign.complete},
              {"figures", Json::array()}};
  try {
    doc["seed"] = std::stoull(seed_of(campaign));
  } catch (const std::exception&) {
    doc["seed"] = nullptr;
  }
  for (const MethodFigures& m : figures_of(e, campaign))
    for (const Figure& f : m.figures) {
      Json j = {{"method", m.method},
                {"key", f.key},
                {"name", f.name},
                {"value", number(f.estimate.value)},
                {"low", number(f.estimate.low)},
                {"high", number(f.estimate.high)},
                {"n", f.estimate.n},
                {"unit", f.unit == "%" ? "1" : f.unit}};
      if (f.goal) {
        j["goal"] = *f.goal;
        j["goal_is"] = f.at_least ? "at least" : "at most";
        j["met"] = f.met();
      }
      if (!f.thesis.empty()) j["thesis"] = f.thesis;
      doc["figures"].push_back(std::move(j));
    }
  return doc.dump();
}

std::string experiment_text(const Experiment& e, const Campaign& campaign) {
  std::string out = fmt::format("{} (thesis {}), {} trials, seed {}\n{}\n", e.title, e.thesis,
                                trials_of(campaign), seed_of(campaign), e.question);
  const std::vector<MethodFigures> all = figures_of(e, campaign);
  if (all.empty()) return out;
  out += fmt::format("\n  {:<58}", "");
  for (const MethodFigures& m : all) out += fmt::format(" {:<40}", m.method + " method");
  out += '\n';
  for (std::size_t i = 0; i < all.front().figures.size(); ++i) {
    const Figure& first = all.front().figures[i];
    out += fmt::format("  {:<58}", first.name);
    for (const Figure* f : row_of(all, i))
      out += fmt::format(" {:<40}", fmt::format("{:>10}  [{}]  n {}", shown(f->estimate.value, f->unit),
                                                interval(*f), f->estimate.n));
    if (!first.thesis.empty()) out += fmt::format("  thesis: {}", first.thesis);
    if (first.goal) out += fmt::format("  goal {}: {}", goal_text(first), verdicts(all, i));
    out += '\n';
  }
  return out;
}

hal::Result<> write_outcome(const Experiment& e, const Campaign& campaign, const fs::path& folder) {
  if (auto ok = write_text(folder / (e.name + ".json"), experiment_document(e, campaign) + "\n"); !ok)
    return ok;
  bool first = true;
  for (const std::string& method : methods_of(campaign)) {
    const Campaign mine = of_method(campaign, method);
    const fs::path file = folder / (first ? e.name + ".png" : e.name + "_" + method + ".png");
    if (auto ok = e.plot({mine.trials, mine.details}).write_png(file); !ok) return ok;
    first = false;
  }
  return {};
}

hal::Result<> write_index(const fs::path& folder) {
  std::string body = picture::report_paragraphs(
      {"The experiments of the thesis's chapter 6 in simulation, and what goes beyond them. Rates have "
       "Wilson's 95 % interval, quantiles the one between order statistics, means a bootstrap."});
  for (const Experiment& e : all_experiments()) {
    std::error_code ignored;
    if (!fs::exists(folder / (e.name + ".csv"), ignored)) continue;
    const auto campaign = read_campaign(e, folder);
    if (!campaign) continue;  // of another version: its own figures stay in its own files
    body += picture::report_heading(fmt::format("{}: {} (thesis {})", e.name, e.title, e.thesis));
    body += picture::report_paragraphs(
        {e.question,
         fmt::format("{} trials, seed {}. Rows: {}.csv{}.", trials_of(*campaign), seed_of(*campaign), e.name,
                     e.detail_columns.empty() ? "" : fmt::format(", {}_grasps.csv", e.name))});
    const std::vector<MethodFigures> all = figures_of(e, *campaign);
    if (!all.empty()) body += picture::report_table(side_by_side(all));
    for (const MethodFigures& m : all) {
      const Campaign mine = of_method(*campaign, m.method);
      body += picture::report_figure(
          {e.plot({mine.trials, mine.details}).png(), fmt::format("{} method, {}", m.method, e.title)});
    }
    body += picture::report_command(command_of(e, *campaign));
  }
  return write_text(folder / "index.html",
                    picture::report_page("CoLift: experiments", "", picture::ReportTone::Plain, body));
}

}  // namespace colift::experiments
