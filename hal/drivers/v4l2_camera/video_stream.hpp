#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/drivers/v4l2_camera/v4l2_camera_config.hpp"
#include "hal/types/result.hpp"
#include "hal/video_calls.hpp"

namespace colift::hal::v4l2 {

/// One picture as the kernel handed it over, copied out of the device's buffer.
struct VideoPicture {
  std::vector<std::uint8_t> bytes;
  std::optional<Timestamp> stamp;  ///< Of the monotonic clock; unset: the device's stamps are of another one.
};

/// A video device that streams Z16: opened, negotiated and its buffers mapped by open(), closed by the
/// destructor. Every answer of the device is checked before it is used. One thread, which a call may block.
class VideoStream {
 public:
  /// For pictures of this size, streaming. Errors: LinkLost (there is no device, or it went away), BadConfig
  /// (it is none that can do this: no Z16, another size or rate), DeviceFault (it refuses, or contradicts
  /// itself).
  [[nodiscard]] static Result<std::unique_ptr<VideoStream>> open(VideoCalls& calls,
                                                                 const V4l2CameraConfig& config, int width,
                                                                 int height);
  ~VideoStream();
  VideoStream(const VideoStream&) = delete;
  VideoStream& operator=(const VideoStream&) = delete;

  /// The next picture. Errors: Timeout (none came), BadReply (one came and was dropped: flagged as broken by
  /// the kernel, too short), LinkLost and DeviceFault (this stream is over; open another one).
  [[nodiscard]] Result<VideoPicture> next(Duration timeout);

  /// The newest picture of those that wait, at least one of them good: who comes late is not served the
  /// oldest. The reasons of what was dropped go into `dropped`. Errors: as next().
  [[nodiscard]] Result<VideoPicture> newest(Duration timeout, std::vector<std::string>& dropped);

  [[nodiscard]] std::size_t stride() const { return stride_; }  ///< Bytes from one row to the next.

 private:
  struct Buffer {
    const void* at = nullptr;
    std::size_t bytes = 0;
  };

  VideoStream(VideoCalls& calls, const V4l2CameraConfig& config, int width, int height)
      : calls_(calls), config_(config), width_(width), height_(height) {}
  [[nodiscard]] Result<> negotiate();
  [[nodiscard]] Result<> check_capabilities();
  [[nodiscard]] Result<> find_z16();
  [[nodiscard]] Result<> set_format();
  [[nodiscard]] Result<> set_rate();
  [[nodiscard]] Result<> map_buffers();
  [[nodiscard]] Result<> ask(unsigned long request, void* argument);
  [[nodiscard]] Result<> give_back(std::uint32_t index);

  VideoCalls& calls_;
  const V4l2CameraConfig& config_;
  int width_, height_;
  int descriptor_ = -1;
  bool streams_ = false;
  std::size_t stride_ = 0, bytes_ = 0;
  std::vector<Buffer> buffers_;
};

}  // namespace colift::hal::v4l2
