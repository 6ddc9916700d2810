#include "sim_hal/mujoco/devices/sim_infrared.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "hal/robot_model/robot_model.hpp"
#include "sim_hal/mujoco/devices/sim_camera.hpp"
#include "sim_hal/mujoco/devices/sim_devices.hpp"
#include "sim_hal/synthetic/hash_random.hpp"
#include "sim_hal/synthetic/infrared_scene.hpp"

namespace colift::sim_hal {
namespace {

using std::chrono::milliseconds;

constexpr std::uint64_t kFramesPerSecond = 30, kNoiseStream = 91, kArmStream = 92;

class SimInfrared final : public hal::InfraredCamera {
 public:
  SimInfrared(SimWorld& world, const SimEmitter& emitter) : world_(world), eye_(world, emitter) {}

  hal::Result<> want_infrared(bool wanted) override {
    wanted_ = wanted;
    next_ = std::max(next_, newest_due());
    return {};
  }

  hal::Result<hal::InfraredFrame> next_infrared(milliseconds timeout) override {
    constexpr auto kWhere = "sim_camera.next_infrared";
    if (!wanted_) return hal::failure(hal::ErrorCode::NotReady, kWhere, "no infrared images were asked for");
    const hal::Timestamp due = exposure_due(next_);
    if (due > now() + std::max(timeout, milliseconds(0)))
      return hal::failure(hal::ErrorCode::Timeout, kWhere,
                          fmt::format("no image within {} ms", timeout.count()));
    if (due > now()) world_.advance(due - now());
    const std::uint64_t frame = std::max(next_, newest_due());
    next_ = frame + 1;
    return eye_.expose(frame);
  }

 private:
  [[nodiscard]] hal::Timestamp now() const { return world_.clock().now(); }
  [[nodiscard]] std::uint64_t newest_due() const {
    const auto ms = static_cast<std::uint64_t>(std::chrono::floor<milliseconds>(now()).count());
    return ms * kFramesPerSecond / 1000;
  }

  SimWorld& world_;
  SimInfraredSource eye_;
  bool wanted_ = false;
  std::uint64_t next_ = 0;
};

}  // namespace

SimInfraredSource::SimInfraredSource(const SimWorld& world, const SimEmitter& emitter)
    : world_(world), emitter_(emitter), caster_(hal::infrared_of({}), camera_pose(world.scenario().camera)) {
  // a smooth error of the kinematics: one wave over the joints for each axis
  Draws draws(world.seed(), kArmStream);
  for (int a = 0; a < 3; ++a) {
    for (int i = 0; i < hal::kArmJoints; ++i) wave_(a, i) = draws.between(-3.0, 3.0);
    phase_[a] = draws.between(0.0, 2.0 * std::numbers::pi);
  }
}

void SimInfraredSource::move_to(const Pose& X_WC) {
  caster_ = RayCaster(hal::infrared_of({}), X_WC);
}

hal::InfraredFrame SimInfraredSource::expose(std::uint64_t frame) {
  const hal::Timestamp now = world_.clock().now();
  const Rendering& truth = caster_.cast(world_.shapes());
  const hal::JointVector q = world_.truth().q_rad;
  const Pose X_WH = hal::hand_pose(world_.model(), q);
  std::optional<Emitter> lit;
  if (static_cast<long>(std::floor(hal::seconds(now) / emitter_.blink_s)) % 2 == 0) {
    lit.emplace();
    lit->at_W = X_WH * emitter_.at_H;
    for (int a = 0; a < 3; ++a)
      lit->at_W[a] += std::numbers::sqrt2 * emitter_.arm_m * std::sin(wave_.row(a).dot(q) + phase_[a]);
    lit->towards_W = X_WH.linear().col(2);
  }
  InfraredNoise noise;
  noise.spot_px = emitter_.spot_px;
  // by the pose, coarsely: an arm that stands still trembles by less
  for (int i = 0; i < hal::kArmJoints; ++i)
    noise.pose_seed =
        hash(noise.pose_seed, kArmStream, static_cast<std::uint64_t>(std::lround(q[i] * 20.0) + 1000));
  auto image = expose_infrared(truth, lit, {}, noise, hash(world_.seed(), kNoiseStream, frame));
  image.exposed_at = now;
  return image;
}

std::unique_ptr<hal::InfraredCamera> make_sim_infrared(SimWorld& world, const SimEmitter& emitter) {
  return std::make_unique<SimInfrared>(world, emitter);
}

}  // namespace colift::sim_hal
