#include "tools/telemetry/record/run_telemetry.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "hal/types/units.hpp"
#include "tools/telemetry/channels/image_message.hpp"
#include "tools/telemetry/channels/json_parts.hpp"
#include "tools/telemetry/channels/messages.hpp"
#include "tools/telemetry/channels/recorded_frame.hpp"
#include "tools/telemetry/channels/string_message.hpp"
#include "tools/telemetry/record/taps.hpp"

namespace colift::telemetry {
namespace {

using namespace std::chrono_literals;
using control::Task;

constexpr hal::Duration kJointsEvery = 20ms, kTransformsEvery = 100ms, kTimingEvery = 100ms;
constexpr hal::Duration kTactileEvery = 50ms, kDevicesEvery = 500ms, kPreviewEvery = 500ms,
                        kCloudEvery = 1000ms;

/// What is due every so often on the robot's clock.
class Every {
 public:
  explicit Every(hal::Duration period) : period_(period) {}
  bool due(hal::Timestamp now) {
    if (last_ && now - *last_ < period_ && now >= *last_) return false;
    last_ = now;
    return true;
  }

 private:
  hal::Duration period_;
  std::optional<hal::Timestamp> last_;
};

}  // namespace

struct RunTelemetry::Impl {
  Setting setting;
  std::vector<TelemetrySink*> sinks;
  const hal::Clock& wall;
  const std::shared_ptr<TapBook> owned_book = std::make_shared<TapBook>();
  TapBook& book = *owned_book;  ///< Outlived by the taps.
  hal::Robot* robot = nullptr;
  std::function<void(const std::string&)> fault_listener;

  hal::Timestamp now{0};
  Every joints{kJointsEvery}, transforms{kTransformsEvery}, timing{kTimingEvery}, tactile{kTactileEvery},
      devices{kDevicesEvery}, preview{kPreviewEvery}, cloud{kCloudEvery};
  control::ArmView view;
  hal::HandState hand;
  // the arm's cycle since its last message
  CycleSummary cycles;
  double answer_sum_us = 0.0;
  std::uint64_t answers = 0, lost_before = 0;
  std::optional<hal::Timestamp> last_measured;
  // what was told already
  std::size_t states_told = 0, faults_told = 0, intents_told = 0;
  int map_told = 0;  // its version
  bool bodies_told = false;
  bool robot_told = false;
  bool look_told = false, plan_told = false;
  std::optional<Task> state;
  SceneView scene;
  std::optional<hal::Vec3> cog;
  std::optional<double> share_predicted;
  /// Of the camera, once the job has found it. What is recorded for a replay stays as the device gave it.
  std::optional<perception::CameraCorrection> correction;

  Impl(const Setting& s, std::vector<TelemetrySink*> to, const hal::Clock& w)
      : setting(s), sinks(std::move(to)), wall(w) {}

  void publish(Topic topic, hal::Timestamp at, std::function<std::string()> encode,
               std::size_t bytes = 1024) {
    const Publication p{topic, at, std::move(encode), bytes};
    for (TelemetrySink* sink : sinks) sink->publish(p);
  }

  void log(hal::Timestamp at, Level level, const std::string& name, const std::string& text) {
    publish(Topic::Log, at, [=] { return log_message(at, level, name, text); });
  }

  /// The robot's time as the job read it last: asking the clock once more would be one question too many in a
  /// replay.
  [[nodiscard]] hal::Timestamp time() const {
    return book.now.clock_ns.empty() ? now : hal::Timestamp(book.now.clock_ns.back());
  }

  /// Once, before anything else: who comes later gets it from the sinks, which keep it.
  void tell_robot(hal::Timestamp at) {
    if (std::exchange(robot_told, true) || setting.robot_urdf.empty()) return;
    publish(
        Topic::Description, at, [urdf = setting.robot_urdf] { return string_message(urdf); },
        setting.robot_urdf.size());
  }

  void on_tracked(const control::TrackedPoses& tracked) {
    publish(Topic::Tracked, time(), [tracked] { return tracked_message(tracked); });
  }

