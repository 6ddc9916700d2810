// Real frames of rooms: which object is the target, or why there is none.
#include <fmt/format.h>

#include <algorithm>

#include "recording.hpp"
#include "sim_hal/synthetic/scenes.hpp"

namespace colift::stories {
namespace {

struct Pixel {
  double u, v;
};

// where the middle of the target's visible box is in the image
Pixel target_pixel(const control::SceneAnalysis& seen) {
  const auto at = seen.cloud.project(seen.scene.target->obb.center);
  return {at.u, at.v};
}

bool in_one_of(const nlohmann::json& boxes, const Pixel& p) {
  return std::any_of(boxes.begin(), boxes.end(), [&](const auto& b) {
    return p.u >= b[0].template get<double>() && p.v >= b[1].template get<double>() &&
           p.u <= b[2].template get<double>() && p.v <= b[3].template get<double>();
  });
}

// the same frame as a camera sees it whose left is right
hal::DepthFrame mirrored(const hal::DepthFrame& frame) {
  hal::DepthFrame out = frame;
  const int w = frame.intrinsics.width;
  for (int v = 0; v < frame.intrinsics.height; ++v)
    for (int u = 0; u < w; ++u)
      out.depth_m[static_cast<std::size_t>(v * w + u)] =
          frame.depth_m[static_cast<std::size_t>(v * w + w - 1 - u)];
  out.intrinsics.cx = w - 1 - frame.intrinsics.cx;
  return out;
}

control::SceneAnalysis look(hal::DepthFrame frame) {
  control::SceneAnalysisInput input;
  input.frame = std::move(frame);
  control::Config config;
  control::set_method_defaults(control::Method::Fast, config);
  auto seen = control::analyse_scene(std::move(input), control::Method::Fast, config, {}, hal::ManualClock());
  REQUIRE(seen);
  return std::move(*seen);
}

}  // namespace

TEST_CASE("offices, cartons, a tub, stairs: the target is what a person would point at, never a person",
          "[real]") {
  for (const char* name : {"07_carton_before_wall", "08_carton_and_long_floor", "09_tub_under_table",
                           "10_two_men_and_sofa", "11_office_chair_and_stairs", "12_office"}) {
    const Recording r(name);
    const control::SceneAnalysis seen = r.analysis();
    INFO(name << ": " << seen.scene.reason);
    if (r.truth["expectation"] == "no-target") {
      CHECK_FALSE(seen.scene.target);
      CHECK(seen.scene.reason.size() > 20);
      continue;
    }
    REQUIRE(seen.scene.ground);
    CHECK(angle_deg(seen.scene.ground->plane.normal, vec(r.truth["support_plane"]["normal"])) <=
          r.tolerance("plane_normal_deg"));
    REQUIRE(seen.scene.target);
    const Pixel p = target_pixel(seen);
    INFO("at " << p.u << ", " << p.v);
    CHECK(in_one_of(r.truth["accept"], p));
    CHECK_FALSE(in_one_of(r.truth["persons"], p));
    CHECK(seen.scene.target->confidence > 0.3);
    CHECK(seen.scene.target->confidence <= 1.0);
  }
}

TEST_CASE("a mirrored room has the mirrored target", "[real]") {
  for (const char* name : {"07_carton_before_wall", "09_tub_under_table", "11_office_chair_and_stairs"}) {
    const Recording r(name);
    const control::SceneAnalysis seen = r.analysis();
    const control::SceneAnalysis other = look(mirrored(r.frame()));
    INFO(name << ": " << other.scene.reason);
    REQUIRE(seen.scene.target);
    REQUIRE(other.scene.target);
    const double width = seen.cloud.width() - 1;
    CHECK(target_pixel(other).u == Approx(width - target_pixel(seen).u).margin(12));
    CHECK(target_pixel(other).v == Approx(target_pixel(seen).v).margin(12));
  }
}

TEST_CASE("what had to be cut out of its background is taken with less confidence, and says so", "[real]") {
  const control::SceneAnalysis carton = Recording("07_carton_before_wall").analysis();
  REQUIRE(carton.scene.target);
  CHECK(carton.scene.target->confidence < 0.8);
  const auto& doubts = carton.scene.target->doubts;
  CHECK(std::any_of(doubts.begin(), doubts.end(),
                    [](const std::string& d) { return d.find("cut out") != std::string::npos; }));
  const control::SceneAnalysis can = Recording("05_can_on_table").analysis();
  REQUIRE(can.scene.target);
  CHECK(can.scene.target->confidence > 0.9);
}

TEST_CASE("a point on a person or on a wall's furniture does not make it a target", "[real]") {
  const Recording people("04_five_people");
  const Vec3 person = vec(people.truth["objects"][0]["obb_center"]);
  const control::SceneAnalysis at_person = people.analysis(person);
  CHECK_FALSE(at_person.scene.target);
  INFO(at_person.scene.reason);
  CHECK(at_person.scene.reason.find("given point is refused") != std::string::npos);
}

TEST_CASE(
    "a table top that the view cuts can be the support of a box on it, when asked or when nothing else is "
    "there",
    "[real]") {
  using namespace sim_hal;
  World world;
  world.shapes.push_back(half_space(Vec3::Zero(), Vec3::UnitZ(), Label::Ground));
  world.shapes.push_back(
      box({1.6, 0, 0.70}, {0.7, 5.0, 0.04}, 0, Label::Clutter));  // leaves the view on both sides
  world.shapes.push_back(box({1.6, 0.1, 0.82}, {0.25, 0.35, 0.20}, 0.4, Label::Target));
  const Rendering truth = cast_rays(world, {}, look_at(Vec3(0, 0, 1.5), Vec3(1.6, 0, 0.6)));
  for (const char* support : {"auto", "table", "floor"}) {
    control::SceneAnalysisInput input;
    input.frame = measure(truth, {}, 11);
    control::Config config;
    control::set_method_defaults(control::Method::Fast, config);
    config.support = support;
    const auto seen =
        control::analyse_scene(std::move(input), control::Method::Fast, config, {}, hal::ManualClock());
    REQUIRE(seen);
    INFO(support << ": " << seen->scene.reason);
    CHECK(seen->scene.target.has_value() == (support != std::string("floor")));
    if (!seen->scene.target) continue;
    CHECK(seen->scene.reason.find("on a table 0.7") == 0);
    CHECK(seen->scene.target->obb.size.z() == Approx(0.2).margin(0.03));
    CHECK(seen->scene.ground->plane.height(seen->scene.target->obb.center) == Approx(0.1).margin(0.03));
  }
}

}  // namespace colift::stories
