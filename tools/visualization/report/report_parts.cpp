#include "tools/visualization/report/report_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/visualization/palette.hpp"
#include "tools/visualization/report/report_style.hpp"
#include "tools/visualization/utf8.hpp"

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

const char* class_of(ReportTone tone) {
  switch (tone) {
    case ReportTone::Good:
      return "good";
    case ReportTone::Bad:
      return "bad";
    case ReportTone::Odd:
      return "odd";
    case ReportTone::Plain:
      break;
  }
  return "plain";
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

std::string report_page(const std::string& title, const std::string& outcome, ReportTone tone,
                        const std::string& body) {
  const std::string mark = outcome.empty() ? ""
                                           : fmt::format(" <span class=\"state {}\">{}</span>",
                                                         class_of(tone), html_escaped(outcome));
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{0}</title>\n"
      "<style>{1}</style>\n</head>\n<body>\n<main>\n<h1>{0}{2}</h1>\n{3}</main>\n</body>\n</html>\n",
      html_escaped(title), kReportStyle, mark, body);
}

std::string report_heading(const std::string& heading) {
  return fmt::format("<h2>{}</h2>\n", html_escaped(heading));
}

std::string report_paragraphs(const std::vector<std::string>& paragraphs) {
  std::string out;
  for (std::size_t i = 0; i < paragraphs.size(); ++i)
    out += fmt::format("<p{}>{}</p>\n", i == 0 ? " class=\"lead\"" : "", html_escaped(paragraphs[i]));
  return out;
}

std::string report_warning(const std::string& sentence) {
  return fmt::format("<p class=\"warning\">{}</p>\n", html_escaped(sentence));
}

std::string report_figure(const ReportPicture& picture) {
  return fmt::format(
      "<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\"><figcaption>{0}</figcaption></figure>\n",
      html_escaped(picture.caption), base64(picture.png));
}

std::string report_film(const ReportPicture& film, const std::vector<std::uint8_t>& still) {
  return fmt::format(
      "<figure><picture><source media=\"(prefers-reduced-motion: reduce)\" "
      "srcset=\"data:image/png;base64,{2}\"><img alt=\"{0}\" src=\"data:image/png;base64,{1}\"></picture>"
      "<figcaption>{0}</figcaption></figure>\n",
      html_escaped(film.caption), base64(film.png), base64(still));
}

std::string report_figures(const std::vector<ReportPicture>& pictures) {
  if (pictures.empty()) return "";
  std::string out = "<div class=\"pair\">\n";
  for (const ReportPicture& picture : pictures) out += report_figure(picture);
  return out + "</div>\n";
}

std::string report_cards(const std::vector<ReportCard>& cards) {
  if (cards.empty()) return "";
  std::string out = "<div class=\"cards\">\n";
  for (const ReportCard& card : cards)
    out += fmt::format("<div><b>{}</b><span>{}</span><small>{}</small></div>\n", html_escaped(card.value),
                       html_escaped(card.name), html_escaped(card.note));
  return out + "</div>\n";
}

std::string report_time_line(const std::vector<ReportStep>& steps) {
  if (steps.empty()) return "";
  double begin = steps.front().from_s, end = begin;
  for (const ReportStep& step : steps) end = std::max({end, step.from_s, step.to_s});
  const double span = end > begin ? end - begin : 1.0;
  std::string out =
      "<h2>What happened</h2>\n<div class=\"wide\"><table class=\"line\"><thead><tr>"
      "<th class=\"n\">from</th><th class=\"n\">for</th><th>state</th><th "
      "class=\"when\">when</th><th>because</th>"
      "</tr></thead><tbody>\n";
  for (const ReportStep& step : steps) {
    const double from = 100 * (step.from_s - begin) / span, part = 100 * (step.to_s - step.from_s) / span;
    const bool lasts = step.to_s > step.from_s;
    out += fmt::format(
        "<tr><td class=\"n\">{:.2f} s</td><td class=\"n\">{}</td><td><span class=\"state {}\">{}</span></td>"
        "<td class=\"when\"><i style=\"margin-left:{:.2f}%;width:{:.2f}%\"></i></td><td "
        "class=\"why\">{}</td></tr>\n",
        step.from_s, lasts ? fmt::format("{:.2f} s", step.to_s - step.from_s) : "", class_of(step.tone),
        html_escaped(step.state), std::min(from, 99.0), std::max(part, 0.0), html_escaped(step.reason));
  }
  return out + "</tbody></table></div>\n";
}

