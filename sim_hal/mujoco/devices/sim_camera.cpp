#include "sim_hal/mujoco/devices/sim_camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

#include "sim_hal/mujoco/devices/projector_overlap.hpp"
#include "sim_hal/synthetic/hash_random.hpp"
#include "sim_hal/synthetic/kinect/kinect_noise.hpp"

namespace colift::sim_hal {
namespace {

using hal::ErrorCode;
using State = hal::DeviceHealth::State;
using std::chrono::milliseconds;

constexpr std::uint64_t kFramesPerSecond = 30;
constexpr auto kOffset = milliseconds(11);             // from one camera to the next
constexpr auto kStall = milliseconds(100);             // three frames that did not come
constexpr auto kLate = milliseconds(200);              // how much later than it should a late frame comes
constexpr double kMoved_m = 0.05, kMoved_rad = 0.087;  // of somebody who pushed the tripod

/// The newest frame whose exposure is not after a time.
std::uint64_t newest_due(hal::Timestamp now) {
  const auto ms = static_cast<std::uint64_t>(
      std::max(std::chrono::floor<milliseconds>(now).count(), milliseconds::rep{0}));
  return ms * kFramesPerSecond / 1000;
}

Pose moved_camera_pose(const ScenarioCamera& camera) {
  Pose X_WC = camera_pose(camera);
  X_WC.translate(Vec3(kMoved_m, 0.0, 0.0)).rotate(Eigen::AngleAxisd(kMoved_rad, Vec3::UnitY()));
  return X_WC;
}

class SimCamera final : public hal::DepthCamera {
 public:
  SimCamera(SimWorld& world, std::size_t number)
      : world_(world),
        place_(number == 0 ? world.scenario().camera : world.scenario().more_cameras.at(number - 1)),
        name_(hal::camera_name(number)),
        number_(number),
        offset_(kOffset * static_cast<int>(number)),
        caster_(hal::CameraIntrinsics{}, camera_pose(place_)),
        overlap_(world, number) {
    for (const DeviceFaultEvent& fault : world.scenario().faults)
      may_freeze_ |= fault.device == name_ && fault.action == "freeze";
    for (const DeviceFaultEvent& fault : world.scenario().faults)
      if (fault.device == name_ && fault.action == "moved")
        moved_.emplace(hal::CameraIntrinsics{}, moved_camera_pose(place_));
  }

  hal::Result<> configure() override {
    if (fault_now() == "unplug" || fault_now() == "crash") return drop_link("sim_camera.configure");
    // what went by while the link was down was never seen
    if (health_.state == State::Lost) next_ = std::max(next_, newest_due(now() - offset_));
    health_.state = State::Opening;
    return {};
  }

  hal::Result<> activate() override {
    if (health_.state != State::Opening && !streams())
      return hal::failure(ErrorCode::NotReady, "sim_camera.activate",
                          "the camera is not open, call configure() first");
    health_.state = State::Streaming;
    return {};
  }

  void deactivate() noexcept override {
    if (streams()) health_.state = State::Opening;
    late_.reset();
  }

  [[nodiscard]] hal::DeviceHealth health() const override { return health_; }

  hal::Result<hal::DepthFrame> next_frame(milliseconds timeout) override {
    constexpr auto kWhere = "sim_camera.next_frame";
    if (health_.state == State::Lost) return hal::failure(ErrorCode::LinkLost, kWhere, health_.last_error);
    if (!streams())
      return hal::failure(ErrorCode::NotReady, kWhere, "the camera does not stream, call activate() first");

    const hal::Timestamp deadline = now() + std::max(timeout, milliseconds(0));
    for (;;) {
      const hal::Timestamp due = late_ ? late_->exposed_at + kLate : exposure_due(next_) + offset_;
      if (std::max(due, now()) > deadline) break;
      if (due > now()) world_.advance(due - now());
      if (fault_now() == "unplug" || fault_now() == "crash") return drop_link(kWhere);
      if (late_) return hand_out(std::move(*std::exchange(late_, std::nullopt)));
      // of several that are due only the newest is there
      const std::uint64_t frame = std::max(next_, newest_due(now() - offset_));
      next_ = frame + 1;
      const std::string_view fault = fault_now();
      const bool seldom = fault == "slow" && frame % kSlowEvery != 0;
      if (fault == "drop" || fault == "silent" || fault == "hang" || seldom) {
        ++health_.rejected;
        continue;
      }
      hal::DepthFrame image = expose(frame, fault);
      if (fault != "late") return hand_out(std::move(image));
      late_ = std::move(image);
    }
    if (deadline > now()) world_.advance(deadline - now());
    const std::string none = fmt::format("no frame within {} ms", timeout.count());
    // who only asks whether there is one already has not waited in vain
    if (timeout > milliseconds(0) || now() - handed_out_at_ > kStall) {
      health_.state = State::Stalled;
      health_.last_error = none;
    }
    return hal::failure(ErrorCode::Timeout, kWhere, none);
  }

