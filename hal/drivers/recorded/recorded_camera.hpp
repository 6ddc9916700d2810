#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "hal/config/range.hpp"
#include "hal/depth_camera.hpp"
#include "hal/drivers/recorded/frame_file.hpp"

namespace colift::hal {

/// Which recording is played, and how.
struct RecordedCameraConfig {
  std::string path;  ///< File or folder; a folder's depth*.png, or else its *.pcd and *.ply.
  double period_s = 1.0 / 30.0;
  bool loop = false;

  template <class Visitor>
  void visit(Visitor& v) {
    v("path", path, kAny,
      "Recorded frame, or folder with depth*.png and camera.json or with *.pcd and *.ply.");
    v("period_s", period_s, Range{1e-4, 3600.0}, "Time from one frame to the next, as it is handed out.");
    v("loop", loop, kAny, "Begin again after the last frame, instead of reporting the camera lost.");
  }
};

/// A depth camera that hands out recorded frames, one per call, without waiting. Frame number i was exposed
/// at i times the period, also in later rounds of a loop: time never runs backwards.
class RecordedCamera final : public DepthCamera {
 public:
  explicit RecordedCamera(RecordedCameraConfig config) : config_(std::move(config)) {}

  /// The frames of a list, in its order; the config's path is not used.
  RecordedCamera(std::vector<std::filesystem::path> files, RecordedCameraConfig config)
      : config_(std::move(config)), listed_(std::move(files)) {}

  /// Finds the files, sorted by name with numbers as numbers, and begins with the first.
  /// Errors: BadConfig (nothing there to play, or a period that is none).
  [[nodiscard]] Result<> configure() override;

  [[nodiscard]] Result<> activate() override;
  void deactivate() noexcept override;
  [[nodiscard]] DeviceHealth health() const override { return health_; }

  /// Errors: NotReady (not activated), LinkLost (end of the recording), BadInput (a damaged file; the next
  /// call goes on behind it).
  [[nodiscard]] Result<DepthFrame> next_frame(std::chrono::milliseconds timeout) override;

  [[nodiscard]] const std::vector<std::filesystem::path>& files() const { return files_; }

  /// The camera in the frame of the last file that was handed out.
  [[nodiscard]] const Pose& X_FC() const { return X_FC_; }

 private:
  RecordedCameraConfig config_;
  std::vector<std::filesystem::path> listed_, files_;
  std::size_t next_ = 0;
  std::uint64_t handed_out_ = 0;
  std::size_t failed_in_a_row_ = 0;
  bool active_ = false;
  Pose X_FC_ = Pose::Identity();
  DeviceHealth health_;
};

}  // namespace colift::hal
