#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim_hal/emulator/krc/krc_rules.hpp"

namespace colift::sim_hal {

/// What the controller saw of its client. Times are the controller's, from its start (s).
struct KrcReport {
  struct ModeChange {
    double t = 0.0;
    FriState from = FriState::Off, to = FriState::Off;
    std::string reason;
  };
  struct BrokenRule {
    double t = 0.0;
    KrcRule rule = KrcRule::BadDatagram;
    std::string reason;
  };
  struct Injected {
    double t = 0.0;
    std::string what;
  };

  std::uint64_t sent = 0, answered = 0, missed = 0;  ///< Measurements; the last one may be neither.
  std::uint64_t received = 0;                        ///< Datagrams of any kind.
  std::uint64_t late = 0, duplicate = 0, reordered = 0;
  std::map<std::string, std::uint64_t> rejected;  ///< By reason.
  int most_missed_in_a_row = 0;                   ///< Since the first answer.
  std::uint64_t missed_in_command = 0;            ///< Of `missed`, while the client commanded.
  std::array<std::uint64_t, 4> quality_cycles{};  ///< Cycles at each quality.
  FriQuality quality = FriQuality::Unacceptable;
  FriState state = FriState::Off;
  double answer_rate = 0.0, latency_s = 0.0, jitter_s = 0.0;
  std::uint64_t command_cycles = 0;  ///< In command mode.
  double duration_s = 0.0;
  std::vector<ModeChange> mode_changes;
  std::vector<BrokenRule> broken_rules;   ///< By the client; what an injected fault broke is in mode_changes.
  std::uint64_t broken_rules_in_all = 0;  ///< The list ends at 1000.
  std::vector<Injected> injected;
  std::optional<std::string> closed;  ///< Why the program came to its end; unset: it did not.
};

[[nodiscard]] std::string_view name(FriState state);
[[nodiscard]] std::string_view name(FriQuality quality);

}  // namespace colift::sim_hal
