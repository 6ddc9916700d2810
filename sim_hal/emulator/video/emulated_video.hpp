#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "hal/video_calls.hpp"
#include "sim_hal/emulator/video/video_faults.hpp"
#include "sim_hal/emulator/video/video_source.hpp"

namespace colift::sim_hal {

struct EmulatedVideoConfig {
  std::string path = "/dev/video0";
  double rate_hz = 30.0;  ///< Most that it gives; a lower one may be asked for.
  double unit_m = 0.001;
  std::size_t padding = 0;  ///< Bytes after each row.
  std::vector<VideoFault> faults;
};

struct EmulatedVideoReport {
  std::uint64_t exposed = 0;              ///< Images that were due while it streamed.
  std::uint64_t handed_over = 0;          ///< Dequeued by the client.
  std::uint64_t not_taken = 0;            ///< No buffer was free for them.
  std::uint64_t opened = 0;               ///< Times.
  int descriptors = 0, mapped = 0;        ///< Open and mapped now.
  std::vector<std::string> broken_rules;  ///< What a client must not do, and did.
};

/// A depth camera as the kernel's V4L2 serves it, behind the system calls: capabilities, formats, buffers and
/// their states, time stamps, refusals. One client. Images are due by the clock and made when it asks.
class EmulatedVideo final : public hal::VideoCalls {
 public:
  /// How a call waits; the default lets the thread sleep. With a ManualClock: advances it.
  using Sleep = std::function<void(hal::Duration)>;
  /// Sees each ioctl as it is answered and may change what the structure says, or give another result: how a
  /// device lies. Unset result: the device's own.
  using Lie = std::function<std::optional<int>(unsigned long request, void* argument)>;

  /// The clock is the one of the time stamps, and outlives the device.
  EmulatedVideo(EmulatedVideoConfig config, std::unique_ptr<VideoSource> source, const hal::Clock& clock,
                Sleep sleep = {});

  [[nodiscard]] int open(const std::string& path) override;
  int close(int descriptor) override;
  [[nodiscard]] int control(int descriptor, unsigned long request, void* argument) override;
  [[nodiscard]] int map(int descriptor, std::size_t bytes, std::int64_t offset, const void*& to) override;
  int unmap(const void* at, std::size_t bytes) override;
  [[nodiscard]] int wait(int descriptor, hal::Duration timeout) override;

  /// A fault from now on; its `at_s` counts from this call. Any thread.
  void inject(VideoFault fault);
  void lie(Lie lie);
  /// Gone for good: neither clock nor source are asked any more. Any thread; returns when no call uses them.
  void end();
  [[nodiscard]] EmulatedVideoReport report() const;

 private:
  enum class State { Client, Queued, Filled };
  struct Buffer {
    std::vector<std::uint8_t> bytes;
    State state = State::Client;
    bool mapped = false;
    std::uint32_t used = 0, flags = 0, sequence = 0;
    hal::Timestamp stamp{0}, ready_at{0};
  };

  [[nodiscard]] int answer(unsigned long request, void* argument);
  [[nodiscard]] bool gone(int descriptor);
  [[nodiscard]] const VideoFault* now_active(VideoFault::Kind kind) const;
  void expose_what_is_due();
  void expose(hal::Timestamp at);
  void fill(Buffer& b, hal::Timestamp at);
  void take_picture();
  void drop_buffers();
  [[nodiscard]] std::size_t stride() const;
  int broken(const char* rule, int error_number);

  EmulatedVideoConfig config_;
  std::unique_ptr<VideoSource> source_;
  const hal::Clock& clock_;
  Sleep sleep_;

  mutable std::mutex mutex_;  ///< Never held while a call waits.
  Lie lie_;
  hal::Timestamp began_;
  EmulatedVideoReport report_;
  int descriptor_ = -1, last_descriptor_ = 2;
  bool ended_ = false, plugged_ = true, format_set_ = false, streams_ = false;
  double rate_hz_;
  hal::Timestamp next_{0};
  std::uint32_t sequence_ = 0;
  std::vector<Buffer> buffers_;
  std::deque<std::size_t> queued_, filled_;
  /// Buffers of earlier streams that are mapped still.
  std::vector<Buffer> orphans_;
  std::vector<std::uint8_t> picture_;
  bool fresh_ = false;  ///< Whether it is of this call.
  std::optional<hal::Timestamp> same_stamp_;
};

}  // namespace colift::sim_hal
