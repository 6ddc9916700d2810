#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "hal/drivers/kuka_fri/fri_arm.hpp"
#include "hal/drivers/kuka_fri/wire/fri_codec.hpp"
#include "sim_hal/emulator/memory_link.hpp"

namespace colift::test {

using hal::Endpoint;
using hal::FriCommand;
using hal::FriMeasurement;

/// A small controller for the driver's tests, in lock step with a clock that it moves itself. It follows what
/// it is sent, keeps a list of it, and judges what a real one would judge. Tests turn its knobs directly.
class FakeKrc {
 public:
  explicit FakeKrc(double period_s = 0.002);

  hal::ManualClock clock;
  sim_hal::MemoryWire wire{clock};
  Endpoint own{0x7F000001, 49152}, pc{0x7F000001, 49938};

  /// The link for the driver: while it waits, the controller runs.
  [[nodiscard]] std::unique_ptr<hal::DatagramLink> link();
  [[nodiscard]] std::unique_ptr<hal::FriArm> arm(const hal::FriConfig& config = quick());
  /// Script none, so that tests start and stop at will; short deadlines.
  [[nodiscard]] static hal::FriConfig quick();

  // knobs
  FriMeasurement m;  ///< Sent next; joint fields are filled from below.
  std::array<float, 7> krl_rad{0.1f, 0.5f, -0.3f, -1.2f, 0.4f, 0.8f, -0.6f};
  std::array<float, 7> offset_rad{};  ///< What FRI added.
  std::array<float, 7> sag_rad{};     ///< Measured minus commanded.
  bool silent = false;                ///< Sends nothing, time goes on; its counter too.
  bool deaf = false;                  ///< Hears nothing.
  bool extrapolates = true;           ///< Up to three missing answers, in command mode.
  bool start_when_good = true;        ///< Goes to command mode once `good` answers came.
  bool frozen = false;                ///< Measured joints keep their bits.
  bool script_colift = false;         ///< Plays config/krl/colift.src in a few lines.
  /// Called before each datagram; false: it is lost.
  std::function<bool(FriMeasurement&)> tamper;
  /// Called after it was sent.
  std::function<void(const std::vector<std::byte>&)> after;

  void command_mode();
  void monitor_mode();
  /// As if it was switched off and on.
  void reboot();
  /// Its counter of datagrams jumps back, nothing else changes.
  void count_back(int by);

  // what happened
  std::vector<FriCommand> heard;  ///< All answers, in order.
  std::vector<FriMeasurement> told;
  int not_mirrored = 0;  ///< Answers outside of command mode that are not the commanded position, bit by bit.
  int torque_outside = 0;                             ///< Torque or wrench outside of command mode.
  int twice = 0;                                      ///< Datagrams that were answered twice.
  int flags_changed = 0;                              ///< In command mode.
  int good = 0;                                       ///< Good answers in a row.
  double worst_step_rad = 0.0, worst_dv_rad_s = 0.0;  ///< Between set points that were followed, per cycle.

  [[nodiscard]] std::array<float, 7> followed() const;
  bool run(hal::Timestamp until);

 private:
  void hear();
  void play_script();
  void send();

  std::unique_ptr<hal::DatagramLink> end_;
  hal::Timestamp next_at_{0};
  double period_s_;
  std::uint16_t send_ = 0, reflect_ = 0;
  int missing_ = 0;
  std::array<double, 7> speed_{};
  std::optional<std::uint32_t> flags_;
  std::optional<std::uint16_t> answered_;
  double script_wait_s_ = 0.0;
};

}  // namespace colift::test
