#pragma once

#include <array>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "sim_hal/emulator/memory_can_bus.hpp"

namespace colift {

/// One motor controller, as little of it as the driver's stories need, written from the published protocol
/// and not from the driver's codec.
struct FakePuck {
  int id = 11;
  int stat = 2;
  bool has_joint = true;
  std::array<std::int32_t, 128> property{};
  double position = 0.0;                                        ///< Counts.
  double blocked_at = std::numeric_limits<double>::infinity();  ///< Counts at which it meets something.
  bool feels = true;                                            ///< Strain and pads tell of what it meets.
  bool stuck = false;                                           ///< The motor does not turn.
  bool never_ends = false;                                      ///< Ignores TSTOP.
  double zero_shift = 0.0;                                      ///< Added to what it tells.
  double clutch_ahead = 0.0;                                    ///< Motor counts without the inner link.
  double load_nm = 0.0, load_share = 1.0;
  bool silent = false;
  std::optional<hal::Timestamp> powered_at;  ///< UPSECS counts from here; unset: its clock stands at 0.
  hal::Timestamp quiet_until{0}, boots_until{0};
  bool finding_stop = false;
  double still_ms = 0.0;
  std::vector<int> modes;  ///< Every mode that was set.

  void reset();
  void step(double dt_ms);
  [[nodiscard]] int mode() const { return property[8]; }
};

/// The four of them on a bus in memory, with time that moves only here.
class FakeHand {
 public:
  explicit FakeHand(hal::ManualClock& clock);

  hal::ManualClock& clock;
  sim_hal::MemoryCan bus;
  std::array<FakePuck, 4> pucks;
  std::unique_ptr<sim_hal::MemoryCan::Node> host;
  hal::Duration latency = std::chrono::microseconds(150);
  std::vector<hal::CanFrame> from_host;  ///< All that the host said.
  std::vector<hal::Timestamp> said_at;

  /// Lets time pass for the pucks, `each_ms` after each millisecond.
  void pass(hal::Duration by, const std::function<void()>& each_ms = {});
  /// How often the host set `property` of puck 0 to 3 since `from`, an index into from_host.
  [[nodiscard]] int sets(std::size_t puck, int property, std::size_t from = 0) const;

 private:
  bool run_until(hal::Timestamp until);
  void listen();
  void hear(FakePuck& puck, const hal::CanFrame& frame);
  void answer(const FakePuck& puck, int property);
  void answer_tactile(const FakePuck& puck);

  std::unique_ptr<sim_hal::MemoryCan::Node> node_;
};

}  // namespace colift
