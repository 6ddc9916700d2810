#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "perception/thesis/thesis_target.hpp"
#include "sim_hal/synthetic/kinect/kinect_noise.hpp"

using namespace colift::perception;
using namespace colift::sim_hal;

namespace {

/// A table in a room with a wall and two things beside it, seen by a Kinect at half resolution.
struct Room {
  const Vec3 size{0.8, 0.5, 0.45};
  const Vec3 middle{0.7, 0.0, 0.225};
  Pose X_WC = look_at({2.0, -1.2, 1.4}, {0.7, 0.0, 0.3});
  Rendering truth;
  OrganisedCloud frame;

  explicit Room(bool with_table = true) {
    World world;
    const auto add = [&](const Shape& shape) { world.shapes.push_back(shape); };
    add(half_space({0, 0, 0}, Vec3::UnitZ(), Label::Ground));
    add(half_space({0, 1.5, 0}, -Vec3::UnitY(), Label::Wall));
    if (with_table) {
      add(box({0.7, 0, 0.4375}, {0.8, 0.5, 0.025}, 0, Label::Target));
      for (const double x : {0.325, 1.075})
        for (const double y : {-0.225, 0.225})
          add(box({x, y, 0.2125}, {0.05, 0.05, 0.425}, 0, Label::Target));
      add(box({0.2, 0.9, 0.1}, {0.3, 0.2, 0.2}, 0.4, Label::Clutter));
      add(cylinder({1.4, 0.6, 0.1}, Vec3::UnitZ(), 0.06, 0.2, Label::Clutter));
    }
    truth = cast_rays(world, {320, 240, 287.9, 287.9, 160, 120}, X_WC);
    frame = deproject(measure(truth, KinectNoise{}, 3), X_WC);
  }

  /// The space in front of the wall, as an operator would set it.
  [[nodiscard]] static ThesisConfig cropped() {
    ThesisConfig config;
    config.crop_min_m = {-0.5, -1.2, -0.2};
    config.crop_max_m = {2.0, 1.3, 1.5};
    return config;
  }

  [[nodiscard]] double overlap(const std::vector<std::uint32_t>& mask) const {
    std::size_t both = 0, seen = 0;
    for (std::size_t i = 0; i < frame.size(); ++i) seen += frame.seen(i) && truth.label[i] == Label::Target;
    for (const std::uint32_t i : mask) both += truth.label[i] == Label::Target;
    return static_cast<double>(both) / static_cast<double>(mask.size() + seen - both);
  }
};

double degrees_between(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / M_PI;
}

bool starts_with(const std::string& text, const std::string& beginning) {
  return text.rfind(beginning, 0) == 0;
}

}  // namespace

TEST_CASE("a table in a cropped room is found with its ground, box, middle and top", "[thesis][scene]") {
  const Room room;
  const ThesisConfig config = Room::cropped();
  const Scene scene = thesis_scene(room.frame, config);

  REQUIRE(scene.ground);
  CHECK(degrees_between(scene.ground->plane.normal, Vec3::UnitZ()) < 0.3);
  CHECK(std::abs(scene.ground->plane.offset) < 0.003);
  REQUIRE(scene.target);
  const Target& target = *scene.target;
  CHECK((target.obb.size - room.size).cwiseAbs().maxCoeff() < 0.045);
  CHECK(target.obb.axes.col(2).isApprox(scene.ground->plane.normal, 1e-12));
  CHECK(target.cog == target.aabb.center());
  CHECK((target.cog - room.middle).norm() < 0.03);
  CHECK(std::sqrt(target.cog_covariance(0, 0)) == Approx(target.aabb.sizes().x() / 6));
  CHECK(room.overlap(thesis_pixels(room.frame, target, config)) > 0.9);
  CHECK(starts_with(target.reason, "largest of "));

  REQUIRE_FALSE(scene.surfaces.empty());
  const auto& top = std::get<Rectangle>(scene.surfaces.front());
  CHECK(degrees_between(top.normal, Vec3::UnitZ()) < 1.0);
  CHECK(std::abs(top.center.z() - 0.45) < 0.005);
  CHECK(top.size.x() == Approx(0.8).margin(0.04));
  CHECK(top.size.y() == Approx(0.5).margin(0.04));
  for (const Surface& surface : scene.surfaces) {
    const auto& rectangle = std::get<Rectangle>(surface);
    CHECK(rectangle.normal.dot(room.X_WC.translation() - rectangle.center) > 0);
    CHECK(rectangle.fill >= config.rectangle_min_fill);
  }
}