  void on_frame(std::uint64_t number, const hal::DepthFrame& frame) {
    const hal::Timestamp at = time();
    tell_robot(at);
    const auto kept = std::make_shared<const NumberedFrame>(NumberedFrame{number, frame});
    const std::size_t bytes = frame.depth_m.size() * sizeof(float) + frame.rgb.size();
    // what describes the frame comes before its images (FrameJoiner)
    publish(Topic::Frame, at, [kept] { return frame_message(kept->number, kept->frame); });
    if (!frame.rgb.empty())
      publish(
          Topic::Colour, at, [kept] { return colour_image(kept->frame); }, frame.rgb.size());
    publish(
        Topic::Depth, at, [kept] { return depth_image(kept->frame); }, bytes);
    if (preview.due(at)) {
      hal::CameraIntrinsics camera = frame.intrinsics;
      if (correction) camera.fx *= correction->focal_scale, camera.fy *= correction->focal_scale;
      publish(Topic::Calibration, at, [at, camera] { return calibration_message(at, camera); });
      publish(
          Topic::Preview, at, [kept] { return preview_message(kept->frame); }, bytes / 4);
    }
    if (cloud.due(at))
      publish(
          Topic::Cloud, at,
          [kept, by = correction] {
            if (!by) return cloud_message(kept->frame);
            hal::DepthFrame corrected = kept->frame;
            by->correct(corrected);
            return cloud_message(corrected);
          },
          bytes / 4);
  }

  /// Of a camera beside the first: kept for replay and for viewers.
  void on_other_frame(std::size_t camera, std::uint64_t number, const hal::DepthFrame& frame) {
    const hal::Timestamp at = time();
    const auto kept = std::make_shared<const NumberedFrame>(NumberedFrame{number, frame});
    publish(Topic::MoreFrame, at, [kept] { return frame_message(kept->number, kept->frame); });
    publish(
        Topic::MoreDepth, at, [kept, camera] { return depth_image(kept->frame, hal::camera_name(camera)); },
        frame.depth_m.size() * sizeof(float));
  }

  /// Where the camera is, as far as the job knows.
  [[nodiscard]] hal::Pose camera_pose() const {
    return correction ? setting.X_WC * correction->X_KC : setting.X_WC;
  }

  void take_arm_samples() {
    while (const auto sample = book.arm.pop()) {
      if (sample->missed) {
        ++cycles.missed;
        continue;
      }
      ++cycles.cycles;
      const double answer_us = 1e6 * hal::seconds(sample->answer);
      answer_sum_us += answer_us;
      ++answers;
      cycles.answer_us_max = std::max(cycles.answer_us_max.value_or(0.0), answer_us);
      if (last_measured) {
        const double period_ms = 1e3 * hal::seconds(sample->measured_at - *last_measured);
        cycles.period_ms_max = std::max(cycles.period_ms_max.value_or(0.0), period_ms);
      }
      last_measured = sample->measured_at;
    }
  }

  void on_cycle(const control::ArmView& arm_view) {
    view = arm_view;
    now = time();
    tell_robot(now);
    for (const auto& read : book.now.hand)
      if (read) hand = *read;
    if (!book.in_step) book.now.view = view;
    const std::uint64_t next = book.now.cycle + 1;
    auto inputs = std::make_shared<const CycleInputs>(std::exchange(book.now, {}));
    book.now.cycle = next;
    publish(
        Topic::Inputs, now, [inputs] { return inputs_message(*inputs); }, 2048);

    take_arm_samples();
    const hal::Timestamp at = now;
    const hal::RobotModel* model = setting.model;
    if (joints.due(now))
      publish(Topic::Joints, at,
              [at, model, arm = view.state, h = hand] { return joints_message(at, *model, arm, h); });
    if (transforms.due(now))
      publish(Topic::Transforms, at,
              [at, model, q = view.state.q_rad, h = hal::posture_of(hand), X = camera_pose(),
               more = setting.X_WC_more] { return transforms_message(at, *model, q, h, X, more); });
    const bool has_cells = std::any_of(hand.tactile.begin(), hand.tactile.end(),
                                       [](const auto& a) { return a.measured_at != hal::Timestamp{0}; });
    if (has_cells && tactile.due(now)) publish(Topic::Tactile, at, [h = hand] { return tactile_message(h); });
    if (timing.due(now)) {
      if (answers > 0) cycles.answer_us_mean = answer_sum_us / static_cast<double>(answers);
      cycles.lost_samples = book.arm.refused() - lost_before;
      lost_before = book.arm.refused();
      publish(Topic::Timing, at, [c = std::exchange(cycles, {})] { return timing_message(c); });
      answer_sum_us = 0.0;
      answers = 0;
    }
    if (robot && setting.asks_devices && devices.due(now)) {
      book.listens = false;
      std::vector<NamedHealth> all = {{"arm", robot->arm->health()},
                                      {"hand", robot->hand->health()},
                                      {"camera", robot->camera->health()}};
      for (std::size_t n = 0; n < robot->more_cameras.size(); ++n)
        all.push_back({hal::camera_name(n + 1), robot->more_cameras[n]->health()});
      book.listens = true;
      publish(Topic::Devices, at, [all = std::move(all)] { return devices_message(all); });
    }
  }

