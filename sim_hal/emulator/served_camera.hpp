#pragma once

#include <cstdint>

namespace colift::sim_hal {

/// The far end of a camera that a rig serves beside arm and hand.
class ServedCamera {
 public:
  struct Report {
    std::uint64_t frames = 0;      ///< Sent.
    double worst_render_ms = 0.0;  ///< From the moment of exposure to what is sent.
  };

  virtual ~ServedCamera() = default;
  /// The scenario begins: its faults count from now on.
  virtual void begin() = 0;
  /// Its world is not looked at any more. Any thread; returns when it is so.
  virtual void stop() = 0;
  [[nodiscard]] virtual Report report() const = 0;
};

}  // namespace colift::sim_hal
