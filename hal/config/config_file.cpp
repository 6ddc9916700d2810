#include "hal/config/config_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <map>
#include <memory>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

#include "hal/config/field_value.hpp"
#include "hal/config/nearest_name.hpp"
#include "hal/config/yaml_tree.hpp"

namespace colift::hal {
namespace {

using Kind = YamlNode::Kind;
using ListSlot = std::shared_ptr<StructList>;

std::string joined(std::string_view group, std::string_view name) {
  return group.empty() ? std::string(name) : fmt::format("{}.{}", group, name);
}

bool is_directly_in(std::string_view path, std::string_view group) {
  if (group.empty()) return path.find('.') == std::string_view::npos;
  return path.size() > group.size() + 1 && path.starts_with(group) && path[group.size()] == '.' &&
         path.find('.', group.size() + 1) == std::string_view::npos;
}

/// The names that may stand in a group, a few of them.
std::string names_in(const FieldTable& table, std::string_view group) {
  constexpr std::size_t kShown = 12;
  std::vector<std::string> names;
  const auto collect = [&](const auto& items) {
    for (const auto& item : items)
      if (is_directly_in(item.path, group)) names.push_back(item.path.substr(item.path.rfind('.') + 1));
  };
  collect(table.groups());
  collect(table.fields());
  const std::size_t shown = std::min(kShown, names.size());
  const std::size_t left = names.size() - shown;
  return fmt::format("{}{}",
                     fmt::join(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(shown), ", "),
                     left > 0 ? fmt::format(" and {} more", left) : "");
}

std::string unknown_name(const FieldTable& table, std::string_view group, const std::string& path,
                         const std::string& around, bool in_file) {
  std::vector<std::string> known;
  for (const Field& field : table.fields()) known.push_back(field.path);
  for (const FieldGroup& each : table.groups()) known.push_back(each.path);
  const std::string found = fmt::format("unknown key \"{}{}\"", around, quotable(path));
  if (in_file && std::find(known.begin(), known.end(), path) != known.end()) {
    return found + "; in a file the dots are written as nested groups";
  }
  if (const auto nearest = nearest_path(path, known))
    return fmt::format("{}; did you mean \"{}{}\"?", found, around, *nearest);
  const std::string names = names_in(table, group);
  if (names.empty()) return found + "; nothing can be set here";
  return fmt::format("{}; known {}: {}", found, group.empty() && around.empty() ? "at the top" : "here",
                     names);
}

/// Checks a document against a table and remembers what to write; nothing is written before all of it is
/// accepted.
class Change {
 public:
  /// Of a file or text `name`; origins are its lines.
  Change(const YamlTree& tree, std::string name, UnknownKeys unknown)
      : tree_(tree), name_(std::move(name)), unknown_(unknown) {}
  /// Of one value; `name` is where it came from in full, `origin` in short.
  Change(const YamlTree& tree, std::string name, std::string origin)
      : tree_(tree), name_(std::move(name)), origin_(std::move(origin)) {}

  /// `around` names the list element that the table stands for, "parts[1].", or is empty.
  Result<> read_group(FieldTable& table, const std::string& group, const std::string& around,
                      std::uint32_t index, YamlPlace key_place, int depth) {
    const YamlNode& node = tree_.at(index);
    if (node.kind == Kind::Null) return {};
    const std::string full = around + group;
    const std::string subject = full.empty()          ? "the configuration"
                                : full.ends_with('.') ? full.substr(0, full.size() - 1)
                                                      : full;
    if (node.kind != Kind::Map) {
      return refuse(node.place, fmt::format("{} expects a group of settings ({}), but found {}", subject,
                                            names_in(table, group), description(node)));
    }
    if (depth > kMaxYamlDepth)
      return refuse(key_place, fmt::format("{} is nested deeper than {} levels", subject, kMaxYamlDepth));

    std::map<std::string_view, int> first_line;
    for (std::size_t i = 0; i + 1 < node.children.size(); i += 2) {
      const YamlNode& key = tree_.at(node.children[i]);
      if (++visited_ > kMaxYamlNodes)
        return refuse(key.place, fmt::format("more than {} values", kMaxYamlNodes));
      const std::string path = joined(group, key.text);
      const auto [before, is_new] = first_line.emplace(key.text, key.place.line);
      if (!is_new) {
        return refuse(key.place, fmt::format("{}{} is given twice, first in line {}", around, quotable(path),
                                             before->second));
      }
      if (auto done = read_key(table, group, path, around, key, node.children[i + 1], depth); !done)
        return done;
    }
    return {};
  }