 private:
  [[nodiscard]] hal::Timestamp now() const { return world_.clock().now(); }
  [[nodiscard]] bool streams() const {
    return health_.state == State::Streaming || health_.state == State::Stalled;
  }

  /// What is wrong at this moment; empty when nothing is. The later entry wins.
  [[nodiscard]] std::string_view fault_now() const {
    const double t = hal::seconds(world_.elapsed());
    const auto& faults = world_.scenario().faults;
    for (auto it = faults.rbegin(); it != faults.rend(); ++it)
      if (it->device == name_ && it->active(t)) return it->action;
    return {};
  }

  tl::unexpected<hal::Error> drop_link(std::string where) {
    health_.state = State::Lost;
    health_.last_error = fmt::format("the camera is unplugged since {:.3f} s", hal::seconds(now()));
    late_.reset();
    return hal::failure(ErrorCode::LinkLost, std::move(where), health_.last_error);
  }

  hal::DepthFrame expose(std::uint64_t frame, std::string_view fault) {
    const Rendering& truth = (fault == "moved" ? *moved_ : caster_).cast(world_.shapes());
    const bool ideal = place_.noise == "none";
    hal::DepthFrame image =
        ideal ? measure_ideal(truth)
              : measure(truth, KinectNoise{}, hash(world_.seed(), kNoiseStream + kStreams * number_, frame));
    if (!ideal) overlap_.apply(image, frame);
    image.exposed_at = now();
    if (fault == "freeze") {
      // a camera that freezes with its first frame shows that one
      if (last_good_.empty()) last_good_ = image.depth_m;
      image.depth_m = last_good_;
    } else if (fault == "blind") {
      std::fill(image.depth_m.begin(), image.depth_m.end(), std::numeric_limits<float>::quiet_NaN());
    } else if (fault == "zeros") {
      std::fill(image.depth_m.begin(), image.depth_m.end(), 0.0F);
    } else if (fault == "holes") {
      punch_holes(image);
    } else if (fault == "corrupt") {
      image.depth_m.resize(image.depth_m.size() / 2);
    } else if (may_freeze_) {
      last_good_ = image.depth_m;
    }
    return image;
  }

  /// Sunlight: blots that never show anything, the same in every frame.
  void punch_holes(hal::DepthFrame& image) const {
    const auto width = static_cast<std::size_t>(image.intrinsics.width);
    for (std::size_t i = 0; i < image.depth_m.size(); ++i) {
      const std::size_t blot = i / width / kBlot_px * width + i % width / kBlot_px;
      if (unit(hash(world_.seed(), kHoleStream, blot)) < kHoles)
        image.depth_m[i] = std::numeric_limits<float>::quiet_NaN();
    }
  }

  hal::DepthFrame hand_out(hal::DepthFrame image) {
    health_.state = State::Streaming;
    ++health_.accepted;
    handed_out_at_ = now();
    return image;
  }

  static constexpr std::uint64_t kNoiseStream = 71, kHoleStream = 72, kStreams = 100;
  static constexpr std::uint64_t kSlowEvery = 6;  // of 30 frames a second: 5
  static constexpr std::size_t kBlot_px = 16;
  static constexpr double kHoles = 0.5;

  SimWorld& world_;
  ScenarioCamera place_;
  std::string name_;
  std::uint64_t number_;
  hal::Duration offset_;  // nothing synchronises cameras
  RayCaster caster_;
  ProjectorOverlap overlap_;
  std::optional<RayCaster> moved_;  // where a fault moves it
  bool may_freeze_ = false;
  std::uint64_t next_ = 0;  // first frame that has not been exposed
  hal::Timestamp handed_out_at_{0};
  std::vector<float> last_good_;
  std::optional<hal::DepthFrame> late_;
  hal::DeviceHealth health_;
};

}  // namespace

hal::Timestamp exposure_due(std::uint64_t frame) {
  return milliseconds((frame * 1000 + kFramesPerSecond - 1) / kFramesPerSecond);
}

Rendering render_truth(const SimWorld& world) {
  return cast_rays(world.shapes(), hal::CameraIntrinsics{}, camera_pose(world.scenario().camera));
}

std::unique_ptr<hal::DepthCamera> make_sim_camera(SimWorld& world) {
  return std::make_unique<SimCamera>(world, 0);
}

std::vector<std::unique_ptr<hal::DepthCamera>> make_more_sim_cameras(SimWorld& world) {
  std::vector<std::unique_ptr<hal::DepthCamera>> cameras;
  for (std::size_t n = 1; n <= world.scenario().more_cameras.size(); ++n)
    cameras.push_back(std::make_unique<SimCamera>(world, n));
  return cameras;
}

std::vector<Pose> more_camera_poses(const Scenario& scenario) {
  std::vector<Pose> poses;
  for (const ScenarioCamera& camera : scenario.more_cameras) poses.push_back(camera_pose(camera));
  return poses;
}

Pose camera_pose(const ScenarioCamera& camera) {
  return look_at(camera.xyz, camera.look_at);
}

}  // namespace colift::sim_hal
