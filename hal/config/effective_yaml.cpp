#include "hal/config/effective_yaml.hpp"

#include <fmt/format.h>

#include <limits>
#include <utility>

#include "hal/config/field_value.hpp"
#include "hal/config/yaml_tree.hpp"

namespace colift::hal {
namespace {

constexpr std::size_t kWholeText = std::numeric_limits<std::size_t>::max();

struct Style {
  bool with_help = false;
  bool with_origin = true;
};

std::vector<std::string> split(const std::string& path) {
  std::vector<std::string> names;
  std::size_t from = 0;
  for (std::size_t dot = path.find('.'); dot != std::string::npos; dot = path.find('.', from)) {
    names.push_back(path.substr(from, dot - from));
    from = dot + 1;
  }
  names.push_back(path.substr(from));
  return names;
}

/// The unit that the end of a name says; empty: none.
std::string_view unit_of(std::string_view name) {
  constexpr std::pair<std::string_view, std::string_view> kUnits[] = {{"_nm_rad", "N m/rad"},
                                                                      {"_rad_s3", "rad/s^3"},
                                                                      {"_rad_s2", "rad/s^2"},
                                                                      {"_rad_s", "rad/s"},
                                                                      {"_per_m", "1/m"},
                                                                      {"_deg_s", "deg/s"},
                                                                      {"_m_s2", "m/s^2"},
                                                                      {"_m_s", "m/s"},
                                                                      {"_nm", "N m"},
                                                                      {"_deg", "deg"},
                                                                      {"_rad", "rad"},
                                                                      {"_kg", "kg"},
                                                                      {"_px", "px"},
                                                                      {"_ms", "ms"},
                                                                      {"_mm", "mm"},
                                                                      {"_hz", "Hz"},
                                                                      {"_n", "N"},
                                                                      {"_m", "m"},
                                                                      {"_s", "s"}};
  for (const auto& [ending, unit] : kUnits)
    if (name.ends_with(ending)) return unit;
  return {};
}

class Writer {
 public:
  explicit Writer(Style style) : style_(style) {}

  std::string text;

  void write(const FieldTable& table, int indent) {
    std::vector<std::string> open;  // the groups that the last line stands in
    for (const Field& field : table.fields()) {
      std::vector<std::string> names = split(field.path);
      const std::string leaf = std::move(names.back());
      names.pop_back();
      std::size_t shared = 0;
      while (shared < open.size() && shared < names.size() && open[shared] == names[shared]) ++shared;
      for (std::size_t i = shared; i < names.size(); ++i) open_group(table, names, i, indent);
      open = std::move(names);
      write_field(field, leaf, indent + 2 * static_cast<int>(open.size()));
    }
  }

 private:
  void line(int indent, const std::string& content) {
    text += std::string(static_cast<std::size_t>(indent), ' ') + content + '\n';
  }

  void open_group(const FieldTable& table, const std::vector<std::string>& names, std::size_t depth,
                  int indent) {
    const int here = indent + 2 * static_cast<int>(depth);
    if (style_.with_help) {
      std::string path = names[0];
      for (std::size_t i = 1; i <= depth; ++i) path += '.' + names[i];
      const FieldGroup* group = table.find_group(path);
      if (depth == 0 && !text.empty()) text += '\n';
      if (group && !group->help.empty()) line(here, "# " + quotable(group->help, kWholeText));
    }
    line(here, names[depth] + ":");
  }

  void write_field(const Field& field, const std::string& leaf, int indent) {
    if (style_.with_help) {
      const std::string_view unit = unit_of(leaf);
      line(indent, fmt::format("# {} ({}{}{})", quotable(field.help, kWholeText), expectation(field),
                               unit.empty() ? "" : "; ", unit));
    }
    const std::string origin = style_.with_origin ? "  # " + quotable(field.origin, kWholeText) : "";
    if (const auto* list = std::get_if<std::shared_ptr<StructList>>(&field.slot)) {
      write_list(**list, leaf, origin, indent);
    } else {
      line(indent, fmt::format("{}: {}{}", leaf, value_text(value_of(field)), origin));
    }
  }

  void write_list(StructList& list, const std::string& leaf, const std::string& origin, int indent) {
    if (list.size() == 0) return line(indent, leaf + ": []" + origin);
    line(indent, leaf + ":" + origin);
    for (std::size_t i = 0; i < list.size(); ++i) {
      Writer element({.with_help = false, .with_origin = false});
      element.write(list.element(i), indent + 4);
      if (element.text.empty()) {
        line(indent + 2, "- {}");
      } else {
        element.text[static_cast<std::size_t>(indent) + 2] = '-';
        text += element.text;
      }
    }
  }

  Style style_;
};

}  // namespace

std::string effective_yaml(const FieldTable& table, bool with_help) {
  Writer writer({.with_help = with_help, .with_origin = true});
  writer.write(table, 0);
  return writer.text;
}

}  // namespace colift::hal