  /// What stands under one key, which may be an old name.
  Result<> read_key(FieldTable& table, const std::string& group, const std::string& path,
                    const std::string& around, const YamlNode& key, std::uint32_t index, int depth) {
    const bool nested_name = key.text.find('.') != std::string::npos;
    std::string today = path;
    const bool known = !nested_name && (table.find(path) || table.find_group(path));
    if (!known && !nested_name) {
      if (auto renamed = table.renamed(path)) {
        today = std::move(*renamed);
        warn_of_old_name(around + path, around + today, key.place);
      }
    }
    if (nested_name) today.clear();
    if (Field* field = table.find(today)) return read_field(*field, around, index, key.place, depth);
    if (table.find_group(today) || (!nested_name && table.has_renamed_below(today)))
      return read_group(table, today, around, index, key.place, depth + 1);
    std::string objection = unknown_name(table, group, path, around, is_file());
    if (unknown_ == UnknownKeys::Refused) return refuse(key.place, std::move(objection));
    warnings_.push_back(fmt::format("{}: {}; it is left out", place_text(name_, key.place), objection));
    return {};
  }

  Result<> read_field(Field& field, const std::string& around, std::uint32_t index, YamlPlace key_place,
                      int depth) {
    const auto is_it = [&](const auto& written) { return written.field == &field; };
    if (std::any_of(values_.begin(), values_.end(), is_it) ||
        std::any_of(lists_.begin(), lists_.end(), is_it))
      return refuse(key_place,
                    fmt::format("{}{} is given under its old and its new name", around, field.path));
    if (std::holds_alternative<ListSlot>(field.slot))
      return read_list(field, around, index, key_place, depth);
    auto value = read_value(field, tree_, index);
    if (!value) {
      // an empty value has no place of its own
      const YamlPlace place = tree_.at(index).kind == Kind::Null ? key_place : value.error().place;
      return refuse(place, fmt::format("{}{} {}", around, field.path, value.error().reason));
    }
    visited_ += tree_.at(index).children.size();
    values_.push_back({&field, std::move(*value), origin(key_place)});
    return {};
  }

  /// A value that needs no YAML, from --set of a text field.
  Result<> take_text(Field& field, const std::string& around, std::string text) {
    FieldValue value(std::move(text));
    if (const auto objection = objection_to(field, value))
      return refuse({}, fmt::format("{}{} {}", around, field.path, *objection));
    values_.push_back({&field, std::move(value), origin({})});
    return {};
  }

  void warn_of_old_name(const std::string& old_path, const std::string& path, YamlPlace place) {
    warnings_.push_back(fmt::format("{}: {} is called {} now; the old name is still read",
                                    is_file() ? place_text(name_, place) : name_, quotable(old_path), path));
  }

  /// Writes what was accepted; warnings go to the table of the whole configuration.
  void commit(FieldTable& table) {
    for (std::string& warning : warnings_) table.warnings.push_back(std::move(warning));
    for (auto& [field, value, origin] : values_) {
      write_value(*field, value);
      field->origin = origin;
    }
    // an inner list was put down before the list that it stands in
    for (auto& [field, items, origin] : lists_) {
      std::get<ListSlot>(field->slot)->take(*items);
      field->origin = origin;
    }
  }

 private:
  struct NewValue {
    Field* field;
    FieldValue value;
    std::string origin;
  };
  struct NewList {
    Field* field;
    std::unique_ptr<StructList> items;
    std::string origin;
  };

  Result<> refuse(YamlPlace place, std::string reason) const {
    return failure(ErrorCode::BadConfig, is_file() ? place_text(name_, place) : name_, std::move(reason));
  }

  [[nodiscard]] std::string origin(YamlPlace place) const {
    return is_file() ? fmt::format("{}:{}", name_, place.line) : origin_;
  }

  Result<> read_list(Field& field, const std::string& around, std::uint32_t index, YamlPlace key_place,
                     int depth) {
    const YamlNode& node = tree_.at(index);
    const std::string full = around + field.path;
    if (node.kind != Kind::List) {
      const YamlPlace place = node.kind == Kind::Null ? key_place : node.place;
      return refuse(place,
                    fmt::format("{} expects {}, but found {}", full, expectation(field), description(node)));
    }
    visited_ += node.children.size();
    if (visited_ > kMaxYamlNodes)
      return refuse(key_place, fmt::format("{} holds more than {} values", full, kMaxYamlNodes));
    auto items = std::get<ListSlot>(field.slot)->fresh(node.children.size());
    for (std::size_t i = 0; i < node.children.size(); ++i) {
      // the elements are new and nobody sees them yet: they may be written at once
      FieldTable table = items->element(i);
      const YamlNode& child = tree_.at(node.children[i]);
      const std::string element = fmt::format("{}[{}].", full, i);
      Change change(tree_, name_, unknown_);
      change.origin_ = origin_;
      change.visited_ = visited_;
      change.warnings_ = std::move(warnings_);
      if (auto done = change.read_group(table, "", element, node.children[i], child.place, depth + 1); !done)
        return done;
      visited_ = change.visited_;
      warnings_ = std::exchange(change.warnings_, {});
      change.commit(table);
      for (const Field& each : table.fields()) {
        if (each.presence == Presence::Required && each.origin == kDefaultOrigin) {
          return refuse(child.place,
                        fmt::format("{}{} is missing, expected {}", element, each.path, expectation(each)));
        }
      }
    }
    lists_.push_back({&field, std::move(items), origin(key_place)});
    return {};
  }

