// The arm goes from pose to pose, the camera looks for the blinking emitter.

#include <fmt/format.h>

#include "control/arm/arm_commander.hpp"
#include "planner/motion/collision/collision_scene.hpp"
#include "planner/motion/motion_planner.hpp"
#include "tools/calibrate/calibrate.hpp"
#include "tools/cli/interrupt.hpp"

namespace colift::tools {
namespace {

using namespace std::chrono_literals;
using hal::ErrorCode;

constexpr int kImages = 16;  // half a second: five blinks of a tenth of a second
constexpr hal::Duration kSettle = 600ms;
constexpr hal::Duration kTimeout = 3s;  // for the images of one pose
constexpr double kPathTimeout_s = 60.0;
constexpr int kArmMisses = 20;
constexpr std::size_t kSpare = 2;  // poses are proposed twice as many as are needed
constexpr int kFailures = 12;      // in a row: the emitter is off, or the camera looks elsewhere

/// Arm and camera of a rig that is going through its poses.
class Session {
 public:
  Session(Rig& rig, hal::InfraredCamera& infrared, const planner::HandModel& hand,
          const control::Config& config, const LiveSetting& setting)
      : rig_(rig),
        infrared_(infrared),
        config_(config),
        setting_(setting),
        geometry_(planner::arm_geometry(*rig.model).value()),
        map_(config.map),
        planner_(*rig.model, hand, config.motion, setting.seed),
        commander_(*rig.robot.arm, *rig.model, geometry_, config.task, config.load, rig.drive,
                   config.setpoints) {}

  hal::Result<perception::SampleSet> run() {
    if (auto done = open(); !done) return tl::unexpected(done.error());
    auto set = go_through();
    commander_.finish();
    (void)infrared_.want_infrared(false);
    rig_.robot.camera->deactivate();
    rig_.robot.hand->deactivate();
    return set;
  }

 private:
  hal::Result<> open() {
    auto& robot = rig_.robot;
    for (hal::Device* device :
         {static_cast<hal::Device*>(robot.camera.get()), static_cast<hal::Device*>(robot.hand.get()),
          static_cast<hal::Device*>(robot.arm.get())})
      if (auto done = device->configure(); !done) return done;
    if (auto done = robot.camera->activate(); !done) return done;
    if (auto done = robot.hand->activate(); !done) return done;
    if (auto done = infrared_.want_infrared(true); !done) return done;
    if (auto done = commander_.start(); !done) return done;
    if (rig_.begin) rig_.begin();
    planner_.set_scene(std::make_shared<planner::CollisionScene>(planner::make_collision_scene(
                           map_, hal::Plane{hal::Vec3::UnitZ(), 0.0}, {}, config_.motion.scene)),
                       map_, hal::Vec3::UnitZ());
    return {};
  }

  hal::Result<perception::SampleSet> go_through() {
    perception::SampleSet out;
    out.date = setting_.date;
    std::vector<perception::ProposedPose> proposed;
    std::optional<perception::SampleWriter> writer;
    int failures = 0;
    std::string last;
    for (std::size_t next = 0;; ++next) {
      if (InterruptGuard::asked()) return hal::failure(ErrorCode::NotReady, "calibrate", "interrupted");
      if (static_cast<int>(out.samples.size()) >= setting_.poses) return out;
      if (!out.read.empty() && next >= proposed.size())
        return hal::failure(
            ErrorCode::NotFound, "calibrate",
            fmt::format("only {} of {} poses could be used; {}", out.samples.size(), setting_.poses, last));
      if (out.read.empty()) {
        // the first image tells the intrinsics by which the poses are chosen
        auto first = observe(1);
        if (!first) return tl::unexpected(first.error());
        out.camera = first->frames.front().intrinsics;
        proposed = propose(out.camera);
        if (proposed.size() < static_cast<std::size_t>(setting_.poses))
          return hal::failure(
              ErrorCode::NotFound, "calibrate",
              fmt::format("only {} poses are in view of a camera at ({:.1f}, {:.1f}, {:.1f}); is "
                          "--camera-at right?",
                          proposed.size(), setting_.camera_at_B.x(), setting_.camera_at_B.y(),
                          setting_.camera_at_B.z()));
        if (setting_.save) writer.emplace(*setting_.save, out.camera, setting_.date);
      }
      const std::size_t number = out.read.size();
      out.read.push_back({static_cast<int>(number), std::nullopt, ""});
      auto way = planner_.plan_to(commander_.commanded(), proposed[next].q_rad);
      if (!way) {
        last = out.read.back().refused = way.error().detail;
        say(number, "no path: " + last);
        continue;
      }
      if (auto done = drive(*way); !done) return tl::unexpected(done.error());
      auto seen = observe(kImages);
      if (!seen) return tl::unexpected(seen.error());
      if (writer)
        if (auto done = writer->add(seen->q_rad, seen->frames, seen->depth); !done)
          return tl::unexpected(done.error());
      const auto spot = perception::find_blinking_spot(seen->frames, config_.spot);
      if (!spot) {
        last = out.read.back().refused = spot.error().reason;
        say(number, last);
        if (++failures >= kFailures)
          return hal::failure(
              ErrorCode::NotFound, "calibrate",
              fmt::format("no spot in {} poses in a row: {}; does the emitter blink, and does the "
                          "camera look at the arm?",
                          failures, last));
        continue;
      }
      failures = 0;
      out.read.back().spot = *spot;
      perception::EmitterSample sample;
      sample.X_BH = hal::hand_pose(*rig_.model, seen->q_rad);
      sample.pixel = spot->pixel;
      sample.covariance = spot->covariance;
      if (seen->depth) sample.depth_m = perception::depth_near(*seen->depth, spot->pixel);
      out.samples.push_back(sample);
      out.joints_rad.push_back(seen->q_rad);
      out.index.push_back(static_cast<int>(number));
      say(number, fmt::format("spot at ({:.2f}, {:.2f}){}", spot->pixel.x(), spot->pixel.y(),
                              sample.depth_m ? fmt::format(", {:.3f} m away", *sample.depth_m) : ""));
    }
  }

