#include <fmt/format.h>
#include <algorithm>

#include "../target/synthetic.hpp"

namespace colift::perception {
namespace {

using sim_hal::ObjectKind;

const ObjectKind kKinds[] = {ObjectKind::Table, ObjectKind::Box, ObjectKind::OpenBox, ObjectKind::Pipe,
                             ObjectKind::Chair};

GroundResult ground_of(const OrganisedCloud& cloud, const std::optional<Vec3>& up) {
  const NoiseModel noise;
  return find_ground(cloud, fit_block_planes(cloud, noise), up, noise, {});
}

}  // namespace

TEST_CASE("the ground is found within 0.3 degrees and 3 mm on noisy frames", "[ground]") {
  const bool known_up = GENERATE(false, true);
  std::vector<double> angles, offsets;
  for (const ObjectKind kind : kKinds) {
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
      const SceneView view(kind, seed);
      const GroundResult r =
          ground_of(view.cloud, known_up ? std::optional<Vec3>(Vec3::UnitZ()) : std::nullopt);
      INFO(view.scene.name << " seed " << seed << ": " << r.reason);
      REQUIRE(r.ground);
      angles.push_back(angle_deg(r.ground->plane.normal, view.scene.ground.normal));
      // the offset counts where the ground is seen: under the camera's view, at the scene's origin of
      // interest
      const Vec3 foot = view.scene.ground.foot(view.scene.cog);
      offsets.push_back(std::abs(r.ground->plane.height(foot)));
      CHECK(angles.back() <= 0.3);
      CHECK(offsets.back() <= 0.003);
    }
  }
  std::sort(angles.begin(), angles.end());
  std::sort(offsets.begin(), offsets.end());
  fmt::print(
      "ground, {} frames, up {}: angle median {:.3f} max {:.3f} deg, offset median {:.2f} max {:.2f} mm\n",
      angles.size(), known_up ? "known" : "unknown", angles[angles.size() / 2], angles.back(),
      1e3 * offsets[offsets.size() / 2], 1e3 * offsets.back());
}

TEST_CASE("a wall larger than the floor is not the ground", "[ground]") {
  using namespace sim_hal;
  World world;
  world.shapes.push_back(half_space(Vec3::Zero(), Vec3::UnitZ(), Label::Ground));
  world.shapes.push_back(box(Vec3(1.6, 0, 1.5), Vec3(0.1, 6.0, 3.0), 0.0, Label::Wall));
  // looking slightly down from low: the wall fills most of the image
  const Pose X_WC = look_at(Vec3(-0.6, 0, 0.8), Vec3(1.6, 0, 0.6));
  const Rendering truth = cast_rays(world, {}, X_WC);
  const auto count = [&](Label l) { return std::count(truth.label.begin(), truth.label.end(), l); };
  REQUIRE(count(Label::Wall) > 2 * count(Label::Ground));
  const OrganisedCloud cloud = deproject(measure(truth, {}, 3), X_WC);

  for (const auto& up : {std::optional<Vec3>(), std::optional<Vec3>(Vec3::UnitZ())}) {
    const GroundResult r = ground_of(cloud, up);
    INFO(r.reason);
    REQUIRE(r.ground);
    CHECK(angle_deg(r.ground->plane.normal, Vec3::UnitZ()) < 0.5);
  }
}

TEST_CASE("a frame that shows only a wall has no ground, and says so", "[ground]") {
  using namespace sim_hal;
  World world;
  world.shapes.push_back(box(Vec3(2.0, 0, 1.5), Vec3(0.1, 8.0, 6.0), 0.0, Label::Wall));
  const Pose X_WC = look_at(Vec3(0, 0, 1.5), Vec3(2.0, 0, 1.2));
  const GroundResult r = ground_of(deproject(measure(cast_rays(world, {}, X_WC), {}, 1), X_WC), std::nullopt);
  CHECK_FALSE(r.ground);
  CHECK(r.reason.find("no ground") == 0);
}

TEST_CASE("an empty frame has no ground", "[ground]") {
  hal::DepthFrame frame;
  frame.depth_m.assign(640 * 480, std::numeric_limits<float>::quiet_NaN());
  CHECK_FALSE(ground_of(deproject(frame, Pose::Identity()), std::nullopt).ground);
}

}  // namespace colift::perception