  const YamlTree& tree_;
  [[nodiscard]] bool is_file() const { return origin_.empty(); }

  std::string name_, origin_;
  UnknownKeys unknown_ = UnknownKeys::Refused;
  std::vector<std::string> warnings_;
  std::size_t visited_ = 0;
  std::vector<NewValue> values_;
  std::vector<NewList> lists_;
};

/// "parts[12]" -> "parts", 12. Nothing when the text is no indexed name.
struct Indexed {
  std::string_view list;
  std::size_t index;
  std::string_view rest;  // after "]."
};

std::optional<Indexed> split_index(std::string_view path) {
  const std::size_t open = path.find('[');
  const std::size_t close = path.find("].");
  if (open == std::string_view::npos || close == std::string_view::npos || close < open) return std::nullopt;
  Indexed out{path.substr(0, open), 0, path.substr(close + 2)};
  const char* last = path.data() + close;
  const auto [end, error] = std::from_chars(path.data() + open + 1, last, out.index);
  if (error != std::errc() || end != last) return std::nullopt;
  return out;
}

/// What a default element may be differs from what an element holds now: NaN is allowed by the former alone.
FieldTable element_at(StructList& list, std::size_t index) {
  FieldTable table = list.element(index);
  const auto blank = list.fresh(1);
  const FieldTable reference = blank->element(0);
  for (std::size_t i = 0; i < std::min(table.fields().size(), reference.fields().size()); ++i) {
    table.fields()[i].may_be_nan = reference.fields()[i].may_be_nan;
    table.fields()[i].may_be_infinite = reference.fields()[i].may_be_infinite;
  }
  return table;
}

/// The first value of a table that must not be, "parts[1].mass is -1, but ...".
std::optional<std::string> objection_to_fields(const FieldTable& table, const std::string& around) {
  for (const Field& field : table.fields()) {
    const std::string full = around + field.path;
    if (const auto* list = std::get_if<ListSlot>(&field.slot)) {
      for (std::size_t i = 0; i < (*list)->size(); ++i) {
        auto objection = objection_to_fields(element_at(**list, i), fmt::format("{}[{}].", full, i));
        if (objection) return objection;
      }
    } else if (const auto objection = objection_to(field, value_of(field))) {
      return fmt::format("{} {} ({})", full, *objection, field.origin);
    }
  }
  return std::nullopt;
}

Result<> apply_at(FieldTable& table, std::string path, const std::string& around, std::string_view value,
                  const std::string& where, const std::string& origin) {
  const auto refuse = [&](std::string reason) {
    return failure(ErrorCode::BadConfig, where, std::move(reason));
  };
  if (const auto indexed = split_index(path)) {
    Field* list = table.find(indexed->list);
    const auto* slot = list ? std::get_if<ListSlot>(&list->slot) : nullptr;
    if (!list) return refuse(unknown_name(table, "", std::string(indexed->list), around, false));
    if (!slot)
      return refuse(
          fmt::format("{}{} is no list of groups, so it has no [{}]", around, list->path, indexed->index));
    const std::size_t size = (*slot)->size();
    if (indexed->index >= size) {
      return refuse(fmt::format("{}{}[{}] does not exist: the list has {} entries, counted from 0", around,
                                list->path, indexed->index, size));
    }
    FieldTable element = element_at(**slot, indexed->index);
    auto done = apply_at(element, std::string(indexed->rest),
                         fmt::format("{}{}[{}].", around, list->path, indexed->index), value, where, origin);
    if (done) list->origin = origin;
    return done;
  }

  const std::string given = path;
  if (!table.find(path) && !table.find_group(path)) path = table.renamed(path).value_or(path);
  Field* field = table.find(path);
  if (!field && !table.find_group(path)) {
    for (const Field& list : table.fields()) {
      const bool below = path.starts_with(list.path + '.') || path.starts_with(list.path + '[');
      if (below && std::holds_alternative<ListSlot>(list.slot)) {
        return refuse(
            fmt::format("{0}{1} is a list of groups; one value in it is {0}{1}[0].NAME", around, list.path));
      }
    }
    const std::size_t dot = path.rfind('.');
    const std::string group = dot == std::string::npos ? "" : path.substr(0, dot);
    return refuse(unknown_name(table, table.find_group(group) ? group : "", path, around, false));
  }
  const std::size_t first = value.find_first_not_of(" \t");
  const bool quoted = first != std::string_view::npos && (value[first] == '"' || value[first] == '\'');
  const bool as_it_stands = field && std::holds_alternative<std::string*>(field->slot) && !quoted;

  auto tree = parse_yaml(as_it_stands ? "" : value, where);
  if (!tree) return refuse(tree.error().detail);
  Change change(*tree, where, origin);
  if (path != given) change.warn_of_old_name(around + given, around + path, {});
  Result<> done = as_it_stands ? change.take_text(*field, around, std::string(value))
                  : field      ? change.read_field(*field, around, tree->root, {}, 0)
                               : change.read_group(table, path, around, tree->root, {}, 0);
  if (done) change.commit(table);
  return done;
}

}  // namespace

Result<std::string> read_yaml_file(const std::filesystem::path& path) {
  const auto refuse = [&](std::string reason) {
    return failure(ErrorCode::BadConfig, quotable(path.string(), 300), std::move(reason));
  };
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) return refuse("there is no such file");
  if (status.type() == std::filesystem::file_type::directory)
    return refuse("this is a directory, expected a YAML file");

