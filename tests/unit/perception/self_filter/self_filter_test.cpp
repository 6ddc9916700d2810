#include "perception/self_filter.hpp"

#include <catch2/catch.hpp>

#include "robot_view.hpp"

using namespace colift;
using namespace colift::perception;
using namespace colift::perception::test;
using hal::Vec3;

namespace {

struct Tally {
  std::size_t robot = 0, missed = 0;           // pixels that show the robot
  std::size_t others = 0, lost = 0, near = 0;  // object and person; `near`: lost beside a link, as must be
};

void count(const RobotView& view, const std::vector<std::uint32_t>& removed, Tally& tally) {
  const NoiseModel noise;
  std::vector<char> gone(view.frame.depth_m.size(), 0);
  for (const std::uint32_t i : removed) gone[i] = 1;
  for (std::size_t i = 0; i < gone.size(); ++i) {
    const float z = view.frame.depth_m[i];
    if (!(z > 0)) continue;
    if (view.shows_robot(i)) {
      ++tally.robot;
      tally.missed += gone[i] ? 0 : 1;
    }
    const Label label = view.truth.label[i];
    if (label != Label::Target && label != Label::Partner) continue;
    if (std::abs(z - view.truth.depth_m[i]) > 0.05f) continue;  // a ragged edge shows something else
    ++tally.others;
    if (!gone[i]) continue;
    const double reach = SelfFilterConfig{}.padding_m + 2 * noise.sigma(static_cast<double>(z)) +
                         0.5 * noise.step(static_cast<double>(z));
    ++(sim_hal::distance(view.world, Label::Robot, view.point(i)) < reach ? tally.near : tally.lost);
  }
}

/// The stock test: every point against every link shape.
bool inside_any(const RobotView& view, const Vec3& p_W, double padding_m) {
  return sim_hal::distance(view.world, Label::Robot, p_W) < padding_m;
}

}  // namespace

TEST_CASE("the robot's pixels go, the object's and the person's stay") {
  Tally tally;
  for (std::uint64_t seed = 1; seed <= 24; ++seed) {
    const RobotView view(seed);
    auto filter = view.filter();
    hal::DepthFrame frame = view.frame;
    count(view, filter.remove(frame, view.q_rad, view.hand), tally);
  }
  REQUIRE(tally.robot > 100000);
  REQUIRE(tally.others > 500000);
  INFO(tally.missed << " of " << tally.robot << " missed, " << tally.lost << " of " << tally.others
                    << " lost, " << tally.near << " beside a link");
  CHECK(static_cast<double>(tally.missed) <= 0.0005 * static_cast<double>(tally.robot));
  CHECK(static_cast<double>(tally.lost) <= 0.0005 * static_cast<double>(tally.others));
  CHECK(static_cast<double>(tally.near) <= 0.005 * static_cast<double>(tally.others));
}

TEST_CASE("a camera that is calibrated to 5 mm and 0.3 deg leaves no robot pixels either") {
  Tally tally;
  for (std::uint64_t seed = 31; seed <= 42; ++seed) {
    RobotView view(seed);
    sim_hal::Draws draws(seed, 33);
    const Vec3 axis = Vec3(draws.between(-1, 1), draws.between(-1, 1), draws.between(-1, 1)).normalized();
    // what the program believes about the camera; turned about the robot, as a calibration would be wrong
    hal::Pose X = hal::Pose::Identity();
    X.linear() = Eigen::AngleAxisd(0.005, axis).toRotationMatrix();
    X.translation() = 0.005 * axis.unitOrthogonal();
    SelfFilter filter(view.model, view.scene.intrinsics, X * view.scene.X_WC, NoiseModel{}, {});
    hal::DepthFrame frame = view.frame;
    count(view, filter.remove(frame, view.q_rad, view.hand), tally);
  }
  REQUIRE(tally.robot > 40000);
  CHECK(static_cast<double>(tally.missed) <= 0.005 * static_cast<double>(tally.robot));
}

TEST_CASE("what is removed becomes NaN and is listed in order, nothing else changes") {
  const RobotView view(4);
  auto filter = view.filter();
  hal::DepthFrame frame = view.frame;
  const auto& removed = filter.remove(frame, view.q_rad, view.hand);
  REQUIRE(removed.size() > 5000);
  CHECK(std::is_sorted(removed.begin(), removed.end()));
  CHECK(std::adjacent_find(removed.begin(), removed.end()) == removed.end());
  std::size_t at = 0, wrong = 0;
  for (std::uint32_t i = 0; i < frame.depth_m.size(); ++i) {
    const float before = view.frame.depth_m[i], after = frame.depth_m[i];
    if (at < removed.size() && removed[at] == i) {
      wrong += before == before && after != after ? 0 : 1;
      ++at;
    } else {
      wrong += before == after || (before != before && after != after) ? 0 : 1;
    }
  }
  CHECK(wrong == 0);
  CHECK(at == removed.size());
}