std::string report_table(const ReportTable& table) {
  if (table.rows.empty()) return "";
  const auto cells = [](const std::vector<std::string>& row, const char* tag) {
    std::string out = "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i)
      out += fmt::format("<{0}{1}>{2}</{0}>", tag, i == 0 ? "" : " class=\"n\"", html_escaped(row[i]));
    return out + "</tr>\n";
  };
  std::string out = report_heading(table.heading) + "<div class=\"wide\"><table class=\"narrow\"><thead>" +
                    cells(table.columns, "th") + "</thead><tbody>\n";
  for (const auto& row : table.rows) out += cells(row, "td");
  return out + "</tbody></table></div>\n";
}

std::string report_candidates(const std::vector<ReportCandidate>& candidates) {
  if (candidates.empty()) return "";
  std::string out;
  std::string counts;
  for (const VerdictStyle& style : kVerdicts) {
    const auto count = std::count_if(candidates.begin(), candidates.end(),
                                     [&](const ReportCandidate& c) { return c.verdict == style.verdict; });
    if (count)
      counts += fmt::format("{}{} {} {}", counts.empty() ? "" : " · ", count, chip(style), style.meaning);
  }
  out += fmt::format("<h2>Grasp candidates ({})</h2>\n<p>{}</p>\n", candidates.size(), counts);
  out +=
      "<div class=\"wide\"><table><thead><tr><th class=\"n\">id</th><th>kind</th><th>verdict</th>"
      "<th class=\"n\">robot's share</th><th class=\"n\">cost</th><th class=\"n\">stability</th>"
      "<th class=\"n\">width</th><th>reason</th></tr></thead><tbody>\n";
  for (const ReportCandidate& c : in_order(candidates)) {
    const std::optional<double> percent = c.share ? std::optional(100 * *c.share) : std::nullopt;
    out += fmt::format(
        "<tr{}><td class=\"n\">{}</td><td>{}</td><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>"
        "<td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"why\">{}</td></tr>\n",
        c.verdict == planner::Verdict::Chosen ? " class=\"chosen\"" : "", c.id, html_escaped(c.kind),
        chip(style_of(c.verdict)), number(percent, "{:.1f} %"), number(c.cost, "{:.4g}"),
        number(c.stability, "{:.2f}"), number(100 * c.width_m, "{:.1f} cm"), html_escaped(c.reason));
  }
  return out + "</tbody></table></div>\n";
}

std::string report_pairs(const char* heading, const std::vector<std::pair<std::string, std::string>>& rows) {
  if (rows.empty()) return "";
  std::string out = fmt::format("<h2>{}</h2>\n<dl>\n", heading);
  for (const auto& [name, value] : rows)
    out += fmt::format("<dt>{}</dt><dd>{}</dd>\n", html_escaped(name), html_escaped(value));
  return out + "</dl>\n";
}

std::string report_list(const char* heading, const std::vector<std::string>& rows) {
  if (rows.empty()) return "";
  std::string out = fmt::format("<h2>{}</h2>\n<ul>\n", heading);
  for (const std::string& row : rows) out += fmt::format("<li>{}</li>\n", html_escaped(row));
  return out + "</ul>\n";
}

std::string report_times(const std::vector<ReportTime>& timing) {
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

std::string report_command(const std::string& command) {
  return command.empty() ? "" : fmt::format("<h2>Do it again</h2>\n<pre>{}</pre>\n", html_escaped(command));
}

}  // namespace colift::picture
