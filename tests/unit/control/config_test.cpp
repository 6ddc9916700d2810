#include <catch2/catch.hpp>
#include <cctype>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "control/config/config.hpp"
#include "hal/config/field_table.hpp"

namespace colift::control {
namespace {

using hal::Field;
using hal::FieldTable;

/// The numbers of one field; none for a truth value, a text or a list of structs.
std::vector<double> numbers_of(const Field& field) {
  if (std::holds_alternative<std::shared_ptr<hal::StructList>>(field.slot)) return {};
  const hal::FieldValue value = hal::value_of(field);
  if (const auto* i = std::get_if<int>(&value)) return {static_cast<double>(*i)};
  if (const auto* d = std::get_if<double>(&value)) return {*d};
  if (const auto* v = std::get_if<hal::Vec3>(&value)) return {v->x(), v->y(), v->z()};
  if (const auto* l = std::get_if<std::vector<double>>(&value)) return *l;
  if (const auto* d = std::get_if<std::optional<double>>(&value); d && *d) return {**d};
  if (const auto* v = std::get_if<std::optional<hal::Vec3>>(&value); v && *v)
    return {(**v).x(), (**v).y(), (**v).z()};
  return {};
}

bool holds_numbers(const Field& field) {
  return !std::holds_alternative<bool*>(field.slot) && !std::holds_alternative<std::string*>(field.slot) &&
         !std::holds_alternative<std::shared_ptr<hal::StructList>>(field.slot);
}

bool is_sentence(const std::string& help) {
  return help.size() > 10 && help.back() == '.' && !std::islower(static_cast<unsigned char>(help.front()));
}

TEST_CASE("every parameter says in a sentence what it is", "[config]") {
  Config config;
  const FieldTable table = hal::table_of(config);
  REQUIRE(table.fields().size() > 300);
  for (const Field& field : table.fields()) {
    INFO(field.path << ": \"" << field.help << "\"");
    CHECK(is_sentence(field.help));
  }
  for (const hal::FieldGroup& group : table.groups()) {
    INFO(group.path << ": \"" << group.help << "\"");
    CHECK(is_sentence(group.help));
  }
}

TEST_CASE("every number has a range, and its default lies in it", "[config]") {
  for (Config config : {Config{}, run_defaults()}) {
    const FieldTable table = hal::table_of(config);
    for (const Field& field : table.fields()) {
      if (!holds_numbers(field)) continue;
      INFO(field.path);
      CHECK((std::isfinite(field.range.low) || std::isfinite(field.range.high)));
      CHECK(field.range.low < field.range.high);
      for (const double number : numbers_of(field)) {
        INFO(number << " in [" << field.range.low << ", " << field.range.high << "]");
        if (std::isnan(number)) {
          CHECK(field.may_be_nan);
        } else {
          CHECK(number >= field.range.low);
          CHECK(number <= field.range.high);
        }
      }
    }
  }
}

}  // namespace
}  // namespace colift::control
