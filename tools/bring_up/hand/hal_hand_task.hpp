#pragma once

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "hal/drivers/barrett_can/barrett_hand.hpp"
#include "hal/drivers/barrett_can/emergency_open.hpp"
#include "hal/drivers/barrett_can/service/hand_reading.hpp"
#include "hal/hand.hpp"
#include "tools/bring_up/task_outcome.hpp"

namespace colift::tools {

/// What the hand is asked to do during bring-up.
struct HandTask {
  enum class Kind {
    Watch,  ///< Nothing moves.
    Open,
    Preshape,
    Close,
    Grip,  ///< Close, then hold and watch the grip.
  };
  Kind kind = Kind::Watch;
  double for_s = std::numeric_limits<double>::infinity();  ///< Of watching, or of holding a grip.
  double spread_rad = 0.0, torque_nm = 0.5;
  bool although_loaded = false;  ///< Opens a hand that holds something.
};

/// How it ended.
struct HandTaskEnd {
  using How = TaskOutcome;
  How how = How::Done;
  std::string reason;
  hal::ErrorCode code = hal::ErrorCode::Timeout;  ///< Of what refused or failed.
  double took_s = 0.0;                            ///< Of the motion.
  hal::HandState before, after;
  bool moved = false;
  std::string motors;  ///< What was read back of them at the end; empty: nothing was switched off.
  std::array<std::optional<std::int32_t>, 4> modes{};  ///< The same as MODE of each puck.
  bool weak = false;  ///< It stopped on something, with far less torque than was asked.
  double min_force_n = std::numeric_limits<double>::quiet_NaN();  ///< Sum over the pads while gripping.
  std::uint64_t states = 0, bad_states = 0;
};

/// What leaves the task while it goes on.
struct HandTaskHooks {
  std::function<bool()> interrupted;
  std::function<void()> pause;  ///< Lets some milliseconds pass.
  std::function<void(std::string_view doing, const std::optional<hal::HandState>& state)> progress;
  std::function<hal::HandReport()> report;
};

/// Opens the hand and runs the task; at the end the motors rest, and what is held stays held by the worm
/// gears. `hand` is the guarded one.
[[nodiscard]] HandTaskEnd run_hand_task(hal::Hand& hand, const HandTask& task, const hal::Clock& clock,
                                        const HandTaskHooks& hooks);

/// All that is said about the hand at one moment.
struct HandView {
  std::string bus;
  hal::DeviceHealth health;
  hal::HandReport report;
  std::optional<hal::HandState> state;
  double at_s = 0.0;
};
/// One screen: bus, joints, strain, pads, temperatures, what it holds.
[[nodiscard]] std::string hand_screen(const HandView& view);
/// One line of it.
[[nodiscard]] std::string hand_line(const HandView& view);
/// The pads as bars.
[[nodiscard]] std::string tactile_text(const HandView& view);
/// What was done, in sentences.
[[nodiscard]] std::string hand_summary(const HandTask& task, const HandTaskEnd& end);
/// What to do about an error of the start.
[[nodiscard]] std::string hand_advice(hal::ErrorCode code, const std::string& bus);
/// A table of what the pucks answered, and what follows from it.
[[nodiscard]] std::string hand_reading_text(const std::string& bus, const hal::HandReading& reading);
/// What is wrong with it; empty: four pucks answer, and none reports an error.
[[nodiscard]] std::string hand_reading_fault(const hal::HandReading& reading);
/// Document colift.hal.hand/1 of it.
[[nodiscard]] std::string hand_reading_document(const std::string& bus, const hal::HandReading& reading);
/// Document colift.hal.hand/1 of a bundle that was written; `fault`: why there is no state in it, or empty.
[[nodiscard]] std::string bundle_document(const std::string& file, const std::string& fault);
/// Document colift.hal.hand/1 of an emergency opening.
[[nodiscard]] std::string hand_emergency_document(const std::array<hal::FingerOpening, 3>& fingers);
/// Document colift.hal.hand/1.
[[nodiscard]] std::string hand_document(const std::string& verb, const HandView& view, const HandTask& task,
                                        const HandTaskEnd& end);

}  // namespace colift::tools