  constexpr auto kClose = [](std::FILE* f) { std::fclose(f); };
  const std::unique_ptr<std::FILE, decltype(kClose)> file(std::fopen(path.c_str(), "rb"), kClose);
  if (!file) return refuse(fmt::format("cannot be opened: {}", std::generic_category().message(errno)));
  // one byte more than allowed tells a file that is too large, also when it has no size (a pipe)
  std::string text(kMaxYamlBytes + 1, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file.get()));
  if (std::ferror(file.get()) != 0)
    return refuse(fmt::format("cannot be read: {}", std::generic_category().message(errno)));
  return text;
}

Result<> apply_yaml_file(FieldTable& table, const std::filesystem::path& path) {
  const auto text = read_yaml_file(path);
  if (!text) return tl::unexpected(text.error());
  return apply_yaml_text(table, *text, quotable(path.string(), 300));
}

Result<> apply_yaml_text(FieldTable& table, std::string_view text, const std::string& name,
                         UnknownKeys unknown) {
  return parse_yaml(text, name).and_then([&](const YamlTree& tree) {
    return apply_yaml_tree(table, tree, name, unknown);
  });
}

Result<> apply_yaml_tree(FieldTable& table, const YamlTree& tree, const std::string& name,
                         UnknownKeys unknown) {
  Change change(tree, name, unknown);
  if (auto done = change.read_group(table, "", "", tree.root, tree.at(tree.root).place, 0); !done)
    return done;
  change.commit(table);
  return {};
}

Result<> apply_value(FieldTable& table, const std::string& path, std::string_view value,
                     const std::string& where, const std::string& origin) {
  return apply_at(table, path, "", value, where, origin);
}

Result<> apply_setting(FieldTable& table, std::string_view setting) {
  const std::string where = "--set " + quotable(setting, 80);
  const std::size_t equals = setting.find('=');
  if (equals == std::string_view::npos || equals == 0) {
    return failure(ErrorCode::BadConfig, where, "a setting is written name=value, for example \"a.b=0.5\"");
  }
  std::string_view path = setting.substr(0, equals);
  while (path.ends_with(' ')) path.remove_suffix(1);
  while (path.starts_with(' ')) path.remove_prefix(1);
  if (path.empty()) return failure(ErrorCode::BadConfig, where, "there is no name before the \"=\"");
  return apply_at(table, std::string(path), "", setting.substr(equals + 1), where, "--set");
}

Result<> check_fields(const FieldTable& table, const std::string& name) {
  for (const Field& field : table.fields()) {
    if (field.presence == Presence::Required && field.origin == kDefaultOrigin) {
      return failure(ErrorCode::BadConfig, name,
                     fmt::format("{} is missing, expected {}", field.path, expectation(field)));
    }
  }
  if (const auto objection = objection_to_fields(table, ""))
    return failure(ErrorCode::BadConfig, name, *objection);
  return {};
}

Result<> apply_command_line(FieldTable& table, std::span<const std::string> files,
                            std::span<const std::string> settings) {
  for (const std::string& file : files) {
    if (auto done = apply_yaml_file(table, file); !done) return done;
  }
  for (const std::string& setting : settings) {
    if (auto done = apply_setting(table, setting); !done) return done;
  }
  return check_fields(table);
}

}  // namespace colift::hal