TEST_CASE("on a frame without noise the filter and the stock test of every point agree") {
  for (const std::uint64_t seed : {4, 11}) {
    RobotView view(seed);
    view.frame = sim_hal::measure_ideal(view.truth);
    NoiseModel exact;
    exact.sigma0_m = exact.sigma2_per_m = exact.step2_per_m = 0.0;
    SelfFilterConfig config;
    config.shadow_padding_px = 0.0;
    SelfFilter filter(view.model, view.scene.intrinsics, view.scene.X_WC, exact, config);
    hal::DepthFrame frame = view.frame;
    std::vector<char> gone(frame.depth_m.size(), 0);
    for (const std::uint32_t i : filter.remove(frame, view.q_rad, view.hand)) gone[i] = 1;
    // corners of padded boxes and cylinders reach farther than their distance: sqrt(3) paddings at most
    std::size_t wrong = 0, robot = 0;
    for (std::size_t i = 0; i < gone.size(); i += 3) {
      if (!(view.frame.depth_m[i] > 0)) continue;
      const Vec3 p = view.point(i);
      const bool near = inside_any(view, p, config.padding_m - 2e-4);
      const bool far = !inside_any(view, p, 1.7321 * config.padding_m + 2e-4);
      robot += near ? 1 : 0;
      wrong += (near && !gone[i]) || (far && gone[i]) ? 1 : 0;
    }
    CHECK(robot > 3000);
    CHECK(wrong == 0);
  }
}

TEST_CASE("an arm of the person before the robot stays, and so does what is seen between the links") {
  RobotView view(12);
  // a forearm 25 cm before the middle of what is seen of the robot
  double u = 0, v = 0, z = 0;
  std::size_t n = 0;
  for (std::size_t i = 0; i < view.truth.label.size(); ++i) {
    if (view.truth.label[i] != Label::Robot) continue;
    u += static_cast<double>(i % 640), v += static_cast<double>(i / 640);
    z += static_cast<double>(view.truth.depth_m[i]);
    ++n;
  }
  REQUIRE(n > 5000);
  const auto count_n = static_cast<double>(n);
  const auto& k = view.scene.intrinsics;
  z = z / count_n - 0.4;
  const Vec3 p_C((u / count_n - k.cx) / k.fx * z, (v / count_n - k.cy) / k.fy * z, z);
  const hal::Pose& X_WC = view.scene.X_WC;
  view.world.shapes.push_back(sim_hal::capsule(X_WC * Vec3(p_C - 0.15 * Vec3::UnitX()),
                                               X_WC * Vec3(p_C + 0.15 * Vec3::UnitX()), 0.04,
                                               Label::Partner));
  const auto arm = static_cast<std::int16_t>(view.world.shapes.size() - 1);
  const auto truth = sim_hal::cast_rays(view.world, k, X_WC);
  hal::DepthFrame frame = sim_hal::measure_ideal(truth);
  auto filter = view.filter();
  std::vector<char> gone(frame.depth_m.size(), 0);
  for (const std::uint32_t i : filter.remove(frame, view.q_rad, view.hand)) gone[i] = 1;
  std::size_t seen = 0, lost = 0;
  for (std::size_t i = 0; i < gone.size(); ++i) {
    if (truth.shape[i] != arm) continue;
    ++seen;
    lost += gone[i] ? 1 : 0;
  }
  CHECK(seen > 1000);
  CHECK(lost == 0);
}

TEST_CASE("frames that cannot be filtered are left as they are") {
  const RobotView view(4);
  auto filter = view.filter();
  SECTION("another size") {
    hal::DepthFrame frame = view.frame;
    frame.depth_m.resize(100);
    CHECK(filter.remove(frame, view.q_rad, view.hand).empty());
  }
  SECTION("nothing seen") {
    hal::DepthFrame frame = view.frame;
    std::fill(frame.depth_m.begin(), frame.depth_m.end(), std::numeric_limits<float>::quiet_NaN());
    CHECK(filter.remove(frame, view.q_rad, view.hand).empty());
  }
  SECTION("the robot out of sight") {
    hal::Pose away = view.scene.X_WC;
    away.linear() = away.linear() * Eigen::AngleAxisd(3.14159, Vec3::UnitY()).toRotationMatrix();
    away.translation() -= 5.0 * view.scene.X_WC.linear().col(2);
    SelfFilter blind(view.model, view.scene.intrinsics, away, NoiseModel{}, {});
    hal::DepthFrame frame = view.frame;
    CHECK(blind.remove(frame, view.q_rad, view.hand).empty());
  }
}

TEST_CASE("a filter can be used again after the arm moved") {
  const RobotView a(4), b(12);
  auto used = b.filter();
  hal::DepthFrame first = b.frame;
  used.remove(first, a.q_rad, a.hand);
  hal::DepthFrame second = b.frame, fresh = b.frame;
  const auto one = used.remove(second, b.q_rad, b.hand);
  auto new_filter = b.filter();
  CHECK(one == new_filter.remove(fresh, b.q_rad, b.hand));
}
