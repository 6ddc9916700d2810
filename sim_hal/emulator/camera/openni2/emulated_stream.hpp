#pragma once

#include <Driver/OniDriverAPI.h>

#include <array>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <vector>

namespace colift::sim_hal {

/// The depth stream of an emulated device, as OpenNI2's core sees one. It mirrors until it is told not to, as
/// devices do.
class EmulatedStream final : public oni::driver::StreamBase {
 public:
  /// The first mode is the one that it begins with.
  static constexpr std::array<OniVideoMode, 4> kModes{{{ONI_PIXEL_FORMAT_DEPTH_1_MM, 640, 480, 30},
                                                       {ONI_PIXEL_FORMAT_DEPTH_100_UM, 640, 480, 30},
                                                       {ONI_PIXEL_FORMAT_DEPTH_1_MM, 320, 240, 30},
                                                       {ONI_PIXEL_FORMAT_DEPTH_100_UM, 320, 240, 30}}};

  /// A new image: raw codes, row by row, 640 in each; fewer rows make a frame that is cut short. `ticks` is
  /// the device's 32-bit counter, `shifted` whether registration moves it.
  void deliver(const std::vector<std::uint16_t>& codes, std::uint32_t ticks, bool shifted);
  [[nodiscard]] bool runs() const;

  OniStatus start() override;
  /// Returns when no frame is under way any more.
  void stop() override;
  int getRequiredFrameSize() override;
  OniBool isPropertySupported(int property) override;
  OniStatus getProperty(int property, void* data, int* size) override;
  OniStatus setProperty(int property, const void* data, int size) override;

 private:
  void fill(OniFrame& frame, const std::vector<std::uint16_t>& codes, const OniVideoMode& mode, bool mirrored,
            bool shifted) const;

  mutable std::mutex mutex_;
  std::condition_variable delivered_;
  bool runs_ = false, delivers_ = false;
  OniVideoMode mode_ = kModes[0];
  OniBool mirrored_ = TRUE;
  bool counted_ = false;
  std::uint32_t last_ticks_ = 0;
  std::int64_t ticks_ = 0;  ///< Unwrapped, as a device's driver hands them out.
};

}  // namespace colift::sim_hal
