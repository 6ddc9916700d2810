#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/datagram_link.hpp"
#include "sim_hal/emulator/krc/krc_faults.hpp"
#include "sim_hal/emulator/krc/krc_net_faults.hpp"
#include "sim_hal/emulator/krc/krc_quality.hpp"
#include "sim_hal/emulator/krc/krc_report.hpp"
#include "sim_hal/emulator/krc/krl_script.hpp"

namespace colift::sim_hal {

struct KrcConfig {
  hal::Endpoint to{0x7F000001, 49938};                 ///< The client.
  hal::Duration cycle = std::chrono::milliseconds(2);  ///< Whole milliseconds, 1 to 100.
  std::string script = "colift";                       ///< Name of a KRL program.
  KrlScriptConfig program;
  hal::Pose X_FT = hal::Pose::Identity();  ///< The program's tool.
  KrcLimits limits;
  KrcQualityLimits quality;
  bool strict = false;           ///< Start only at PERFECT, stay only at OK or better.
  int start_cycles = 100;        ///< So many cycles of good quality before command mode ...
  double start_hold_s = 0.4;     ///< ... but no longer than that.
  double start_timeout_s = 1.0;  ///< After that friStart gives up, but not before 250 cycles.
  int extrapolated = 3;          ///< Missing answers in a row that are bridged.
  double temperature_c = 30.0;
  double idle_brakes_s = 20.0;      ///< The brakes close when nothing moved for so long; 0: never.
  bool start_opens_brakes = true;   ///< friStart opens them; else only a motion of the program does.
  std::optional<double> restart_s;  ///< An operator acknowledges faults and restarts the program after that.
  std::vector<KrcFault> faults;
  std::uint64_t seed = 1;
};

/// A KRC2lr behind its Fast Research Interface: the clock of the wire, the controller's state machine, its
/// checks and its KRL program. A judge of clients: shares no code with CoLift's own. Time is handed in, there
/// is no thread; krc_server.hpp runs it in real time, krc_lock_step.hpp in a test's.
class KrcEmulator final : private KrlHost {
 public:
  using OnEvent = std::function<void(double t_s, const std::string& text)>;

  /// All but `config` has to outlive the emulator. `link` is open, or opened before start().
  KrcEmulator(KrcConfig config, const hal::ArmDynamics& dynamics, KrcPlant& plant, hal::DatagramLink& link,
              OnEvent on_event = {});
  ~KrcEmulator() override;
  KrcEmulator(const KrcEmulator&) = delete;
  KrcEmulator& operator=(const KrcEmulator&) = delete;

  /// Starts the program; the first cycle is at `now`. Errors: BadConfig (cycle, script).
  [[nodiscard]] hal::Result<> start(hal::Timestamp now);

  /// When cycle() is due, and when anything is: a cycle or a datagram that a fault holds back.
  [[nodiscard]] hal::Timestamp next_cycle() const { return next_cycle_; }
  [[nodiscard]] hal::Timestamp next_event() const;

  /// Takes what the link has, without waiting, as arrived at `now`.
  void poll(hal::Timestamp now);
  /// The same for a datagram that the caller has received.
  void deliver(std::span<const std::byte> bytes, const hal::Endpoint& from, hal::Timestamp at);
  /// Lets out what faults have held back until `now`.
  void flush(hal::Timestamp now);
  /// One cycle at next_cycle(): judges what came, runs the program, sends the measurement.
  void cycle();
  /// Moves the plant to the end of the cycle. cycle() does it if nobody did: this call lets a real-time loop
  /// choose when.
  void move_plant();

  [[nodiscard]] bool answered() const { return answered_; }
  [[nodiscard]] bool silent() const { return state_ == FriState::Off; }
  /// The program came to its end and nobody will restart it.
  [[nodiscard]] bool ended() const;
  /// A fault more than configured.
  void inject(const KrcFault& fault);
  /// A person mends whatever is wrong: faults are over, and the program is acknowledged and started anew.
  void mend();
  /// Up to this moment.
  [[nodiscard]] KrcReport report() const;
  /// KrcReport's, without making one.
  [[nodiscard]] std::uint64_t missed_in_command() const { return report_.missed_in_command; }