  void tell_look(hal::Timestamp at, const control::SceneAnalysis& analysis) {
    look_told = true;
    scene = scene_view(analysis);
    if (analysis.scene.target) cog = analysis.scene.target->cog;
    publish_scene(at);
    log(at, Level::Info, "look", analysis.reason);
  }

  /// The job changes its collision world seldom; here it is only copied, encoded where somebody wants it.
  void tell_map(hal::Timestamp at, const perception::WorldMap& map, const perception::Ground& ground) {
    const auto kept = std::make_shared<const MapView>(map_view(map, ground.plane));
    publish(
        Topic::Map, at, [at, kept] { return map_message(at, *kept); }, kept->cells.size());
    if (kept->cropped > 0)
      log(at, Level::Info, "map",
          fmt::format("{} measured cells lie far from the robot and are not shown on /map", kept->cropped));
  }

  void publish_scene(hal::Timestamp at) {
    publish(
        Topic::Scene, at, [at, s = scene] { return scene_message(at, s); }, 65536);
  }

  void tell_decision(hal::Timestamp at, const control::JobStatus& s) {
    const control::RunRecord& record = *s.record;
    if (!record.decision) return;
    const control::Outcome& outcome = *record.decision;
    const double t_s = hal::seconds(s.now);
    publish(
        Topic::Decision, at, [d = DecisionView{t_s, outcome, cog}] { return decision_message(d); }, 65536);
    scene.candidates = outcome.candidates;
    scene.partner = outcome.partner;
    scene.optimum = outcome.decision.optimum;
    scene.path_W.clear();
    scene.gripper.reset();
    share_predicted.reset();
    if (outcome.decision.chosen) {
      share_predicted = outcome.decision.share;
      if (setting.hand)
        scene.gripper = gripper_view(
            *setting.model, planner::hand_pose(outcome.candidates[*outcome.decision.chosen], *setting.hand));
    }
    // a dry run ends with its first plan; an older one is no plan any more
    if (record.plan && (s.state == Task::Approach || !plan_told)) {
      plan_told = true;
      const PlanView plan = plan_view(t_s, *record.plan, *setting.model);
      scene.path_W = plan.palm_W;
      publish(
          Topic::Plan, at, [plan] { return plan_message(plan); }, 8192);
    }
    publish_scene(at);
    publish(Topic::Stages, at,
            [analysis = record.analysis ? record.analysis->ms : control::StageTimes{},
             ms = outcome.decision_ms, t = record.timing] { return stages_message(analysis, ms, t); });
  }

  void on_status(const control::JobStatus& s) {
    // the hook may come before the first cycle's end
    const hal::Timestamp at = time();
    tell_robot(at);
    const control::RunRecord& record = *s.record;
    if (!correction && record.camera_correction && record.camera_correction->applied())
      correction = record.camera_correction;
    if (record.analysis && (!look_told || (s.map && s.map_version != map_told)))
      tell_look(at, *record.analysis);
    if (s.map && s.map_version != map_told && record.analysis->scene.ground) {
      map_told = s.map_version;
      tell_map(at, *s.map, *record.analysis->scene.ground);
    }
    const bool changed = states_told != record.states.size();
    for (; states_told < record.states.size(); ++states_told) {
      const control::StateChange change = record.states[states_told];
      publish(Topic::Change, at, [change] { return change_message(change); });
      log(at, Level::Info, "task", fmt::format("{}: {}", control::word(change.state), change.reason));
      if (change.state == Task::Stopped || change.state == Task::Aborted) fault(change.reason);
    }
    if (changed && (state == Task::Decide || state == Task::Plan)) tell_decision(at, s);
    state = s.state;
    for (; faults_told < record.faults.size(); ++faults_told) {
      const control::DeviceNote note = record.faults[faults_told];
      log(at, Level::Warning, note.device, note.what);
      fault(note.device + ": " + note.what);
    }
    for (; intents_told < record.intents.size(); ++intents_told) {
      const control::Intent intent = record.intents[intents_told];
      publish(Topic::Intent, at, [intent] { return intent_message(intent); });
      log(at, Level::Info, "intent",
          intent.motion ? fmt::format("in {:.1f} s: {}", intent.in_s, intent.says) : intent.says);
    }
    tell_bodies(at, s.separation);
    control::JobStatus kept = s;
    kept.record = nullptr;
    kept.map = nullptr;
    publish(Topic::Status, at, [kept] { return status_message(kept); });
    LoadNow load{
        view.wrench_W, view.load_n, s.share_robot, share_predicted, s.height_m, s.tilt_rad, s.slip_m, {}, {}};
    if (s.height_m) load.role = view.role;
    if (s.height_m && std::isfinite(view.energy_j)) load.energy_j = view.energy_j;
    publish(Topic::Load, at, [load] { return load_message(load); });
  }

