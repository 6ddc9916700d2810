#pragma once

#include <cstdint>
#include <string>

#include "hal/types/result.hpp"

namespace colift::hal {

/// How a device is, in words that an operator sees.
struct DeviceHealth {
  enum class State { Absent, Opening, Streaming, Stalled, Lost, Failed };
  State state = State::Absent;
  std::uint64_t accepted = 0;  ///< Frames, packets or replies that were used.
  std::uint64_t rejected = 0;  ///< Those that were dropped: wrong size, stale, doubled, out of range.
  std::string last_error;      ///< Empty while nothing went wrong.
};

/// The life of every device: configure() finds and opens it, activate() lets it act, deactivate() brings it
/// to rest.
class Device {
 public:
  virtual ~Device() = default;

  /// Opens the device. Errors: NotReady, LinkLost, BadConfig, DeviceFault. May be called again after
  /// LinkLost.
  [[nodiscard]] virtual Result<> configure() = 0;

  /// Lets the device act or stream. Errors: NotReady before configure().
  [[nodiscard]] virtual Result<> activate() = 0;

  /// Brings the device to rest; always succeeds and may be called any number of times.
  virtual void deactivate() noexcept = 0;

  /// From one thread, which may be another one than the device's own.
  [[nodiscard]] virtual DeviceHealth health() const = 0;
};

}  // namespace colift::hal
