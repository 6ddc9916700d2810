#include <catch2/catch.hpp>

#include <cmath>

#include "perception/calibration/spot_finder.hpp"
#include "sim_hal/synthetic/infrared_scene.hpp"
#include "tests/support/calibration_trial.hpp"

using namespace colift;
using hal::Vec3;
using perception::find_spot;
using sim_hal::Emitter;
using sim_hal::StrayLight;

namespace {

/// A wall two metres away and an emitter before it.
struct Room {
  sim_hal::World world;
  sim_hal::Rendering truth;
  Emitter emitter;

  explicit Room(double away_m = 1.7, double u = 300.3, double v = 200.7) {
    world.shapes.push_back(sim_hal::box({0, 0, 2.6}, {6, 6, 0.2}, 0.0, sim_hal::Label::Wall));
    truth = sim_hal::cast_rays(world, tests::infrared_intrinsics(), hal::Pose::Identity());
    const auto& k = truth.intrinsics;
    emitter.at_W = {(u - k.cx) / k.fx * away_m, (v - k.cy) / k.fy * away_m, away_m};
    emitter.towards_W = -Vec3::UnitZ();
  }
  [[nodiscard]] hal::InfraredFrame image(bool lit, std::uint64_t seed,
                                         const std::vector<StrayLight>& stray = {}) const {
    return sim_hal::expose_infrared(truth, lit ? std::optional(emitter) : std::nullopt, stray, {}, seed);
  }
  [[nodiscard]] std::vector<hal::InfraredFrame> images(bool lit, int count, std::uint64_t seed) const {
    std::vector<hal::InfraredFrame> out;
    for (int i = 0; i < count; ++i) out.push_back(image(lit, seed + static_cast<std::uint64_t>(i)));
    return out;
  }
};

std::string refusal(const std::vector<hal::InfraredFrame>& off, const std::vector<hal::InfraredFrame>& on) {
  const auto spot = find_spot(off, on, {});
  return spot ? "found" : spot.error().kind;
}

}  // namespace

TEST_CASE("the emitter's spot is found to a tenth of a pixel, also where it is too bright") {
  for (const double away : {0.9, 1.3, 1.7, 2.2}) {
    const Room room(away);
    const auto spot = find_spot(room.images(false, 4, 10), room.images(true, 4, 20), {});
    REQUIRE(spot);
    CHECK((spot->pixel - Eigen::Vector2d(300.3, 200.7)).norm() < 0.12);
    CHECK(spot->saturated == (away < 1.75));
    CHECK(std::sqrt(spot->covariance(0, 0)) < 0.35);
  }
}

TEST_CASE("one pair of images is enough") {
  const Room room;
  const auto spot = find_spot(room.images(false, 1, 1), room.images(true, 1, 2), {});
  REQUIRE(spot);
  CHECK((spot->pixel - Eigen::Vector2d(300.3, 200.7)).norm() < 0.3);
}

TEST_CASE("an emitter that blinks by itself is told from the images") {
  const Room room;
  std::vector<hal::InfraredFrame> frames;
  for (std::uint64_t i = 0; i < 12; ++i) frames.push_back(room.image((i / 3) % 2 == 1, i));
  const auto spot = perception::find_blinking_spot(frames, {});
  REQUIRE(spot);
  CHECK((spot->pixel - Eigen::Vector2d(300.3, 200.7)).norm() < 0.15);
}

TEST_CASE("a person who walks through the picture is not taken for the emitter") {
  const Room room;
  std::vector<hal::InfraredFrame> off, on;
  for (std::uint64_t i = 0; i < 5; ++i) {
    const auto at = static_cast<double>(i);
    off.push_back(room.image(false, i, {{{120 + 12 * at, 300}, 700, 9}}));
    on.push_back(room.image(true, 50 + i, {{{126 + 12 * at, 300}, 700, 9}}));
  }
  const auto spot = find_spot(off, on, {});
  REQUIRE(spot);
  CHECK((spot->pixel - Eigen::Vector2d(300.3, 200.7)).norm() < 0.2);
}

TEST_CASE("images that do not tell are refused with the reason") {
  const Room room;
  const auto off = room.images(false, 3, 1), on = room.images(true, 3, 11);
  SECTION("the emitter is off") {
    CHECK(refusal(off, room.images(false, 3, 5)) == "dark");
  }
  SECTION("no images") {
    CHECK(refusal({}, on) == "images");
  }
  SECTION("images of two sizes") {
    auto half = on;
    half[1].brightness.resize(half[1].brightness.size() / 2);
    CHECK(refusal(off, half) == "images");
  }
  SECTION("a second spot that is as bright") {
    std::vector<hal::InfraredFrame> two;
    for (std::uint64_t i = 0; i < 3; ++i) two.push_back(room.image(true, i, {{{420, 310}, 1000, 1.3}}));
    CHECK(refusal(off, two) == "rival");
  }
  SECTION("a dim reflection does no harm") {
    std::vector<hal::InfraredFrame> two;
    for (std::uint64_t i = 0; i < 3; ++i) two.push_back(room.image(true, i, {{{420, 310}, 300, 1.2}}));
    CHECK(refusal(off, two) == "found");
  }
  SECTION("a lamp is switched on") {
    std::vector<hal::InfraredFrame> lamp;
    for (std::uint64_t i = 0; i < 3; ++i) lamp.push_back(room.image(false, i, {{{200, 200}, 900, 14}}));
    CHECK(refusal(off, lamp) == "large");
  }
  SECTION("at the border") {
    const Room edge(1.7, 1.0, 200.0);
    CHECK(refusal(edge.images(false, 3, 1), edge.images(true, 3, 9)) == "border");
  }
  SECTION("the arm still swings") {
    std::vector<hal::InfraredFrame> swing;
    for (int i = 0; i < 4; ++i) swing.push_back(Room(1.7, 300.0 + 0.8 * i, 200.0).image(true, 60));
    CHECK(refusal(room.images(false, 4, 1), swing) == "unsteady");
  }
  SECTION("something stands before the emitter") {
    Room hidden;
    hidden.world.shapes.push_back(
        sim_hal::box(0.7 * hidden.emitter.at_W, {0.1, 0.1, 0.1}, 0.0, sim_hal::Label::Partner));
    hidden.truth = sim_hal::cast_rays(hidden.world, tests::infrared_intrinsics(), hal::Pose::Identity());
    CHECK(refusal(hidden.images(false, 3, 1), hidden.images(true, 3, 9)) == "dark");
  }
}
