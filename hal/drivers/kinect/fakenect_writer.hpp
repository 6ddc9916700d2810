#pragma once

#include <filesystem>
#include <string>

#include "hal/drivers/capture_link/frame_ring.hpp"
#include "hal/types/time.hpp"

namespace colift::hal::kinect {

/// Writes a recording that libfreenect's fakenect plays, and so every program for libfreenect: the raw codes
/// and the accelerometer, as fakenect-record does, in a folder with INDEX.txt. Whole after each frame.
class FakenectWriter {
 public:
  /// A folder that is made, or is empty. Errors: BadInput (it holds something, or cannot be written).
  [[nodiscard]] static Result<FakenectWriter> open(const std::filesystem::path& folder);

  /// `at` counts from anywhere, and not backwards. Errors: BadInput (the disk is full).
  [[nodiscard]] Result<> write(const capture::RawFrame& depth, Timestamp at);

  [[nodiscard]] std::uint64_t frames() const { return frames_; }
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  explicit FakenectWriter(std::filesystem::path folder) : folder_(std::move(folder)) {}
  std::filesystem::path folder_;
  std::uint64_t frames_ = 0, bytes_ = 0;
};

}  // namespace colift::hal::kinect
