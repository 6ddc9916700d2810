// Two runs on one page.

#include <fmt/format.h>

#include <utility>

#include "tools/log/comparison.hpp"
#include "tools/visualization/file_output.hpp"
#include "tools/visualization/line_plot.hpp"
#include "tools/visualization/palette.hpp"
#include "tools/visualization/report/report_parts.hpp"

namespace colift::tools {
namespace {

using picture::ReportTable;

std::string run_sentence(const char* name, const RecordedRun& run) {
  return fmt::format(
      "{}: {}, version {}, method {}, seed {}. {}{}", name, run.file.string(), run.version, run.method,
      run.seed, run.outcome.empty() ? "The recording ends before the run." : run.outcome + ": ", run.reason);
}

ReportTable figure_table(const Comparison& c) {
  ReportTable out{"Figures", {"figure", "A", "B", "B - A"}, {}};
  for (const FigureComparison& f : c.figures)
    out.rows.push_back({f.unit.empty() ? f.title : fmt::format("{} ({})", f.title, f.unit),
                        value_text(f.value[0], digits_of(f)), value_text(f.value[1], digits_of(f)),
                        difference_text(f.value, digits_of(f))});
  return out;
}

ReportTable state_table(const Comparison& c) {
  ReportTable out{"States", {"state", "entered, A (s)", "B (s)", "spent in it, A (s)", "B (s)"}, {}};
  for (const StateComparison& s : c.states)
    out.rows.push_back({s.state, value_text(s.entered_s[0], 2), value_text(s.entered_s[1], 2),
                        fmt::format("{:.2f}", s.total_s[0]), fmt::format("{:.2f}", s.total_s[1])});
  return out;
}

std::vector<std::pair<std::string, std::string>> settings(const Comparison& c) {
  std::vector<std::pair<std::string, std::string>> out;
  for (const ConfigDifference& d : c.config)
    out.emplace_back(d.key, fmt::format("{} → {}", setting_text(d.value[0]), setting_text(d.value[1])));
  return out;
}

std::vector<std::pair<std::string, std::string>> verdicts(const Comparison& c) {
  std::vector<std::pair<std::string, std::string>> out;
  if (!c.decision) return out;
  const auto words = [](const VerdictDifference& v, std::size_t i) {
    return v.reason[i].empty() ? v.verdict[i] : fmt::format("{} ({})", v.verdict[i], v.reason[i]);
  };
  for (const VerdictDifference& v : c.decision->verdicts)
    out.emplace_back(fmt::format("candidate {}", v.id), fmt::format("{} → {}", words(v, 0), words(v, 1)));
  return out;
}

picture::PlotLine line(const char* name, picture::Colour colour, const RecordedCurve& curve, double zero_s) {
  picture::PlotLine out{name, colour, curve.t_s, curve.value};
  for (double& t : out.x) t -= zero_s;
  return out;
}

picture::LinePlot curves_plot(const Comparison& c) {
  picture::LinePlot plot;
  plot.x_title = c.aligned == "lift" ? "time since the lift began (s)" : "time since the start (s)";
  constexpr Both<const char*> kNames{"A", "B"};
  const Both<picture::Colour> colours{picture::kPartner, picture::rgb(0xD55E00)};
  for (const QuantityStyle& style : kQuantities) {
    picture::PlotPanel panel{style.title, {}, {}};
    if (style.quantity == Quantity::SpeedScale) panel.y_low = 0.0, panel.y_high = 1.05;
    for (std::size_t i = 0; i < 2; ++i) {
      const auto curve = c.run[i]->curves.find(style.quantity);
      if (curve == c.run[i]->curves.end()) continue;
      panel.lines.push_back(line(kNames[i], colours[i], curve->second, c.zero_s[i]));
      panel.lines.back().dashed = i == 1;
    }
    if (!panel.lines.empty()) plot.panels.push_back(std::move(panel));
  }
  return plot;
}

std::vector<std::string> summary(const Comparison& c) {
  std::vector<std::string> out;
  if (c.same()) out.emplace_back("The runs are the same in everything that is compared.");
  out.push_back(run_sentence("A", *c.run[0]));
  out.push_back(run_sentence("B", *c.run[1]));
  for (std::size_t i = 0; i < 2; ++i)
    if (c.run[i]->decision)
      out.push_back(fmt::format("{} decided: {}.", i == 0 ? "A" : "B", c.run[i]->decision->reason));
  return out;
}

}  // namespace

hal::Result<> write_comparison_page(const std::filesystem::path& html, const Comparison& c,
                                    const std::string& command) {
  std::string body = picture::report_paragraphs(summary(c)) + picture::report_table(figure_table(c));
  if (const picture::LinePlot plot = curves_plot(c); !plot.panels.empty())
    body += picture::report_figure(
        {picture::draw_line_plot(plot).png(), "Run A solid, run B dashed. A gap: not known at that time."});
  body += picture::report_table(state_table(c)) +
          picture::report_pairs("Candidates with another verdict, A → B", verdicts(c)) +
          picture::report_pairs("Settings that differ, A → B", settings(c)) +
          picture::report_command(command);
  const std::string page = picture::report_page("Two runs compared", "", picture::ReportTone::Plain, body);
  return picture::write_file(html, {reinterpret_cast<const std::uint8_t*>(page.data()), page.size()});
}

}  // namespace colift::tools