  /// Once more when nobody is there any longer.
  void tell_bodies(hal::Timestamp at, const control::SeparationStatus& separation) {
    if (separation.bodies.empty() && !bodies_told) return;
    bodies_told = !separation.bodies.empty();
    publish(Topic::Bodies, at, [at, separation] { return bodies_message(at, separation); });
  }

  void fault(const std::string& why) const {
    if (fault_listener) fault_listener(why);
  }
};

RunTelemetry::RunTelemetry(const Setting& setting, std::vector<TelemetrySink*> sinks, const hal::Clock& wall)
    : impl_(std::make_unique<Impl>(setting, std::move(sinks), wall)) {
  impl_->book.in_step = setting.drive == control::Drive::InStep;
  impl_->book.on_frame = [i = impl_.get()](std::size_t camera, std::uint64_t number,
                                           const hal::DepthFrame& frame) {
    if (camera == 0)
      i->on_frame(number, frame);
    else
      i->on_other_frame(camera, number, frame);
  };
}
RunTelemetry::~RunTelemetry() {
  impl_->book.on_frame = nullptr;
  impl_->book.listens = false;
}

void RunTelemetry::tap(hal::Robot& robot) {
  Impl& i = *impl_;
  i.robot = &robot;
  robot.arm = tap_arm(std::move(robot.arm), i.owned_book, i.wall);
  robot.hand = tap_hand(std::move(robot.hand), i.owned_book);
  robot.camera = tap_camera(std::move(robot.camera), i.owned_book, 0);
  for (std::size_t n = 0; n < robot.more_cameras.size(); ++n)
    robot.more_cameras[n] = tap_camera(std::move(robot.more_cameras[n]), i.owned_book, n + 1);
  robot.clock = tap_clock(std::move(robot.clock), i.owned_book);
}

control::JobHooks RunTelemetry::hooks(control::JobHooks yours) {
  Impl& i = *impl_;
  i.book.now = {};
  i.book.listens = true;
  control::JobHooks out;
  // whoever else listens may ask devices and clock: that is not the job's doing
  const auto aside = [&i](const auto& call) {
    i.book.listens = false;
    call();
    i.book.listens = true;
  };
  out.started = [&i, aside, yours] {
    if (yours.started) aside([&] { yours.started(); });
  };
  out.interrupted = [&i, yours] {
    const bool asked = yours.interrupted && yours.interrupted();
    if (asked) i.book.now.interrupted = true;
    return asked;
  };
  out.lower_confirmed = [&i, yours] {
    const bool confirmed = yours.lower_confirmed && yours.lower_confirmed();
    if (confirmed) i.book.now.lower_confirmed = true;
    return confirmed;
  };
  out.continue_confirmed = [&i, yours] {
    const bool confirmed = yours.continue_confirmed && yours.continue_confirmed();
    if (confirmed) i.book.now.continue_confirmed = true;
    return confirmed;
  };
  out.status = [&i, aside, yours](const control::JobStatus& status) {
    i.on_status(status);
    if (yours.status) aside([&] { yours.status(status); });
  };
  out.tracked = [&i, aside, yours](const control::TrackedPoses& tracked) {
    i.on_tracked(tracked);
    if (yours.tracked) aside([&] { yours.tracked(tracked); });
  };
  out.asked = [aside, yours](const control::PartnerAsk& ask) {
    if (yours.asked) aside([&] { yours.asked(ask); });
  };
  out.changed = [aside, yours](control::Task from, control::Task to) {
    if (yours.changed) aside([&] { yours.changed(from, to); });
  };
  out.cycle = [&i, aside, yours](const control::ArmView& view) {
    i.on_cycle(view);
    if (yours.cycle) aside([&] { yours.cycle(view); });
  };
  return out;
}

void RunTelemetry::on_fault(std::function<void(const std::string&)> listener) {
  impl_->fault_listener = std::move(listener);
}

void RunTelemetry::truth(hal::Timestamp at, const TruthNow& t) {
  impl_->publish(Topic::Truth, at, [t] {
    return dumped({{"t", t.t_s},
                   {"robot_force_z_n", number_json(t.robot_force_z_n)},
                   {"partner_force_z_n", number_json(t.partner_force_z_n)},
                   {"floor_force_z_n", number_json(t.floor_force_z_n)},
                   {"share", number_json(t.share)},
                   {"tilt_deg", number_json(hal::rad_to_deg(t.tilt_rad))},
                   {"height_m", number_json(t.height_m)},
                   {"slip_m", number_json(t.slip_m)}});
  });
}

void RunTelemetry::log(int level, const std::string& name, const std::string& text) {
  impl_->log(impl_->time(), static_cast<Level>(level), name, text);
}

}  // namespace colift::telemetry