  std::vector<perception::ProposedPose> propose(const hal::CameraIntrinsics& camera) {
    const auto rough = perception::rough_camera(setting_.camera_at_B, config_.calibration.workspace_center_m,
                                                camera, config_.calibration.emitter_m);
    const auto candidates = perception::candidate_poses(*rig_.model, rough, config_.calibration,
                                                        config_.calibration_poses, setting_.seed);
    return perception::choose_poses(candidates, {}, rough, config_.calibration,
                                    kSpare * static_cast<std::size_t>(setting_.poses));
  }

  hal::Result<> cycle() {
    commander_.begin_cycle();
    commander_.end_cycle();
    const control::ArmView& view = commander_.view();
    if (view.link_lost || view.misses >= kArmMisses)
      return hal::failure(ErrorCode::LinkLost, "calibrate", "the arm: " + std::string(view.fault.str()));
    return {};
  }

  hal::Result<> drive(const planner::Trajectory& way) {
    if (auto done = commander_.follow(way); !done) return done;
    const std::uint32_t starts = commander_.starts();
    const hal::Timestamp began = rig_.robot.clock->now();
    while (!commander_.done()) {
      if (auto done = cycle(); !done) return done;
      const double waited = hal::seconds(rig_.robot.clock->now() - began);
      std::string why;
      if (commander_.blocked()) why = "the arm met something: " + commander_.why_blocked();
      if (commander_.starts() > starts + 1) why = "the arm's controller interrupted the motion";
      if (waited > kPathTimeout_s + way.duration_s()) why = "timeout: motion";
      if (InterruptGuard::asked()) why = "interrupted";
      if (why.empty()) continue;
      commander_.hold();
      for (int i = 0; i < 400 && !commander_.at_rest(); ++i)
        if (auto done = cycle(); !done) return done;
      return hal::failure(ErrorCode::NotFound, "calibrate", why);
    }
    return {};
  }

  /// What one pose shows.
  struct Seen {
    hal::JointVector q_rad = hal::JointVector::Zero();  ///< Mean while the images were taken.
    std::vector<hal::InfraredFrame> frames;
    std::optional<hal::DepthFrame> depth;
  };

  hal::Result<Seen> observe(int images) {
    const hal::Clock& clock = *rig_.robot.clock;
    const hal::Timestamp settled = clock.now() + kSettle;
    while (clock.now() < settled) {
      if (auto done = cycle(); !done) return tl::unexpected(done.error());
      (void)infrared_.next_infrared(0ms);  // taken while the arm trembled
    }
    Seen out;
    int cycles = 0;
    std::string error = "none came";
    const hal::Timestamp deadline = clock.now() + kTimeout;
    while (static_cast<int>(out.frames.size()) < images) {
      if (clock.now() > deadline)
        return hal::failure(ErrorCode::Timeout, "calibrate",
                            fmt::format("{} of {} infrared images within {:.0f} s: {}", out.frames.size(),
                                        images, hal::seconds(kTimeout), error));
      if (auto done = cycle(); !done) return tl::unexpected(done.error());
      out.q_rad += commander_.view().state.q_rad;
      ++cycles;
      auto frame = infrared_.next_infrared(0ms);
      if (frame)
        out.frames.push_back(std::move(*frame));
      else
        error = frame.error().detail;
    }
    out.q_rad /= cycles;
    // depth beside infrared where the camera can; else without
    if (auto depth = rig_.robot.camera->next_frame(rig_.drive == control::Drive::InStep ? 40ms : 0ms))
      out.depth = std::move(*depth);
    return out;
  }

  void say(std::size_t number, const std::string& what) const {
    if (setting_.say) setting_.say(fmt::format("pose {}: {}", number, what));
  }

  Rig& rig_;
  hal::InfraredCamera& infrared_;
  const control::Config& config_;
  const LiveSetting& setting_;
  planner::ArmGeometry geometry_;
  perception::WorldMap map_;
  planner::MotionPlanner planner_;
  control::ArmCommander commander_;
};

}  // namespace

hal::Result<perception::SampleSet> take_samples(Rig& rig, hal::InfraredCamera& infrared,
                                                const planner::HandModel& hand, const control::Config& config,
                                                const LiveSetting& setting) {
  return Session(rig, infrared, hand, config, setting).run();
}

}  // namespace colift::tools
