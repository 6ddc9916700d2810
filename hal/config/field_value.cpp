#include "hal/config/field_value.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <system_error>
#include <type_traits>
#include <utility>

namespace colift::hal {
namespace {

using Kind = YamlNode::Kind;

template <class T>
using Read = tl::expected<T, Objection>;

std::string number_text(double x) {
  if (std::isnan(x)) return ".nan";
  if (std::isinf(x)) return x < 0 ? "-.inf" : ".inf";
  char buffer[32];
  const auto end =
      std::to_chars(buffer, buffer + sizeof buffer, x).ptr;  // shortest text that reads back the same
  return {buffer, end};
}

/// " from 0 to 90", empty for any number.
std::string range_text(const Range& range) {
  const bool low = std::isfinite(range.low);
  const bool high = std::isfinite(range.high);
  const bool positive = range.low == kPositive.low;
  if (positive && high) return fmt::format(" greater than 0 and at most {}", number_text(range.high));
  if (low && high) return fmt::format(" from {} to {}", number_text(range.low), number_text(range.high));
  if (positive) return " greater than 0";
  if (low) return fmt::format(" of at least {}", number_text(range.low));
  if (high) return fmt::format(" of at most {}", number_text(range.high));
  return "";
}

template <class... Texts>
bool is_one_of(std::string_view text, Texts... texts) {
  return ((text == texts) || ...);
}

/// YAML 1.2's core schema: 1, -2.5e3, .inf, .nan. Nothing when the text is no number.
std::optional<double> parse_double(std::string_view text, bool& too_large) {
  if (is_one_of(text, ".nan", ".NaN", ".NAN")) return std::numeric_limits<double>::quiet_NaN();
  const bool sign = !text.empty() && (text[0] == '-' || text[0] == '+');
  const std::string_view digits = sign ? text.substr(1) : text;
  const double direction = sign && text[0] == '-' ? -1.0 : 1.0;
  if (is_one_of(digits, ".inf", ".Inf", ".INF")) return direction * std::numeric_limits<double>::infinity();
  // from_chars would take "inf", "nan" and a second sign
  if (digits.empty() || !((digits[0] >= '0' && digits[0] <= '9') || digits[0] == '.')) return std::nullopt;
  double value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (end != digits.data() + digits.size() || error == std::errc::invalid_argument) return std::nullopt;
  too_large = error == std::errc::result_out_of_range;
  return direction * value;
}

std::optional<std::string> objection_to_number(const Field& field, double x) {
  if (std::isnan(x)) {
    if (field.may_be_nan) return std::nullopt;
    return fmt::format("expects {}, but found .nan", expectation(field));
  }
  const bool in_range = x >= field.range.low && x <= field.range.high;
  if (std::isinf(x) && !(field.may_be_infinite && in_range)) {
    return fmt::format("expects {} that is finite, but found {}", expectation(field), number_text(x));
  }
  if (in_range) return std::nullopt;
  return fmt::format("is {}, but has to be a number{}", number_text(x), range_text(field.range));
}

std::string number_of_list(std::size_t index) {
  return fmt::format(" (number {} of the list)", index + 1);
}

class Reader {
 public:
  Reader(const Field& field, const YamlTree& tree) : field_(field), tree_(tree) {}

  Read<bool> read(std::uint32_t index, const bool*) const {
    const YamlNode& node = tree_.at(index);
    if (node.kind == Kind::Plain && is_one_of(node.text, "true", "True", "TRUE")) return true;
    if (node.kind == Kind::Plain && is_one_of(node.text, "false", "False", "FALSE")) return false;
    return wrong_type(node);
  }

  Read<int> read(std::uint32_t index, const int*) const {
    const YamlNode& node = tree_.at(index);
    if (node.kind != Kind::Plain) return wrong_type(node);
    std::string_view digits = node.text;
    if (digits.starts_with('+') && !digits.starts_with("+-")) digits.remove_prefix(1);
    int value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (end != digits.data() + digits.size() || error == std::errc::invalid_argument) return wrong_type(node);
    if (error == std::errc::result_out_of_range) return does_not_fit(node);
    return value;
  }