 private:
  // what the program sees
  [[nodiscard]] double now_s() const override { return t_s_; }
  [[nodiscard]] FriState fri_state() const override { return state_; }
  [[nodiscard]] FriQuality fri_quality() const override { return quality_now_; }
  [[nodiscard]] const KrlChannels& from_pc() const override { return from_pc_; }
  [[nodiscard]] KrlChannels& to_pc() override { return to_pc_; }
  [[nodiscard]] Vector6 tool_wrench() const override;
  void ptp_here() override;
  void set_strategy(FriControl control, const KrlStiffness& stiffness) override;
  void fri_open(int ms) override;
  void fri_start(double safety_limits) override;
  [[nodiscard]] bool start_pending() const override { return start_until_s_.has_value(); }
  void fri_stop(const std::string& reason) override;
  void fri_close(const std::string& reason) override;
  [[nodiscard]] int cycle_ms() const override;
  void say(const std::string& text) override { event("KRL: " + text); }

  void take(std::span<const std::byte> bytes, const hal::Endpoint& from, hal::Timestamp at);
  void reject(const std::string& why, bool of_client);
  void count_answer();
  void watch_quality();
  void watch_client();
  void note_faults();
  void act_on_faults();
  void watch_idle();
  void follow_client();
  void run_program();
  void try_start();
  void leave(const std::string& reason, bool drives_off, bool at_once);
  void leave_for(const KrcBreach& breach);
  void trip();
  void restart_when_due();
  void send_measurement();
  void set_state(FriState state, const std::string& reason);
  void broke(KrcRule rule, const std::string& reason);
  [[nodiscard]] bool injected(KrcRule rule) const;
  [[nodiscard]] const KrcFault* active(KrcFault::Kind kind) const;
  [[nodiscard]] bool powered() const { return power_ && !active(KrcFault::Kind::DrivesOff); }
  void event(const std::string& text) const;

  KrcConfig config_;
  const hal::ArmDynamics& dynamics_;
  KrcPlant& plant_;
  hal::DatagramLink& link_;
  OnEvent on_event_;
  std::unique_ptr<KrlScript> script_;
  KrcMotion motion_;
  KrcQuality quality_;
  KrcBadWire in_, out_;
  KrcReport report_;

  // time
  hal::Timestamp began_{0}, next_cycle_{0}, wire_now_{0};
  double t_s_ = 0.0, next_poll_s_ = 0.0;
  hal::Duration cycle_{0};
  bool plant_moved_ = true;

  // the session
  FriState state_ = FriState::Off;
  bool power_ = false, tripped_ = false, braking_ = false, off_after_braking_ = false, unplugged_ = false;
  bool halted_ = false;   ///< The KRL program, until a person starts it anew.
  bool idle_ = false;     ///< Brakes closed because nothing moved.
  double moved_s_ = 0.0;  ///< When something did.
  std::optional<double> brakes_open_at_s_;
  std::optional<double> start_until_s_, restart_at_s_;
  double safety_limits_ = 1.0;
  int good_cycles_ = 0;
  FriQuality quality_now_ = FriQuality::Unacceptable, quality_published_ = FriQuality::Unacceptable;
  double quality_published_s_ = -1.0;
  KrlChannels from_pc_, to_pc_;

  // the wire
  std::uint16_t send_ = 0, reflected_ = 0;
  bool awaiting_ = false, answered_ = false, client_there_ = false, ever_answered_ = false;
  hal::Timestamp sent_at_{0};
  hal::Duration latency_{0};
  std::optional<hal::Endpoint> client_;
  std::optional<std::uint16_t> last_send_;
  std::optional<KrcCommand> last_command_;
  bool fresh_ = false;
  double heard_s_ = 0.0;
  std::vector<bool> fault_began_, fault_ended_;
  std::optional<KrcMeasurement> frozen_;
};

}  // namespace colift::sim_hal
