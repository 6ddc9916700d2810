#include "tools/picture/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/picture/file_output.hpp"
#include "tools/picture/palette.hpp"
#include "tools/picture/report_style.hpp"
#include "tools/picture/utf8.hpp"

namespace colift::picture {
namespace {

std::string base64(const std::vector<std::uint8_t>& bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = bytes.size() - i;
    const unsigned group = (unsigned{bytes[i]} << 16) | (left > 1 ? unsigned{bytes[i + 1]} << 8 : 0u) |
                           (left > 2 ? unsigned{bytes[i + 2]} : 0u);
    out += kDigits[(group >> 18) & 63u];
    out += kDigits[(group >> 12) & 63u];
    out += left > 1 ? kDigits[(group >> 6) & 63u] : '=';
    out += left > 2 ? kDigits[group & 63u] : '=';
  }
  return out;
}

// White or dark letters, whichever stands out more (relative luminance, WCAG 2.1).
std::string chip(const VerdictStyle& style) {
  const auto linear = [](double c) { return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4); };
  const Colour& c = style.colour;
  const double luminance = 0.2126 * linear(c.r) + 0.7152 * linear(c.g) + 0.0722 * linear(c.b);
  const auto byte = [](double value) { return std::lround(255 * value); };
  return fmt::format(R"(<span class="chip" style="background:#{:02x}{:02x}{:02x};color:{}">{}</span>)",
                     byte(c.r), byte(c.g), byte(c.b), luminance > 0.18 ? "#101418" : "#fff", style.name);
}

std::string number(const std::optional<double>& value, const char* pattern) {
  return value && std::isfinite(*value) ? fmt::format(fmt::runtime(pattern), *value) : "–";
}

std::vector<ReportCandidate> in_order(std::vector<ReportCandidate> rows) {
  const auto rank = [](const ReportCandidate& c) {
    return std::find_if(kVerdicts.begin(), kVerdicts.end(),
                        [&](const VerdictStyle& s) { return s.verdict == c.verdict; }) -
           kVerdicts.begin();
  };
  const auto cost = [](const ReportCandidate& c) {
    return c.cost && !std::isnan(*c.cost) ? *c.cost : std::numeric_limits<double>::infinity();
  };
  std::stable_sort(rows.begin(), rows.end(), [&](const ReportCandidate& a, const ReportCandidate& b) {
    if (rank(a) != rank(b)) return rank(a) < rank(b);
    if (cost(a) != cost(b)) return cost(a) < cost(b);
    return a.id < b.id;
  });
  return rows;
}

std::string decision_table(const Report& report) {
  std::string out;
  std::string counts;
  for (const VerdictStyle& style : kVerdicts) {
    const auto count = std::count_if(report.candidates.begin(), report.candidates.end(),
                                     [&](const ReportCandidate& c) { return c.verdict == style.verdict; });
    if (count)
      counts += fmt::format("{}{} {} {}", counts.empty() ? "" : " · ", count, chip(style), style.meaning);
  }
  out += fmt::format("<h2>Grasp candidates ({})</h2>\n<p>{}</p>\n", report.candidates.size(), counts);
  out +=
      "<div class=\"wide\"><table><thead><tr><th class=\"n\">id</th><th>kind</th><th>verdict</th>"
      "<th class=\"n\">robot's share</th><th class=\"n\">cost</th><th class=\"n\">stability</th>"
      "<th class=\"n\">width</th><th>reason</th></tr></thead><tbody>\n";
  for (const ReportCandidate& c : in_order(report.candidates)) {
    const std::optional<double> percent = c.share ? std::optional(100 * *c.share) : std::nullopt;
    out += fmt::format(
        "<tr{}><td class=\"n\">{}</td><td>{}</td><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>"
        "<td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"why\">{}</td></tr>\n",
        c.verdict == planner::Verdict::Chosen ? " class=\"chosen\"" : "", c.id, html_escaped(c.kind),
        chip(style_of(c.verdict)), number(percent, "{:.1f} %"), number(c.cost, "{:.4g}"),
        number(c.stability, "{:.2f}"), number(100 * c.width_m, "{:.1f} cm"), html_escaped(c.because));
  }
  return out + "</tbody></table></div>\n";
}

std::string pairs(const char* heading, const std::vector<std::pair<std::string, std::string>>& rows) {
  if (rows.empty()) return "";
  std::string out = fmt::format("<h2>{}</h2>\n<dl>\n", heading);
  for (const auto& [name, value] : rows)
    out += fmt::format("<dt>{}</dt><dd>{}</dd>\n", html_escaped(name), html_escaped(value));
  return out + "</dl>\n";
}

std::string sentences(const char* heading, const std::vector<std::string>& rows) {
  if (rows.empty()) return "";
  std::string out = fmt::format("<h2>{}</h2>\n<ul>\n", heading);
  for (const std::string& row : rows) out += fmt::format("<li>{}</li>\n", html_escaped(row));
  return out + "</ul>\n";
}

std::string timing_bars(const std::vector<ReportTime>& timing) {
  if (timing.empty()) return "";
  double longest = 0;
  for (const ReportTime& t : timing) longest = std::max(longest, std::isfinite(t.ms) ? t.ms : 0.0);
  std::string out = "<h2>Time</h2>\n<div class=\"bars\">\n";
  for (const ReportTime& t : timing) {
    const double part = longest > 0 && std::isfinite(t.ms) ? std::max(0.0, 100 * t.ms / longest) : 0.0;
    out += fmt::format("<span>{}</span><div><i style=\"width:{:.1f}%\"></i></div><b>{}</b>\n",
                       html_escaped(t.stage), part, number(t.ms, "{:.2f} ms"));
  }
  return out + "</div>\n";
}

}  // namespace

std::string html_escaped(const std::string& text) {
  std::string out;
  for (const char ch : valid_utf8(text)) {
    switch (ch) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += ch;
    }
  }
  return out;
}

std::string report_html(const Report& report) {
  std::string page = fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{0}</title>\n"
      "<style>{1}</style>\n</head>\n<body>\n<main>\n<h1>{0}</h1>\n",
      html_escaped(report.title), kReportStyle);
  for (std::size_t i = 0; i < report.summary.size(); ++i)
    page += fmt::format("<p{}>{}</p>\n", i == 0 ? " class=\"lead\"" : "", html_escaped(report.summary[i]));
  for (const ReportPicture& picture : report.pictures)
    page += fmt::format(
        "<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\"><figcaption>{0}</figcaption></figure>\n",
        html_escaped(picture.caption), base64(picture.png));
  if (!report.candidates.empty()) page += decision_table(report);
  page += sentences("Surfaces", report.surfaces);
  page += sentences("Notes", report.notes);
  page += timing_bars(report.timing);
  page += pairs("Facts", report.facts);
  page += pairs("Configuration that differs from the defaults", report.config);
  if (!report.command.empty())
    page += fmt::format("<h2>Do it again</h2>\n<pre>{}</pre>\n", html_escaped(report.command));
  return page + "</main>\n</body>\n</html>\n";
}

hal::Result<> write_report(const std::filesystem::path& html, const Report& report) {
  const std::string page = report_html(report);
  return write_file(html, {reinterpret_cast<const std::uint8_t*>(page.data()), page.size()});
}

}  // namespace colift::picture