  Read<double> read(std::uint32_t index, const double*) const {
    const YamlNode& node = tree_.at(index);
    if (node.kind != Kind::Plain) return wrong_type(node);
    bool too_large = false;
    const auto value = parse_double(node.text, too_large);
    if (!value) return wrong_type(node);
    if (too_large) return does_not_fit(node);
    return *value;
  }

  Read<std::string> read(std::uint32_t index, const std::string*) const {
    const YamlNode& node = tree_.at(index);
    if (node.kind != Kind::Plain && node.kind != Kind::Quoted) return wrong_type(node);
    return node.text;
  }

  Read<std::vector<double>> read(std::uint32_t index, const std::vector<double>*) const {
    const YamlNode& node = tree_.at(index);
    if (node.kind != Kind::List) return wrong_type(node);
    std::vector<double> values;
    values.reserve(node.children.size());
    for (const std::uint32_t child : node.children) {
      const auto value = read(child, static_cast<const double*>(nullptr));
      // the file's person wants the number's place, not the list's
      const auto objection =
          value ? objection_to_number(field_, *value) : std::optional(value.error().reason);
      if (objection) {
        return tl::unexpected(Objection{tree_.at(child).place, *objection + number_of_list(values.size())});
      }
      values.push_back(*value);
    }
    return values;
  }

  Read<Vec3> read(std::uint32_t index, const Vec3*) const {
    const auto values = read(index, static_cast<const std::vector<double>*>(nullptr));
    if (!values) return tl::unexpected(values.error());
    if (values->size() != 3) return wrong_type(tree_.at(index));
    return Vec3((*values)[0], (*values)[1], (*values)[2]);
  }

  template <class T>
  Read<std::optional<T>> read(std::uint32_t index, const std::optional<T>*) const {
    if (tree_.at(index).kind == Kind::Null) return std::optional<T>();
    const auto value = read(index, static_cast<const T*>(nullptr));
    if (!value) return tl::unexpected(value.error());
    return std::optional<T>(*value);
  }

 private:
  tl::unexpected<Objection> wrong_type(const YamlNode& node) const {
    return tl::unexpected(Objection{
        node.place, fmt::format("expects {}, but found {}", expectation(field_), description(node))});
  }

  tl::unexpected<Objection> does_not_fit(const YamlNode& node) const {
    return tl::unexpected(
        Objection{node.place, fmt::format("expects {}, but {} is beyond what a computer's number holds",
                                          expectation(field_), quotable(node.text, 40))});
  }

  const Field& field_;
  const YamlTree& tree_;
};

template <class Numbers>
std::optional<std::string> objection_to_numbers(const Field& field, const Numbers& numbers) {
  for (int i = 0; i < static_cast<int>(numbers.size()); ++i) {
    if (auto objection = objection_to_number(field, numbers[i])) {
      return *objection + number_of_list(static_cast<std::size_t>(i));
    }
  }
  return std::nullopt;
}

std::string text_in_yaml(const std::string& text) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const bool plain = !text.empty() && letter(text[0]) && std::all_of(text.begin(), text.end(), [&](char c) {
    return letter(c) || (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '.' || c == '/';
  });
  // these would be something else to other YAML readers
  std::string lower = text;
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  const bool special = is_one_of(lower, "null", "true", "false", "yes", "no", "on", "off", "y", "n");
  if (plain && !special) return text;

  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (byte < 0x20 || byte == 0x7F) {
      out += fmt::format("\\x{:02x}", unsigned{byte});
    } else {
      out += c;
    }
  }
  return out + '"';
}

template <class Numbers>
std::string list_text(const Numbers& numbers) {
  std::string out = "[";
  for (int i = 0; i < static_cast<int>(numbers.size()); ++i) {
    if (i > 0) out += ", ";
    out += number_text(numbers[i]);
  }
  return out + "]";
}

struct ValueText {
  std::string operator()(bool v) const { return v ? "true" : "false"; }
  std::string operator()(int v) const { return fmt::format("{}", v); }
  std::string operator()(double v) const { return number_text(v); }
  std::string operator()(const std::string& v) const { return text_in_yaml(v); }
  std::string operator()(const Vec3& v) const { return list_text(v); }
  std::string operator()(const std::vector<double>& v) const { return list_text(v); }
  template <class T>
  std::string operator()(const std::optional<T>& v) const {
    return v ? (*this)(*v) : "~";
  }
};

}  // namespace

