#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/types/geometry.hpp"
#include "hal/types/result.hpp"
#include "tools/telemetry/mcap/mcap_reader.hpp"

namespace colift::tools {

/// What is measured all the time: a column of `/load` or of `/task/status`.
enum class Quantity { Load, Share, Height, Tilt, Slip, Distance, SpeedScale };
struct QuantityStyle {
  Quantity quantity;
  const char* name;   ///< In documents: "load".
  const char* title;  ///< With its unit, for people: "Load (N)".
  const char* unit;   ///< "N"; empty for a ratio.
};
/// In the order of the enumeration.
inline constexpr std::array<QuantityStyle, 7> kQuantities{{
    {Quantity::Load, "load", "Load (N)", "N"},
    {Quantity::Share, "share", "Share of the robot", ""},
    {Quantity::Height, "height", "Height of the palm over the grasp (m)", "m"},
    {Quantity::Tilt, "tilt", "Tilt (deg)", "deg"},
    {Quantity::Slip, "slip", "Slip in the hand (m)", "m"},
    {Quantity::Distance, "distance", "Distance to the nearest person (m)", "m"},
    {Quantity::SpeedScale, "speed_scale", "Speed scale", ""},
}};

[[nodiscard]] constexpr const QuantityStyle& style_of(Quantity quantity) {
  return kQuantities[static_cast<std::size_t>(quantity)];
}

/// One quantity over time; of times at which it was not known there is no entry.
struct RecordedCurve {
  std::vector<double> t_s, value;  ///< Of the same length, t rising.
};

struct RecordedState {
  std::string state, reason;
  double from_s = 0.0, to_s = 0.0;
};

struct RecordedCandidate {
  int id = 0;
  std::string kind, verdict, reason;
  std::optional<hal::Vec3> position_W;
  std::optional<double> share, cost;
};

/// The last decision of a run.
struct RecordedDecision {
  std::optional<int> chosen;  ///< Id of a candidate.
  std::optional<double> share, cost;
  std::optional<hal::Vec3> partner_W;
  std::string reason;
  std::vector<RecordedCandidate> candidates;

  [[nodiscard]] const RecordedCandidate* candidate(int id) const;
};

/// A run as its recording has it. Times are seconds of the robot's clock. Everything is optional that a
/// recording of the last seconds, or one that was cut, does not hold.
struct RecordedRun {
  std::filesystem::path file;
  std::string version, command, started, method, seed;
  std::string outcome, reason;                ///< Empty: the recording ends before the run.
  std::map<std::string, std::string> config;  ///< "task.lift_height_m" to its value as written;
                                              ///< "scenario." and "robot." before those of their files.
  std::vector<RecordedState> states;
  std::optional<RecordedDecision> decision;
  std::map<Quantity, RecordedCurve> curves;
  double end_s = 0.0;
  std::vector<std::string> damage;  ///< Of the file.

  /// When it entered a state for the first time.
  [[nodiscard]] std::optional<double> entered_s(std::string_view state) const;
};

/// Errors: BadInput (no recording, or neither changes of state nor a load in it).
[[nodiscard]] hal::Result<RecordedRun> read_recorded_run(const std::filesystem::path& file);
/// The same of an open one.
[[nodiscard]] hal::Result<RecordedRun> recorded_run_of(const telemetry::McapReader& reader,
                                                       const std::filesystem::path& file);

}  // namespace colift::tools
