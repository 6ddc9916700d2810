#include "tools/telemetry/replay/replay.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "control/task/run_job.hpp"
#include "tools/telemetry/channels/built_in_texts.hpp"
#include "tools/telemetry/record/run_telemetry.hpp"
#include "tools/telemetry/replay/playback.hpp"
#include "tools/telemetry/replay/replay_robot.hpp"

namespace colift::telemetry {
namespace {

constexpr Topic kCompared[] = {Topic::Change, Topic::Decision, Topic::Plan, Topic::Status};
constexpr std::size_t kMostDifferences = 100;

using Said = std::map<Topic, std::vector<std::string>>;

/// Keeps what is to be compared.
class Listener final : public TelemetrySink {
 public:
  explicit Listener(const Tape& tape) : tape_(tape) {}
  void publish(const Publication& p) override {
    // what the task says once nobody answers any more is not the recording's doing
    if (tape_.ended()) return;
    if (std::find(std::begin(kCompared), std::end(kCompared), p.topic) != std::end(kCompared))
      said[p.topic].push_back(p.encode());
  }
  Said said;

 private:
  const Tape& tape_;
};

/// What a replay does not say, or only of itself.
const std::set<Topic> kOfThen = {Topic::Devices, Topic::Timing, Topic::Stages, Topic::Truth};

/// Passes on what the recording does not hold itself.
class Beside final : public TelemetrySink {
 public:
  Beside(const McapReader& file, TelemetrySink& to) : to_(to) {
    for (const Topic topic : kOfThen)
      if (file.info().channel(channel_of(topic).topic)) held_.insert(topic);
  }
  void publish(const Publication& p) override {
    if (held_.count(p.topic) == 0) to_.publish(p);
  }

 private:
  TelemetrySink& to_;
  std::set<Topic> held_;
};

/// Goes to the first cycle. Errors: BadInput.
hal::Result<> begin(Tape& tape, const std::string& name) {
  if (!tape.advance())
    return hal::failure(hal::ErrorCode::BadInput, name, "holds no inputs of a task: nothing can be replayed");
  if (tape.now().cycle != 0)
    return hal::failure(
        hal::ErrorCode::BadInput, name,
        fmt::format("begins in the middle of a run, at cycle {} of the task; a replay needs its start",
                    tape.now().cycle));
  return {};
}

Said recorded_words(const McapReader& file) {
  Said said;
  std::set<std::string> topics;
  std::map<std::uint16_t, Topic> by_id;
  for (const Topic topic : kCompared) {
    topics.insert(channel_of(topic).topic);
    if (const Channel* channel = file.info().channel(channel_of(topic).topic)) by_id[channel->id] = topic;
  }
  auto cursor = file.messages(topics);
  while (const auto message = cursor.next()) {
    const auto topic = by_id.find(message->channel_id);
    if (topic != by_id.end()) said[topic->second].emplace_back(message->data);
  }
  return said;
}

void compare(const Said& recorded, const Said& replayed, bool cut, ReplayReport& report) {
  static const std::vector<std::string> kNone;
  for (const Topic topic : kCompared) {
    const auto a_at = recorded.find(topic), b_at = replayed.find(topic);
    const auto& a = a_at == recorded.end() ? kNone : a_at->second;
    const auto& b = b_at == replayed.end() ? kNone : b_at->second;
    // of a recording that was cut the last cycle's words may be missing on either side
    const std::size_t count = cut ? std::min(a.size(), b.size()) : std::max(a.size(), b.size());
    for (std::size_t i = 0; i < count; ++i) {
      const std::string& then = i < a.size() ? a[i] : std::string();
      const std::string& now = i < b.size() ? b[i] : std::string();
      if (then == now) continue;
      ++report.differing;
      if (report.differences.size() < kMostDifferences) report.differences.push_back({topic, i, then, now});
    }
    report.compared[topic] = count;
  }
}

}  // namespace

hal::Result<> can_replay(const McapReader& file, const std::string& name) {
  Tape tape(file);
  return begin(tape, name);
}

hal::Result<ReplayReport> replay(const McapReader& file, const std::string& name, const RunDescription& run,
                                 const ReplaySetting& setting) {
  Tape tape(file);
  if (auto begun = begin(tape, name); !begun) return tl::unexpected(begun.error());

  hal::Robot robot = replayed_robot(tape, run.X_WC_more.size());
  const hal::SteadyClock wall;
  Listener listener(tape);
  std::vector<TelemetrySink*> sinks = {&listener};
  std::vector<std::unique_ptr<Beside>> watchers;
  for (TelemetrySink* watcher : setting.watchers) {
    watchers.push_back(std::make_unique<Beside>(file, *watcher));
    sinks.push_back(watchers.back().get());
  }
  Playback of_then(file, setting.watchers.empty() ? std::set<Topic>() : kOfThen, setting.watchers);
  RunTelemetry telemetry({setting.model.get(), run.X_WC, run.X_WC_more, run.drive, false, &setting.hand,
                          run.robot_urdf.empty() ? built_in_robot_urdf() : run.robot_urdf},
                         sinks, wall);
  if (!setting.watchers.empty()) telemetry.tap(robot);

  control::JobHooks mine;
  mine.interrupted = [&] {
    return tape.ended() || tape.now().interrupted || (setting.interrupted && setting.interrupted());
  };
  mine.lower_confirmed = [&] { return tape.now().lower_confirmed; };
  mine.continue_confirmed = [&] { return tape.now().continue_confirmed; };
  control::JobHooks hooks = telemetry.hooks(mine);
  const auto listen = hooks.cycle;
  hooks.cycle = [&](const control::ArmView& view) {
    const auto& clock = tape.now().clock_ns;
    const hal::Timestamp at(clock.empty() ? 0 : clock.back());
    listen(view);
    if (!setting.watchers.empty()) of_then.play(at);
    if (setting.pace && !clock.empty()) setting.pace(at);
    (void)tape.advance();
  };
  control::JobOptions options;
  options.method = run.method;
  options.seed = run.seed;
  options.dry_run = run.dry_run;
  if (run.drive == control::Drive::Thread)
    options.recorded_views = [&](control::ArmView& view) {
      if (tape.now().view) view = *tape.now().view;
      view.link_lost = view.link_lost || tape.ended();
    };
  const control::RigView rig{*setting.model, setting.hand, setting.hand_tables, run.X_WC, run.X_WC_more};
  auto record = control::run_job(robot, rig, setting.config, options, hooks, wall);
  if (!record) return tl::unexpected(record.error());

  ReplayReport report;
  const bool cut = !file.info().complete || file.metadata(kSnapshot);
  compare(recorded_words(file), listener.said, cut, report);
  report.cycles = tape.cycles();
  report.notes = tape.notes();
  if (cut) report.notes.push_back("the recording is incomplete: it was replayed up to its end");
  report.record = std::move(*record);
  return report;
}

void play_recording(const McapReader& file, const ReplaySetting& setting) {
  std::set<Topic> all;
  for (const ChannelInfo& channel : channels()) all.insert(channel.id);
  Playback playback(file, all, setting.watchers);
  while (const auto at = playback.next_at()) {
    if (setting.interrupted && setting.interrupted()) return;
    if (setting.pace) setting.pace(*at);
    playback.play(*at);
  }
}

}  // namespace colift::telemetry
