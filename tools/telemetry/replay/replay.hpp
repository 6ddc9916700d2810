#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "control/config/config.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "hal/types/result.hpp"
#include "planner/hand/hand_model.hpp"
#include "tools/telemetry/channels/channels.hpp"
#include "tools/telemetry/mcap/mcap_reader.hpp"
#include "tools/telemetry/record/run_documents.hpp"

namespace colift::telemetry {

/// One message of a recording that came out differently.
struct ReplayDifference {
  Topic topic = Topic::Status;
  std::size_t index = 0;           ///< Which message of that topic, from 0.
  std::string recorded, replayed;  ///< As JSON; empty: there was none.
};

struct ReplayReport {
  std::map<Topic, std::size_t> compared;      ///< Messages that were held against each other.
  std::vector<ReplayDifference> differences;  ///< At most a hundred, earliest first within a topic.
  std::size_t differing = 0;                  ///< All of them.
  std::uint64_t cycles = 0;                   ///< Of the task, that were replayed.
  std::vector<std::string> notes;             ///< What kept the replay from being complete.
  control::RunRecord record;                  ///< Of the replayed run.

  [[nodiscard]] bool same() const { return differing == 0; }
};

/// What a replay runs with: the recording's own, or changed on purpose.
struct ReplaySetting {
  control::Config config;
  planner::HandModel hand;
  std::shared_ptr<const planner::HandCollision> hand_tables;
  std::shared_ptr<const hal::RobotModel> model;
  std::vector<TelemetrySink*> watchers;  ///< Live view.
  std::function<bool()> interrupted;     ///< A person wants it to end; may be empty.
  /// Called in each cycle with the recorded time: whoever watches may want it slower. May be empty.
  std::function<void(hal::Timestamp)> pace;
};

/// Whether the recording holds the start of a run. Errors: BadInput (it begins in the middle, as the flight
/// recorder's do, or holds no inputs at all): it can be watched, but nothing can be decided once more.
[[nodiscard]] hal::Result<> can_replay(const McapReader& file, const std::string& name);

/// Runs the same task on what was recorded: every frame, every state, every time that was read, each in its
/// cycle, and holds what it says (status, changes of state, decisions with all verdicts, plans) against what
/// was said then, byte by byte. With another configuration the arm still does what it did then: the first
/// difference is what would have changed; what follows it says less and less. Watchers get what the replay
/// says, and beside it what only the recording knows: the devices' health, the arm's cycle, computing times
/// and the simulation's truth of then.
/// Errors: BadInput (the recording does not hold the start of a run), and the task's.
[[nodiscard]] hal::Result<ReplayReport> replay(const McapReader& file, const std::string& name,
                                               const RunDescription& run, const ReplaySetting& setting);

/// Hands watchers what a recording holds, as it is: for one that cannot be replayed. Of the setting only
/// watchers, interrupted and pace are used.
void play_recording(const McapReader& file, const ReplaySetting& setting);

}  // namespace colift::telemetry
