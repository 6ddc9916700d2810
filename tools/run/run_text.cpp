#include "tools/run/run_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "hal/types/units.hpp"
#include "tools/visualization/utf8.hpp"

namespace colift::tools {
namespace {

// Bytes of the first `columns` characters.
std::size_t bytes_of(std::string_view text, std::size_t columns) {
  std::size_t at = 0;
  while (at < text.size()) {
    if (columns-- == 0) return at;
    ++at;
    while (at < text.size() && picture::continues_character(text[at])) ++at;
  }
  return at;
}

}  // namespace

std::size_t columns_of(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return !picture::continues_character(c); }));
}

std::string one_line(const std::string& text, bool ascii) {
  std::string line = picture::valid_utf8(text);
  std::replace(line.begin(), line.end(), '\n', ' ');
  if (!ascii) return line;
  using Pair = std::pair<std::string_view, std::string_view>;
  constexpr std::array<Pair, 8> kRelatives{
      {{"°", " deg"}, {"·", "-"}, {"–", "-"}, {"±", "+-"}, {"×", "x"}, {"…", "..."}, {"²", "2"}, {"µ", "u"}}};
  std::string plain;
  for (std::size_t at = 0; at < line.size();) {
    const std::size_t next = at + bytes_of(std::string_view(line).substr(at), 1);
    const std::string_view character = std::string_view(line).substr(at, next - at);
    const auto relative = std::find_if(kRelatives.begin(), kRelatives.end(),
                                       [&](const Pair& p) { return p.first == character; });
    if (relative != kRelatives.end())
      plain += relative->second;
    else
      plain += character.size() == 1 ? character : "?";
    at = next;
  }
  return plain;
}

std::string cut(const std::string& text, std::size_t columns) {
  if (columns_of(text) <= columns) return text;
  if (columns <= 3) return text.substr(0, bytes_of(text, columns));
  return text.substr(0, bytes_of(text, columns - 3)) + "...";
}

std::vector<std::string> wrapped(const std::string& text, std::size_t columns) {
  columns = std::max<std::size_t>(1, columns);
  std::vector<std::string> lines;
  std::string line;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t end = std::min(text.find_first_of(" \n", at), text.size());
    std::string word = text.substr(at, end - at);
    at = end + 1;
    if (word.empty()) continue;
    if (!line.empty() && columns_of(line) + 1 + columns_of(word) > columns) {
      lines.push_back(std::move(line));
      line.clear();
    }
    while (columns_of(word) > columns) {
      const std::size_t fits = bytes_of(word, columns);
      lines.push_back(word.substr(0, fits));
      word.erase(0, fits);
    }
    line += (line.empty() ? "" : " ") + word;
  }
  if (!line.empty()) lines.push_back(std::move(line));
  return lines;
}

std::string entry(const std::string& heading, const std::string& text, std::size_t heading_width,
                  std::size_t columns) {
  const std::size_t room = columns > heading_width + 10 ? columns - heading_width : 10;
  std::string out = cut(heading, heading_width);
  out.append(heading_width - columns_of(out), ' ');
  bool first = true;
  for (const std::string& line : wrapped(text, room)) {
    if (!first) out += std::string(heading_width, ' ');
    out += line + '\n';
    first = false;
  }
  if (!first) return out;
  while (!out.empty() && out.back() == ' ') out.pop_back();
  return out + '\n';
}

std::string metres_text(double m) {
  if (!std::isfinite(m)) return "unknown";
  if (std::abs(m) < 0.0195) return fmt::format("{} mm", std::lround(1e3 * m));
  return std::abs(m) < 0.995 ? fmt::format("{:.1f} cm", 100 * m) : fmt::format("{:.2f} m", m);
}

std::string degrees_text(double rad) {
  return std::isfinite(rad) ? fmt::format("{:.1f}°", hal::rad_to_deg(rad)) : "unknown";
}

std::string percent_text(double part) {
  return std::isfinite(part) ? fmt::format("{:.0f} %", 100 * part) : "unknown";
}

std::string share_95_text(const control::LiftSummary& lift) {
  if (!lift.load) return "";
  return fmt::format(", {:.0f} to {:.0f} %", 100 * lift.load->share_95.low, 100 * lift.load->share_95.high);
}

std::string mass_95_text(const control::LiftSummary& lift) {
  if (!lift.load) return "not known" + (lift.load_reason.empty() ? "" : ": " + lift.load_reason);
  const control::LoadEstimate& load = *lift.load;
  const auto by = [&] {
    switch (load.source) {
      case control::MassSource::Told:
        return "as told";
      case control::MassSource::TestLift:
        return "by the centre of gravity that test lifts found";
      case control::MassSource::Shape:
        break;
    }
    return "if it is where the shape has its centre of gravity";
  };
  return fmt::format("{:.2f} kg, {:.1f} to {:.1f} kg, {}", load.mass_kg, load.mass_95.low, load.mass_95.high,
                     by());
}

std::string place_text(const hal::Vec3& p) {
  // no minus before a zero
  const hal::Vec3 cm = (100.0 * p).array().round() + 0.0;
  return fmt::format("({:.2f}, {:.2f}, {:.2f}) m", 0.01 * cm.x(), 0.01 * cm.y(), 0.01 * cm.z());
}

}  // namespace colift::tools
