#pragma once

#include <cstdint>

namespace colift::hal {

/// The hand-shake with config/krl/colift.src, whose rules are in docs/krl-hand-shakes.md. C indices into
/// KrlChannels.
namespace colift_krl {

inline constexpr std::int32_t kVersion = 10001;
inline constexpr std::int32_t kMostNumber = 30000;  ///< Of requests and of the heartbeat; then 1 again.
inline constexpr double kBeat_s = 0.05;             ///< Of the heartbeat.

enum To : std::size_t { kToVersion = 0, kToRequest = 1, kToStrategy = 2, kToNumber = 3, kToBeat = 4 };
enum From : std::size_t {
  kFromVersion = 0,
  kFromState = 1,
  kFromStrategy = 2,
  kFromNumber = 3,
  kFromBeat = 4,
  kFromResult = 5
};
enum Request : std::int32_t { kNone = 0, kStart = 1, kStop = 2, kClose = 3 };
enum ScriptState : std::int32_t {
  kBegins = 0,
  kWaits = 1,
  kStarts = 2,
  kCommands = 3,
  kStops = 4,
  kCloses = 5
};
enum Outcome : std::int32_t {
  kAtWork = 0,
  kDone = 1,
  kNoQuality = 2,
  kNoStrategy = 3,
  kNotStarted = 4,
  kLeft = 5,
  kWrongVersion = 6,
  kNoRequest = 7,
  kPcSilent = 8,
  kOvertaken = 9
};

}  // namespace colift_krl
}  // namespace colift::hal
