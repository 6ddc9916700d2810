#pragma once

#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "hal/can_bus.hpp"
#include "sim_hal/emulator/hand/hand_faults.hpp"
#include "sim_hal/emulator/hand/hand_plant.hpp"
#include "sim_hal/emulator/hand/hand_puck.hpp"
#include "sim_hal/emulator/hand/hand_report.hpp"

namespace colift::sim_hal {

struct HandEmulatorConfig {
  HandPuckConfig puck;
  std::array<std::optional<int>, kHandPucks> group_c;  ///< Other than puck.group_c.
  hal::Duration latency = std::chrono::microseconds(150), jitter = std::chrono::microseconds(70);
  hal::Duration pad_scan = std::chrono::milliseconds(20);  ///< From the wish to a scan's first frame.
  double brown_out_units = 0.0;  ///< The supply breaks down when all motors together give more; 0: never.
  bool judges_pace = true;       ///< Settings too close together; nothing to judge where TCP bundles frames.
  std::vector<HandFault> faults;
  std::uint64_t seed = 1;
};

/// A BarrettHand at the far end of a CAN bus: four pucks with the firmware's visible behaviour, their motors
/// a plant. A judge of clients: shares no code with CoLift's driver. Time is handed in, there is no thread;
/// hand_server.hpp runs it in real time, hand_lock_step.hpp in a test's.
class HandEmulator {
 public:
  using OnEvent = std::function<void(double t_s, const std::string& text)>;
  /// A fault of the client's end begins or ends (BusOff, Down, Full, Passive), or one error frame is due
  /// (Noise): whoever owns the transport brings it about.
  using OnBus = std::function<void(HandFault::Kind kind, bool begins)>;

  /// Plant and bus have to outlive the emulator; the bus is open.
  HandEmulator(HandEmulatorConfig config, HandPlant& plant, hal::CanBus& bus, OnEvent on_event = {});

  OnBus on_bus;
  std::function<void()> on_unacknowledged;  ///< A frame that no puck acknowledged.

  /// Power comes on at `now`. Errors: BadConfig.
  [[nodiscard]] hal::Result<> start(hal::Timestamp now);
  /// When anything is due: a millisecond of the motors or an answer.
  [[nodiscard]] hal::Timestamp next_event() const;
  /// Everything that is due until `now`, and what the bus has.
  void step(hal::Timestamp now);
  /// The same for a frame that the caller has received.
  void deliver(const hal::CanFrame& frame, hal::Timestamp at);

  /// A fault more than configured; its time is from start().
  void inject(const HandFault& fault);
  /// A person mends whatever is wrong: faults are over, pucks in error are switched off and on. What else
  /// faults have done to pucks stays done.
  void mend();
  /// This machine did not run the emulator for a while: for as long as a puck takes to wake, its client
  /// cannot know when it will be awake.
  void stood_still() { stood_still_s_ = t_s_; }
  [[nodiscard]] double elapsed_s() const { return t_s_; }
  [[nodiscard]] const HandPuck& puck(std::size_t index) const { return pucks_[index]; }
  /// A weight that bends a finger's outer link open (N m), until another.
  void hang(std::size_t finger, double weight_nm) { hung_nm_[finger] = weight_nm; }
  [[nodiscard]] const HandEmulatorReport& report() const { return report_; }

 private:
  struct Letter {
    hal::Timestamp due{0};
    hal::CanFrame frame;
  };

  void tick();
  void flush(hal::Timestamp now);
  [[nodiscard]] hal::Timestamp next_out() const;
  void hear(std::size_t puck, const HandRequest& request, hal::Timestamp at);
  void set(std::size_t puck, int property, std::int32_t value, hal::Timestamp at);
  void judge_set(std::size_t puck, int property, std::int32_t value, hal::Timestamp at);
  void answer(std::size_t puck, const HandRequest& request, hal::Timestamp at);
  void begin_scan(std::size_t puck, hal::Timestamp at);
  void send_scan(std::size_t puck);
  void post(std::size_t puck, hal::CanFrame frame, hal::Timestamp due);
  void run_faults();
  void act(const HandFault& fault, bool begins);
  void reset(std::size_t puck, const char* reason);
  [[nodiscard]] const HandFault* active(HandFault::Kind kind, std::size_t puck) const;
  [[nodiscard]] bool hears(std::size_t puck) const;
  [[nodiscard]] bool connected() const;
  [[nodiscard]] bool acknowledged() const;
  void broke(HandRule rule, std::string how, bool excused = false);
  [[nodiscard]] bool asleep_by_fault(std::size_t puck) const;
  void turn_from_outside(const HandMotor& spread);
  void event(const std::string& text) const;
  [[nodiscard]] double chance();

  HandEmulatorConfig config_;
  HandPlant& plant_;
  hal::CanBus& bus_;
  OnEvent on_event_;
  std::vector<HandPuck> pucks_;
  std::vector<Letter> out_;
  std::vector<bool> began_, ended_;
  std::array<std::optional<hal::Timestamp>, kHandPucks> scan_due_{};
  std::array<hal::Timestamp, kHandPucks> last_set_{};
  std::array<bool, kHandPucks> was_ready_{};
  std::array<bool, kHandPucks> faulted_{};  ///< A fault took its zero; until it has found its stop.
  std::array<double, kHandFingers> hung_nm_{};
  double turned_ = 0.0;  ///< Counts that the spread was turned from outside.
  hal::Timestamp start_{0}, next_tick_{0}, wire_free_{0};
  double t_s_ = 0.0, stood_still_s_ = -1e9;
  int foreign_ms_ = 0, noise_ms_ = 0;
  std::uint64_t dice_;
  HandEmulatorReport report_;
};

}  // namespace colift::sim_hal
