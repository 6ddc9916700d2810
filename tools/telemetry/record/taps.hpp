#pragma once

// Inside of RunTelemetry: what stands between the job and its devices. Not for other folders.

#include <cstdint>
#include <functional>
#include <memory>

#include "hal/robot.hpp"
#include "hal/types/spsc_ring.hpp"
#include "tools/telemetry/record/cycle_inputs.hpp"

namespace colift::telemetry {

/// One cycle of the arm, as it leaves the arm's thread.
struct ArmSample {
  hal::Timestamp measured_at{0};
  bool missed = false;
  bool answered = false;
  hal::Duration answer{0};  ///< From state to command, by the machine's clock.
};
using ArmRing = hal::SpscRing<ArmSample, 1024>;

/// What the taps write into.
struct TapBook {
  CycleInputs now;       ///< The task's cycle that is going on. Task's thread only.
  bool listens = false;  ///< Only the job's own questions count, from its first one on.
  bool in_step = true;   ///< The task runs the arm's cycle itself.
  std::uint64_t frames = 0;
  ArmRing arm;
  /// A frame came: from which camera, its number among all, itself.
  std::function<void(std::size_t, std::uint64_t, const hal::DepthFrame&)> on_frame;
};

[[nodiscard]] std::unique_ptr<hal::Arm> tap_arm(std::unique_ptr<hal::Arm> arm,
                                                const std::shared_ptr<TapBook>& book, const hal::Clock& wall);
[[nodiscard]] std::unique_ptr<hal::Hand> tap_hand(std::unique_ptr<hal::Hand> hand,
                                                  const std::shared_ptr<TapBook>& book);
[[nodiscard]] std::unique_ptr<hal::DepthCamera> tap_camera(std::unique_ptr<hal::DepthCamera> camera,
                                                           const std::shared_ptr<TapBook>& book,
                                                           std::size_t number);
[[nodiscard]] std::unique_ptr<hal::Clock> tap_clock(std::unique_ptr<hal::Clock> clock,
                                                    const std::shared_ptr<TapBook>& book);

}  // namespace colift::telemetry
