#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "hal/depth_camera.hpp"
#include "sim_hal/mock/fault_plan.hpp"
#include "sim_hal/synthetic/kinect/kinect_noise.hpp"
#include "sim_hal/synthetic/ray_caster.hpp"
#include "sim_hal/synthetic/shapes.hpp"

namespace colift::sim_hal {

/// What a MockCamera films.
struct CameraScript {
  std::function<World(std::uint64_t frame)> world;  ///< The world at the time of a frame; 0 is the first.
  hal::CameraIntrinsics intrinsics;
  Pose X_WC = Pose::Identity();
  bool ideal = false;  ///< Without any noise.
  KinectNoise noise;
  std::uint64_t seed = 0;  ///< Frame n is measured with the noise of seed and n.
  hal::Duration period = std::chrono::nanoseconds(33'333'333);
};

/// A depth camera that renders a scripted world, in lock step with a clock that only it and the test move:
/// waiting for a frame advances the clock to the frame's exposure, or by `timeout` where none comes in that
/// time. When the clock has been moved past several frames, the newest is delivered, as a real driver would.
class MockCamera final : public hal::DepthCamera {
 public:
  enum class Fault {
    Freeze,     ///< The image of the last good frame again, under a new time.
    Drop,       ///< No frame: next_frame() waits for the next good one or times out.
    AllNan,     ///< A frame in which nothing was seen.
    WrongSize,  ///< Half of the rows are missing from the data.
    Unplug,  ///< LinkLost, until configure() and activate() are called after the fault's last frame is due.
  };

  /// The clock has to outlive the camera.
  MockCamera(CameraScript script, hal::ManualClock& clock);

  /// Frames `first` to `first + count - 1` suffer the fault. Later calls win where they overlap.
  void inject(Fault fault, std::uint64_t first, std::uint64_t count = 1) {
    faults_.inject(fault, first, count);
  }

  /// Errors: BadConfig (no world, no pixels, no period), LinkLost (unplugged).
  [[nodiscard]] hal::Result<> configure() override;
  [[nodiscard]] hal::Result<> activate() override;
  void deactivate() noexcept override;
  [[nodiscard]] hal::DeviceHealth health() const override { return health_; }
  [[nodiscard]] hal::Result<hal::DepthFrame> next_frame(std::chrono::milliseconds timeout) override;

 private:
  [[nodiscard]] hal::Timestamp due(std::uint64_t frame) const;
  [[nodiscard]] std::uint64_t newest_due() const;
  [[nodiscard]] hal::DepthFrame render(std::uint64_t frame) const;
  [[nodiscard]] hal::Result<hal::DepthFrame> deliver(std::uint64_t frame, std::optional<Fault> fault);
  [[nodiscard]] tl::unexpected<hal::Error> drop_link(std::string where);

  CameraScript script_;
  hal::ManualClock& clock_;
  hal::Timestamp start_;
  FaultPlan<Fault> faults_;
  std::uint64_t next_ = 0;  // first frame that has not been delivered
  std::vector<float> last_good_;
  hal::DeviceHealth health_;
};

}  // namespace colift::sim_hal
