#include <bit>
#include <catch2/catch.hpp>
#include <cstdint>
#include <random>

#include "example_config.hpp"

using namespace colift::hal;
using namespace colift::hal::example;

namespace {

/// Random configurations that every range allows, with the ends of double's range among them.
class AppMaker {
 public:
  explicit AppMaker(std::uint64_t seed) : bits_(seed) {}

  App make() {
    App app;
    app.method = one_of({"fast", "thesis"});
    app.title = text();
    app.ground.max_tilt_deg = 90.0 * fraction();
    app.ground.reach_m = one_in(3) ? std::numeric_limits<double>::infinity() : positive();
    app.ground.refine.rounds = static_cast<int>(bits_() % 101);
    app.ground.refine.robust = one_in(2);
    if (one_in(2)) app.ground.refine.up = Vec3(fraction(), -fraction(), fraction());
    app.epsilon = positive();
    if (one_in(2)) app.unset = any();
    if (one_in(2)) app.share = fraction();
    app.at = Vec3(any(), any(), any());
    app.weights.assign(bits_() % 5, 0.0);
    for (double& w : app.weights) w = one_in(4) ? 0.0 : positive();
    app.parts = parts();
    app.groups.resize(bits_() % 3);
    for (Group& group : app.groups) {
      group.name = text();
      group.parts = parts();
    }
    return app;
  }

 private:
  bool one_in(std::uint64_t n) { return bits_() % n == 0; }
  double fraction() { return static_cast<double>(bits_() >> 11) * 0x1p-53; }

  /// Any finite double, every exponent alike.
  double any() {
    for (;;) {
      const auto x = std::bit_cast<double>(std::uint64_t{bits_()});
      if (std::isfinite(x)) return x;
    }
  }
  double positive() { return std::max(std::abs(any()), std::numeric_limits<double>::min()); }

  std::string one_of(std::vector<std::string> texts) { return texts[bits_() % texts.size()]; }

  std::string text() {
    const std::vector<std::string> pieces = {"a",        "Z9",
                                             " ",        ":",
                                             "#",        "\n",
                                             "\t",       "\"",
                                             "\\",       "'",
                                             "~",        "- ",
                                             "[",        "}",
                                             "%",        "null",
                                             "true",     "0",
                                             "\r",       "&",
                                             "*",        "\x01",
                                             "\x7f",     "|",
                                             "\xc3\xbc", "\xf0\x9f\xa4\x96",
                                             "\xc2\x85"};
    std::string out;
    for (std::uint64_t n = bits_() % 6; n > 0; --n) out += one_of(pieces);
    return out;
  }

  std::vector<Part> parts() {
    std::vector<Part> out(bits_() % 4);
    for (Part& part : out) {
      part.shape = one_of({"box", "cylinder"});
      part.size_m = Vec3(positive(), positive(), positive());
      if (one_in(2)) part.mass_kg = positive();
      for (double& angle : part.rpy_deg) angle = 720.0 * fraction() - 360.0;
    }
    return out;
  }

  std::mt19937_64 bits_;
};

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) ||
         (std::isnan(a) && std::isnan(b));
}

template <class Numbers>
bool same_numbers(const Numbers& a, const Numbers& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), same_bits);
}

bool same_parts(const std::vector<Part>& a, const std::vector<Part>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Part& x, const Part& y) {
    return x.shape == y.shape && same_numbers(x.size_m, y.size_m) && same_bits(x.mass_kg, y.mass_kg) &&
           same_numbers(x.rpy_deg, y.rpy_deg);
  });
}

void check_same(const App& a, const App& b) {
  CHECK(a.method == b.method);
  CHECK(a.title == b.title);
  CHECK(same_bits(a.ground.max_tilt_deg, b.ground.max_tilt_deg));
  CHECK(same_bits(a.ground.reach_m, b.ground.reach_m));
  CHECK(a.ground.refine.rounds == b.ground.refine.rounds);
  CHECK(a.ground.refine.robust == b.ground.refine.robust);
  REQUIRE(a.ground.refine.up.has_value() == b.ground.refine.up.has_value());
  if (a.ground.refine.up) CHECK(same_numbers(*a.ground.refine.up, *b.ground.refine.up));
  CHECK(same_bits(a.epsilon, b.epsilon));
  CHECK(same_bits(a.unset, b.unset));
  REQUIRE(a.share.has_value() == b.share.has_value());
  if (a.share) CHECK(same_bits(*a.share, *b.share));
  CHECK(same_numbers(a.at, b.at));
  CHECK(same_numbers(a.weights, b.weights));
  CHECK(same_parts(a.parts, b.parts));
  CHECK(std::equal(
      a.groups.begin(), a.groups.end(), b.groups.begin(), b.groups.end(),
      [](const Group& x, const Group& y) { return x.name == y.name && same_parts(x.parts, y.parts); }));
}

}  // namespace

TEST_CASE("the effective configuration loads back to the same bits", "[config][property]") {
  AppMaker maker(20260711);
  for (int i = 0; i < 2000; ++i) {
    App written = maker.make();
    const std::string yaml = effective_yaml(table_of(written), i % 2 == 0);
    App read;
    FieldTable table = table_of(read);
    const auto done = apply_yaml_text(table, yaml, "effective.yaml");
    INFO(yaml);
    INFO((done ? "" : done.error().text()));
    REQUIRE(done);
    check_same(written, read);
    REQUIRE(check_fields(table));
  }
}

TEST_CASE("the effective configuration says of every value where it comes from", "[config]") {
  App app;
  FieldTable table = table_of(app);
  REQUIRE(apply_yaml_text(table, "epsilon: 2\nground:\n  refine:\n    rounds: 5\n", "robot.yaml"));
  REQUIRE(apply_setting(table, "share=0.5"));
  const std::string yaml = effective_yaml(table, false);
  CHECK_THAT(yaml, Catch::Contains("\nepsilon: 2  # robot.yaml:1\n"));
  CHECK_THAT(yaml, Catch::Contains("\n    rounds: 5  # robot.yaml:4\n"));
  CHECK_THAT(yaml, Catch::Contains("\nshare: 0.5  # --set\n"));
  CHECK_THAT(yaml, Catch::Contains("\n  max_tilt_deg: 50  # default\n"));
  CHECK_THAT(
      effective_yaml(table, true),
      Catch::Contains(
          "  # Largest angle between the normal and up. (a number from 0 to 90; deg)\n  max_tilt_deg: 50"));
}

TEST_CASE("a file name cannot break out of its comment", "[config]") {
  App app;
  FieldTable table = table_of(app);
  REQUIRE(apply_yaml_text(table, "share: 0.5\n", "a\nepsilon: 7\n.yaml"));
  App read;
  FieldTable again = table_of(read);
  REQUIRE(apply_yaml_text(again, effective_yaml(table, true), "b.yaml"));
  CHECK(read.epsilon == 1.0);
}
