// Any bytes as a configuration file, and as a setting: refused with one sentence or accepted, and what was
// accepted prints as YAML that loads back to the same.

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/config/config_file.hpp"

namespace {

using namespace colift::hal;

struct Inner {
  double x_m = std::numeric_limits<double>::quiet_NaN();
  std::string kind = "box";
  std::vector<double> numbers;

  template <class Visitor>
  void visit(Visitor& v) {
    v("x", x_m, kPositive, "");
    v("k", kind, Choices{"box", "cylinder"}, "");
    v("n", numbers, kFraction, "", Presence::Required);
  }
};

/// Holds itself, so that nesting has no end of its own.
struct Nested {
  std::vector<Nested> nested;
  int count = 0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("r", nested, "");
    v("i", count, Range{-5, 5}, "");
  }
};

struct Root {
  bool flag = false;
  std::string text;
  std::optional<double> share;
  std::optional<Vec3> up;
  Vec3 at = Vec3::Zero();
  double limit = std::numeric_limits<double>::infinity();
  Inner inner;
  Nested nested;
  std::vector<Inner> list;

  template <class Visitor>
  void visit(Visitor& v) {
    v("b", flag, "");
    v("t", text, "");
    v("s", share, kFraction, "");
    v("u", up, Range{-1, 1}, "");
    v("a", at, kAny, "");
    v("l", limit, kPositive, "");
    v("g", inner, "");
    v("c", nested, "");
    v("p", list, "");
  }
};

void demand(bool fact, const char* what, const std::string& text) {
  if (fact) return;
  std::fprintf(stderr, "%s\n%s\n", what, text.c_str());
  std::abort();
}

void demand_one_sentence(const Error& error) {
  demand(!error.where.empty() && !error.detail.empty(), "an error without words", error.text());
  demand(error.text().find('\n') == std::string::npos, "an error of several lines", error.text());
}

/// What the struct holds, whatever the origins in its table.
std::string values_of(Root& root) {
  return effective_yaml(table_of(root), false);
}

void demand_round_trip(Root& root, const FieldTable& table) {
  const std::string yaml = effective_yaml(table, true);
  Root again;
  FieldTable table_again = table_of(again);
  const auto done = apply_yaml_text(table_again, yaml, "effective");
  demand(done.has_value(), "effective YAML is refused", yaml + (done ? "" : done.error().text()));
  demand(values_of(again) == values_of(root), "effective YAML loads to something else", yaml);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  Root root;
  FieldTable table = table_of(root);
  if (const auto done = apply_yaml_text(table, input, "input"); !done) {
    demand_one_sentence(done.error());
  } else if (size < 20'000) {
    demand_round_trip(root, table);
  }
  if (const auto done = apply_setting(table, input); !done) {
    demand_one_sentence(done.error());
  } else if (size < 20'000) {
    demand_round_trip(root, table);
  }
  return 0;
}
