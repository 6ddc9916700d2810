#include "hal/config/field_table.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace colift::hal {
namespace {

template <class Items>
auto* find_path(Items& items, std::string_view path) {
  const auto found =
      std::find_if(items.begin(), items.end(), [&](const auto& item) { return item.path == path; });
  return found == items.end() ? nullptr : &*found;
}

/// Calls f with every number of a value.
template <class Function>
void for_each_number(const FieldValue& value, Function f) {
  std::visit(
      [&](const auto& v) {
        using T = std::decay_t<decltype(v)>;
        if constexpr (std::is_same_v<T, double>) {
          f(v);
        } else if constexpr (std::is_same_v<T, Vec3> || std::is_same_v<T, std::vector<double>>) {
          for (const double x : v) f(x);
        } else if constexpr (std::is_same_v<T, std::optional<double>>) {
          if (v) f(*v);
        } else if constexpr (std::is_same_v<T, std::optional<Vec3>>) {
          if (v) std::for_each(v->begin(), v->end(), f);
        }
      },
      value);
}

}  // namespace

const Field* FieldTable::find(std::string_view path) const {
  return find_path(fields_, path);
}

Field* FieldTable::find(std::string_view path) {
  return find_path(fields_, path);
}

const FieldGroup* FieldTable::find_group(std::string_view path) const {
  return find_path(groups_, path);
}

void FieldTable::check_name(const std::string& path) const {
  const std::size_t dot = path.rfind('.');
  const bool at_top = dot == std::string::npos;
  const std::string_view name = std::string_view(path).substr(at_top ? 0 : dot + 1);
  if (!at_top && !find_group(path.substr(0, dot))) {
    throw std::logic_error("configuration field \"" + path + "\" has a dot in its name");
  }
  const bool plain = !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
  });
  if (!plain) throw std::logic_error("configuration field \"" + path + "\" needs a name of a-z, 0-9 and _");
  if (find(path) || find_group(path))
    throw std::logic_error("configuration field \"" + path + "\" exists twice");
}

void FieldTable::add_field(Field field) {
  check_name(field.path);
  fields_.push_back(std::move(field));
}

void FieldTable::add_group(FieldGroup group) {
  check_name(group.path);
  groups_.push_back(std::move(group));
}

void FieldTable::add_renamed(RenamedField renamed) {
  if (find(renamed.old_path) || find_group(renamed.old_path))
    throw std::logic_error("configuration field \"" + renamed.old_path + "\" exists, so it is no old name");
  if (!find(renamed.path) && !find_group(renamed.path))
    throw std::logic_error("\"" + renamed.old_path + "\" was renamed to \"" + renamed.path +
                           "\", which does not exist (it has to be named before)");
  renamed_.push_back(std::move(renamed));
}

void TableVisitor::or_infinite(std::string_view name) {
  Field* field = table_.find(prefix_ + std::string(name));
  if (field == nullptr) throw std::logic_error("there is no field \"" + std::string(name) + "\"");
  field->may_be_infinite = true;
}

std::optional<std::string> FieldTable::renamed(std::string_view old_path) const {
  for (const RenamedField& each : renamed_) {
    if (old_path == each.old_path) return each.path;
    const bool below = old_path.size() > each.old_path.size() && old_path.starts_with(each.old_path) &&
                       old_path[each.old_path.size()] == '.';
    if (below) return each.path + std::string(old_path.substr(each.old_path.size()));
  }
  return std::nullopt;
}

bool FieldTable::has_renamed_below(std::string_view group) const {
  return std::any_of(renamed_.begin(), renamed_.end(), [&](const RenamedField& each) {
    return each.old_path.size() > group.size() && each.old_path.starts_with(group) &&
           each.old_path[group.size()] == '.';
  });
}

void TableVisitor::add_slot(std::string_view name, FieldSlot slot, Range range,
                            std::vector<std::string> choices, std::string_view help, Presence presence) {
  Field field;
  field.path = prefix_ + std::string(name);
  field.slot = std::move(slot);
  field.range = range;
  field.choices = std::move(choices);
  field.help = std::string(help);
  field.presence = presence;
  if (!std::holds_alternative<std::shared_ptr<StructList>>(field.slot)) {
    for_each_number(value_of(field), [&](double x) {
      field.may_be_nan = field.may_be_nan || std::isnan(x);
      field.may_be_infinite = field.may_be_infinite || std::isinf(x);
    });
  }
  table_.add_field(std::move(field));
}

FieldValue value_of(const Field& field) {
  return std::visit(
      [](const auto& slot) -> FieldValue {
        if constexpr (std::is_pointer_v<std::decay_t<decltype(slot)>>) {
          return *slot;
        } else {
          throw std::logic_error("a list of structs has no single value");
        }
      },
      field.slot);
}

}  // namespace colift::hal
