// What the simulated rig costs on the built-in table: its parts, and a whole lift with seeing and planning.
// CPU time of one thread. Before it is timed, the camera's image is compared with one that is cast anew.

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "bench_timing.hpp"
#include "sim_hal/mujoco/devices/sim_camera.hpp"
#include "sim_hal/mujoco/devices/sim_devices.hpp"
#include "sim_hal/synthetic/kinect/kinect_noise.hpp"
#include "tests/support/simulated_lift.hpp"

namespace colift::bench {
namespace {

using std::chrono::milliseconds;

constexpr double kHolding_s = 5.0;  // the person is there and holds the table
constexpr auto kFrame = milliseconds(33);
constexpr double kSameDepth_m = 1e-4;
constexpr std::size_t kFrames = 61;
constexpr std::size_t kMayDiffer = kFrames;  // pixels of silhouettes, one a frame

std::unique_ptr<sim_hal::SimWorld> make_world(const sim_hal::Scenario& scenario) {
  auto made = sim_hal::SimWorld::make(scenario, hal::built_in_robot(), 1, {});
  if (made) return std::move(*made);
  fmt::print(stderr, "{}\n", made.error().text());
  return nullptr;
}

/// Pixels on which two images show different shapes or depths.
std::size_t differing(const sim_hal::Rendering& a, const sim_hal::Rendering& b) {
  std::size_t n = 0;
  for (std::size_t i = 0; i < a.shape.size(); ++i)
    n +=
        a.shape[i] != b.shape[i] || (a.shape[i] >= 0 && std::abs(a.depth_m[i] - b.depth_m[i]) > kSameDepth_m);
  return n;
}

/// Medians over frames from a time on, a frame's time apart (ms).
struct FrameCost {
  double rays = 0, rays_anew = 0, noise = 0;
  std::size_t shapes = 0, differ = 0;
  [[nodiscard]] double whole() const { return rays + noise; }
};

FrameCost frame_cost(const sim_hal::Scenario& scenario, double from_s) {
  const auto world = make_world(scenario);
  if (!world) return {};
  const hal::Pose X_WC = sim_hal::camera_pose(scenario.camera);
  sim_hal::RayCaster caster(hal::CameraIntrinsics{}, X_WC);
  world->advance(milliseconds(static_cast<int>(1e3 * from_s)));
  std::vector<double> rays, anew, noise;
  FrameCost cost;
  for (std::size_t i = 0; i < kFrames; ++i) {
    world->advance(kFrame);
    const sim_hal::World shapes = world->shapes();
    const double t0 = cpu_ms();
    const sim_hal::Rendering& image = caster.cast(shapes);
    const double t1 = cpu_ms();
    const hal::DepthFrame frame = sim_hal::measure(image, {}, i);
    const double t2 = cpu_ms();
    const sim_hal::Rendering whole = sim_hal::cast_rays(shapes, hal::CameraIntrinsics{}, X_WC);
    const double t3 = cpu_ms();
    if (i > 0) rays.push_back(t1 - t0), noise.push_back(t2 - t1), anew.push_back(t3 - t2);
    cost.differ += differing(image, whole);
    cost.shapes = shapes.shapes.size();
    if (frame.depth_m.empty()) return {};
  }
  cost.rays = median(rays), cost.noise = median(noise), cost.rays_anew = median(anew);
  return cost;
}

/// Simulated time over CPU time, of physics alone or with the camera's 30 frames a second.
double times_real_time(const sim_hal::Scenario& scenario, double seconds, bool camera) {
  const auto world = make_world(scenario);
  if (!world) return 0.0;
  const auto eye = sim_hal::make_sim_camera(*world);
  if (!eye->configure() || !eye->activate()) return 0.0;
  const double begin = cpu_ms();
  while (hal::seconds(world->clock().now()) < seconds) {
    if (!camera) {
      world->advance(kFrame);
    } else if (!eye->next_frame(milliseconds(100))) {
      return 0.0;
    }
  }
  return 1e3 * seconds / (cpu_ms() - begin);
}

int run() {
  const sim_hal::Scenario scenario = sim_hal::built_in_scenario();
  fmt::print(
      "| frame of 640 x 480 | shapes | rays of what moved ms | all rays ms | noise ms | frame ms |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: |\n");
  std::size_t differ = 0;
  for (const auto& [name, from_s] :
       {std::pair{"nobody there yet", 0.2}, std::pair{"the person holds", kHolding_s}}) {
    const FrameCost c = frame_cost(scenario, from_s);
    fmt::print("| {} | {} | {:.2f} | {:.2f} | {:.2f} | **{:.2f}** |\n", name, c.shapes, c.rays, c.rays_anew,
               c.noise, c.whole());
    differ += c.differ;
  }
  const double physics = times_real_time(scenario, 10.0, false),
               sensor = times_real_time(scenario, 10.0, true);
  const double begin = cpu_ms();
  const tests::SimulatedLift lift = tests::simulate(scenario, control::Method::Fast, 1);
  const double lift_s = 1e-3 * (cpu_ms() - begin);
  const control::RunTiming& t = lift.record.timing;
  fmt::print("\n| | times real time | aim |\n| --- | ---: | ---: |\n");
  fmt::print("| physics alone | {:.0f} | |\n| physics and camera, 30 frames/s | {:.1f} | 8 |\n", physics,
             sensor);
  fmt::print("| a whole lift of {:.1f} s with seeing and planning, {:.1f} s | {:.1f} | 5 |\n", t.sim_s,
             lift_s, t.sim_s / lift_s);
  if (lift.record.outcome != control::RunRecord::Result::Lifted)
    fmt::print("\nThe lift did not end with a lifted object: {}.\n", lift.record.reason);
  fmt::print("\nOf all these frames {} pixels differ from an image that is cast anew.\n", differ);
  return differ <= kMayDiffer ? 0 : 1;
}

}  // namespace
}  // namespace colift::bench

int main() {
  return colift::bench::run();
}