tl::expected<FieldValue, Objection> read_value(const Field& field, const YamlTree& tree, std::uint32_t node) {
  const Reader reader(field, tree);
  auto value = std::visit(
      [&](const auto& slot) -> tl::expected<FieldValue, Objection> {
        using T = std::decay_t<decltype(slot)>;
        if constexpr (std::is_pointer_v<T>) {
          auto read = reader.read(node, static_cast<const std::remove_pointer_t<T>*>(nullptr));
          if (!read) return tl::unexpected(read.error());
          return FieldValue(std::move(*read));
        } else {
          throw std::logic_error("a list of structs has no single value");
        }
      },
      field.slot);
  if (value) {
    if (auto objection = objection_to(field, *value)) {
      return tl::unexpected(Objection{tree.at(node).place, std::move(*objection)});
    }
  }
  return value;
}

std::optional<std::string> objection_to(const Field& field, const FieldValue& value) {
  return std::visit(
      [&](const auto& v) -> std::optional<std::string> {
        using T = std::decay_t<decltype(v)>;
        if constexpr (std::is_same_v<T, double> || std::is_same_v<T, int>) {
          return objection_to_number(field, v);
        } else if constexpr (std::is_same_v<T, Vec3> || std::is_same_v<T, std::vector<double>>) {
          return objection_to_numbers(field, v);
        } else if constexpr (std::is_same_v<T, std::optional<double>>) {
          return v ? objection_to_number(field, *v) : std::nullopt;
        } else if constexpr (std::is_same_v<T, std::optional<Vec3>>) {
          return v ? objection_to_numbers(field, *v) : std::nullopt;
        } else if constexpr (std::is_same_v<T, std::string>) {
          const bool allowed = field.choices.empty() || std::find(field.choices.begin(), field.choices.end(),
                                                                  v) != field.choices.end();
          if (!is_utf8(v))
            return fmt::format("expects {} in UTF-8, but found \"{}\"", expectation(field), quotable(v, 40));
          if (allowed) return std::nullopt;
          return fmt::format("expects {}, but found \"{}\"", expectation(field), quotable(v, 40));
        } else {
          return std::nullopt;
        }
      },
      value);
}

void write_value(const Field& field, const FieldValue& value) {
  std::visit(
      [&](const auto& slot) {
        using T = std::decay_t<decltype(slot)>;
        if constexpr (std::is_pointer_v<T>) {
          *slot = std::get<std::remove_pointer_t<T>>(value);
        } else {
          throw std::logic_error("a list of structs has no single value");
        }
      },
      field.slot);
}

std::string value_text(const FieldValue& value) {
  return std::visit(ValueText{}, value);
}

std::string expectation(const Field& field) {
  const std::string range = range_text(field.range);
  struct Expectation {
    const Field& field;
    const std::string& range;

    std::string operator()(const bool*) const { return "true or false"; }
    std::string operator()(const int*) const { return "a whole number" + range; }
    std::string operator()(const double*) const { return "a number" + range; }
    std::string operator()(const std::string*) const {
      return field.choices.empty() ? "a text" : fmt::format("one of {}", fmt::join(field.choices, ", "));
    }
    std::string operator()(const Vec3*) const {
      return "a list of 3 numbers" + (range.empty() ? "" : ", each" + range);
    }
    std::string operator()(const std::vector<double>*) const {
      return "a list of numbers" + (range.empty() ? "" : ", each" + range);
    }
    std::string operator()(const std::optional<double>*) const { return "a number" + range + " or ~"; }
    std::string operator()(const std::optional<Vec3>*) const {
      return (*this)(static_cast<const Vec3*>(nullptr)) + ", or ~";
    }
    std::string operator()(const std::shared_ptr<StructList>&) const {
      return "a list of groups of settings";
    }
  };
  return std::visit(Expectation{field, range}, field.slot);
}

std::string description(const YamlNode& node) {
  switch (node.kind) {
    case Kind::Null:
      return "no value";
    case Kind::Plain:
      return fmt::format("\"{}\"", quotable(node.text, 40));
    case Kind::Quoted:
      return fmt::format("the quoted text \"{}\"", quotable(node.text, 40));
    case Kind::List:
      return fmt::format("a list of {}", node.children.size());
    case Kind::Map:
      return "a group of settings";
  }
  return "something unknown";
}

}  // namespace colift::hal