TEST_CASE("without a crop box the wall is the largest cluster: the thesis needs its pass-through",
          "[thesis][scene]") {
  const Room room;
  const ThesisConfig config;
  const Scene scene = thesis_scene(room.frame, config);
  REQUIRE(scene.target);
  CHECK(scene.target->obb.size.x() > 1.5);
  CHECK(room.overlap(thesis_pixels(room.frame, *scene.target, config)) < 0.05);
}

TEST_CASE("two runs over a frame agree bit for bit", "[thesis][scene]") {
  const Room room;
  const Scene a = thesis_scene(room.frame, Room::cropped()), b = thesis_scene(room.frame, Room::cropped());
  REQUIRE(a.target);
  REQUIRE(b.target);
  CHECK(a.ground->plane.normal == b.ground->plane.normal);
  CHECK(a.ground->plane.offset == b.ground->plane.offset);
  CHECK(a.target->points == b.target->points);
  CHECK(a.target->obb.axes == b.target->obb.axes);
  REQUIRE(a.surfaces.size() == b.surfaces.size());
  for (std::size_t i = 0; i < a.surfaces.size(); ++i) {
    CHECK(std::get<Rectangle>(a.surfaces[i]).center == std::get<Rectangle>(b.surfaces[i]).center);
    CHECK(std::get<Rectangle>(a.surfaces[i]).fill == std::get<Rectangle>(b.surfaces[i]).fill);
  }
}

TEST_CASE("without a voxel grid the target's pixels are its points", "[thesis][scene]") {
  const Room room;
  ThesisConfig config = Room::cropped();
  config.voxel_leaf_m = 0;
  const Scene scene = thesis_scene(room.frame, config);
  REQUIRE(scene.target);
  const auto mask = thesis_pixels(room.frame, *scene.target, config);
  CHECK(mask.size() == scene.target->points.size());
  CHECK(std::is_sorted(mask.begin(), mask.end()));
  CHECK(room.overlap(mask) > 0.9);
}

TEST_CASE("no ground and no target are said in words with numbers", "[thesis][scene]") {
  OrganisedCloud blind;
  blind.intrinsics = {4, 3, 3, 3, 2, 1};
  blind.depth_m.assign(12, std::numeric_limits<float>::quiet_NaN());
  blind.x = blind.y = blind.z = blind.depth_m;
  Scene scene = thesis_scene(blind, ThesisConfig{});
  CHECK_FALSE(scene.ground);
  CHECK_FALSE(scene.target);
  CHECK(
      scene.reason ==
      "no ground: of 12 pixels 0 have a depth between 0.3 and 3.5 m, and 0 of these lie inside the crop box");

  const Room empty(false);
  scene = thesis_scene(empty.frame, Room::cropped());
  CHECK(scene.ground);
  CHECK_FALSE(scene.target);
  CHECK(scene.surfaces.empty());
  CHECK(starts_with(scene.reason, "no target: "));

  ThesisConfig demanding = Room::cropped();
  demanding.ground_min_fraction = 1.0;
  scene = thesis_scene(Room().frame, demanding);
  CHECK_FALSE(scene.ground);
  CHECK(starts_with(scene.reason, "no ground: the largest plane holds "));
  CHECK(thesis_scene(OrganisedCloud{}, ThesisConfig{}).reason.size() > 0);
}
