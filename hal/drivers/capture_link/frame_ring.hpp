#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "hal/types/result.hpp"

namespace colift::hal::capture {

// Frames from the capture process to the controller, in memory that both map. The process may be stopped or
// killed at any byte, and whatever it writes is looked at before it is used: size, number, and a sum over the
// pixels. Neither side ever waits for the other.

enum class Stream : std::uint32_t { Depth = 0, Infrared = 1 };
inline constexpr std::uint32_t kMaxStreams = 2, kSlots = 4;
inline constexpr std::uint32_t kMaxSlotPixels = 4U << 20;
inline constexpr std::uint32_t kRingMagic = 0x4b4c4f43, kRingVersion = 2;

/// How much the memory holds: the reader decides it once, before the process is started.
struct RingShape {
  std::uint32_t streams = 1;      ///< 1: depth; 2: infrared too.
  std::uint32_t slot_pixels = 0;  ///< Of the largest image; a multiple of 4.
};

/// What the process is doing, as it says itself.
enum class CaptureState : std::uint32_t { Starting = 0, Opening = 1, Streaming = 2, Ended = 3 };

/// What goes with an image.
struct FrameStamp {
  std::uint64_t number = 0;     ///< In its stream, from 1; a gap where frames were overwritten unread.
  std::uint64_t ticks = 0;      ///< Of the device's clock, in its own units.
  std::uint64_t index = 0;      ///< Of the frame as the device counts; 0 where it does not.
  std::int64_t arrived_ns = 0;  ///< Monotonic clock of this machine, when the library handed it out.
  std::uint32_t width = 0, height = 0;
  std::uint32_t unit_um = 0;          ///< Depth of one unit (um); 0: the pixels are codes of the device.
  std::uint32_t lost_packets = 0;     ///< That the library told of since the frame before.
  std::int32_t accel[3] = {0, 0, 0};  ///< Counts along the device's x, y, z.
  std::int32_t tilt_half_deg = 0;
  std::uint32_t has_accel = 0, spare = 0;
  std::uint64_t sum = 0;  ///< Over the pixels: pixel_sum().
};

struct RawFrame {
  FrameStamp stamp;
  std::vector<std::uint16_t> pixels;
};

/// A sum that any change of a pixel changes, but for one in 2^64.
[[nodiscard]] std::uint64_t pixel_sum(const std::uint16_t* pixels, std::size_t count);

/// Bytes of the whole memory.
[[nodiscard]] std::size_t ring_bytes(const RingShape& shape);

/// The process's side. Maps memory that the controller made; one thread.
class FrameRingWriter {
 public:
  /// Errors: BadInput (not such memory, or of another version).
  [[nodiscard]] static Result<FrameRingWriter> map(int fd);
  FrameRingWriter(FrameRingWriter&&) noexcept;
  FrameRingWriter& operator=(FrameRingWriter&&) noexcept;
  ~FrameRingWriter();

  void beat();  ///< Still alive: with every turn of the process's loop.
  void set_state(CaptureState state);
  /// Number and sum are filled in here. `pixels` are width * height of them. False: no slot is that large, or
  /// there is no such stream; nothing is written.
  bool write(Stream stream, FrameStamp stamp, const std::uint16_t* pixels);

 private:
  FrameRingWriter(void* memory, const RingShape& shape) : memory_(memory), shape_(shape) {}
  void* memory_ = nullptr;
  RingShape shape_;
  std::uint64_t written_[kMaxStreams] = {0, 0};
};

/// The controller's side: makes the memory and reads. One thread.
class FrameRing {
 public:
  /// Memory without a name that cannot be cut short while it is mapped. Errors: BadConfig (no such shape),
  /// DeviceFault (no memory).
  [[nodiscard]] static Result<FrameRing> make(const RingShape& shape);
  FrameRing(FrameRing&&) noexcept;
  FrameRing& operator=(FrameRing&&) noexcept;
  ~FrameRing();

  [[nodiscard]] int fd() const { return fd_; }
  [[nodiscard]] std::uint64_t heartbeat() const;
  [[nodiscard]] CaptureState state() const;
  /// Number of the newest frame, which may be any number at all from a broken process.
  [[nodiscard]] std::uint64_t newest(Stream stream) const;

  /// The newest frame of a stream, if it is none that was read before. `into` keeps its memory. Nothing when
  /// there is none, or when it is being overwritten. Its width * height fit a slot and are those of `pixels`;
  /// Errors: BadReply (not what a frame looks like; it will not be read again).
  [[nodiscard]] Result<bool> read(Stream stream, RawFrame& into);
  /// Frames that came and went between two reads.
  [[nodiscard]] std::uint64_t missed(Stream stream) const {
    return missed_[static_cast<std::size_t>(stream)];
  }

 private:
  FrameRing(int fd, void* memory, const RingShape& shape) : fd_(fd), memory_(memory), shape_(shape) {}
  int fd_ = -1;
  void* memory_ = nullptr;
  RingShape shape_;  ///< Our own: the process may write over that in the memory.
  std::uint64_t read_[kMaxStreams] = {0, 0}, missed_[kMaxStreams] = {0, 0};
};

}  // namespace colift::hal::capture
