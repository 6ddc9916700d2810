#include "tools/experiments/trials/sighting.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "sim_hal/mujoco/devices/sim_devices.hpp"

namespace colift::experiments {
namespace {

constexpr double kNobody_s = 2.0;  // after his arrival he is seen, or not at all
constexpr double kRenewed_m = 1e-6;

/// Computing time has no part in any result here: the stopwatch stands still.
class NoClock final : public hal::Clock {
 public:
  [[nodiscard]] hal::Timestamp now() const override { return hal::Timestamp(0); }
};

hal::Error missing(std::string what) {
  return {hal::ErrorCode::NotFound, "scene", std::move(what)};
}

}  // namespace

const SharedHand& shared_hand(control::Method method) {
  const auto make = [](control::Method m) {
    SharedHand s;
    s.tables = std::make_shared<planner::HandCollision>(s.hand, config_for(m).candidates.collision);
    return s;
  };
  static const SharedHand fast = make(control::Method::Fast), thesis = make(control::Method::Thesis);
  return method == control::Method::Fast ? fast : thesis;
}

control::ResolvedConfig resolved_for(control::Method method, const std::optional<control::TaskSaid>& task,
                                     const Settings& settings) {
  control::ConfigRequest request;
  request.command = control::Command::Experiment;
  request.task = task;
  request.options.push_back({"method", control::to_string(method), "--method"});
  for (const auto& [path, value] : settings) request.options.push_back({path, value, "experiment"});
  auto resolved = control::resolve_config(request);
  if (!resolved) throw std::logic_error(resolved.error().text());  // nobody else had a say
  return std::move(*resolved);
}

control::Config config_for(control::Method method, const std::optional<control::TaskSaid>& task,
                           const Settings& settings) {
  return resolved_for(method, task, settings).config;
}

struct Observation::Impl {
  Impl(control::Method m, std::uint64_t seed, std::unique_ptr<sim_hal::SimWorld> w, double height)
      : method(m),
        config(config_for(m, control::TaskSaid{"experiment", height})),
        lift_height_m(height),
        world(std::move(w)),
        watch(m, config, rig(*world, m), clock),
        planner(world->model(), shared_hand(m).hand, config.motion, seed) {}

  static control::RigView rig(const sim_hal::SimWorld& world, control::Method method) {
    return {world.model(), shared_hand(method).hand, shared_hand(method).tables,
            sim_hal::camera_pose(world.scenario().camera), sim_hal::more_camera_poses(world.scenario())};
  }
  [[nodiscard]] control::RobotPosture posture() const {
    return {world->arm_state().q_rad, hal::posture_of(world->hand_state())};
  }
  void set_scene() {
    planner.set_scene(
        std::make_shared<planner::CollisionScene>(planner::make_collision_scene(
            watch.map(), watch.analysis().scene.ground->plane, watch.partner_points(), config.motion.scene)),
        watch.map(), hal::Vec3::UnitZ());
  }

  /// The next frame of the first camera; what the others have by then is handed on.
  hal::Result<hal::DepthFrame> next_frame(hal::DepthCamera& camera) {
    auto frame = camera.next_frame(std::chrono::milliseconds(100));
    for (std::size_t n = 0; n < more_eyes.size(); ++n)
      if (auto other = more_eyes[n]->next_frame(std::chrono::milliseconds(0)))
        watch.take_frame(n + 1, std::move(*other), posture());
    return frame;
  }

  hal::Result<> see_scene(hal::DepthCamera& camera) {
    const double late_s = hal::seconds(world->elapsed()) + 5.0;
    while (watch.reference_frames() < config.task.reference_frames) {
      if (hal::seconds(world->elapsed()) > late_s) return tl::unexpected(missing("the camera shows nothing"));
      if (auto frame = next_frame(camera)) watch.add_reference(std::move(*frame), posture());
    }
    if (auto seen = watch.analyse_scene(posture()); !seen) return seen;
    if (!watch.analysis().scene.target) return tl::unexpected(missing(watch.analysis().reason));
    set_scene();
    planner.judge(watch.analysis().candidates, lift_height_m);
    control::add_grasps(
        watch.analysis(), config.candidates,
        [this](std::vector<planner::GraspCandidate>& more) { planner.judge(more, lift_height_m); });
    return {};
  }

  hal::Result<> see_partner(hal::DepthCamera& camera) {
    const double late_s = world->scenario().partner.arrives_s + kNobody_s;
    std::string note = "he was not seen";
    while (hal::seconds(world->elapsed()) < late_s) {
      auto frame = next_frame(camera);
      if (!frame) continue;
      auto sight = watch.observe_partner(*frame, posture());
      if (!sight) return tl::unexpected(sight.error());
      note = sight->partner.reason;
      if (!sight->event || sight->event->kind != perception::PartnerEvent::Kind::Grasped) continue;
      partner = watch.tracker().grasp();
      true_partner = world->truth().partner_W.value_or(sim_hal::object_pose(world->scenario().object) *
                                                       world->scenario().partner.grasp);
      set_scene();
      // now that he stands there, his arms are in some ways
      planner.judge(watch.analysis().candidates, lift_height_m);
      return {};
    }
    return tl::unexpected(missing("the partner's grasp: " + note));
  }

  control::Method method;
  control::Config config;
  double lift_height_m;
  NoClock clock;
  std::unique_ptr<sim_hal::SimWorld> world;
  control::PerceptionSession watch;
  planner::MotionPlanner planner;
  std::unique_ptr<hal::DepthCamera> eye;
  std::vector<std::unique_ptr<hal::DepthCamera>> more_eyes;
  std::optional<perception::PartnerGrasp> partner;
  hal::Vec3 true_partner = hal::Vec3::Zero(), true_cog = hal::Vec3::Zero();
};

Observation::Observation(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Observation::~Observation() = default;

hal::Result<std::unique_ptr<Observation>> Observation::make(const sim_hal::Scenario& scenario,
                                                            control::Method method, std::uint64_t seed,
                                                            double lift_height_m) {
  auto world = sim_hal::SimWorld::make(scenario, hal::built_in_robot(), seed, sim_hal::SimConfig{});
  if (!world) return tl::unexpected(world.error());
  auto impl = std::make_unique<Impl>(method, seed, std::move(*world), lift_height_m);
  impl->true_cog = impl->world->truth().cog_W;
  impl->eye = sim_hal::make_sim_camera(*impl->world);
  impl->more_eyes = sim_hal::make_more_sim_cameras(*impl->world);
  hal::DepthCamera* const camera = impl->eye.get();
  std::vector<hal::DepthCamera*> all{camera};
  for (const auto& eye : impl->more_eyes) all.push_back(eye.get());
  for (hal::DepthCamera* each : all) {
    if (auto ok = each->configure(); !ok) return tl::unexpected(ok.error());
    if (auto ok = each->activate(); !ok) return tl::unexpected(ok.error());
  }
  if (auto seen = impl->see_scene(*camera); !seen) return tl::unexpected(seen.error());
  if (scenario.partner.kind != "none") {
    if (auto seen = impl->see_partner(*camera); !seen) return tl::unexpected(seen.error());
  }
  return std::unique_ptr<Observation>(new Observation(std::move(impl)));
}

const control::SceneAnalysis& Observation::analysis() const {
  return impl_->watch.analysis();
}
const std::optional<perception::PartnerGrasp>& Observation::partner() const {
  return impl_->partner;
}
const hal::Vec3& Observation::true_partner() const {
  return impl_->true_partner;
}
const hal::Vec3& Observation::true_cog() const {
  return impl_->true_cog;
}

control::PerceptionSession& Observation::watch() {
  return impl_->watch;
}
sim_hal::SimWorld& Observation::world() {
  return *impl_->world;
}
hal::DepthCamera& Observation::camera() {
  return *impl_->eye;
}

hal::Result<control::Outcome> Observation::decide(const control::Config& config) {
  return decide_for(*impl_->partner, config);
}

hal::Result<control::Outcome> Observation::decide_for(const perception::PartnerGrasp& partner,
                                                      const control::Config& config) {
  return control::decide_for(impl_->watch.analysis(), partner, config, impl_->clock,
                             [this](std::vector<planner::GraspCandidate>& more) {
                               impl_->planner.judge(more, impl_->lift_height_m);
                             });
}

hal::Result<control::Outcome> Observation::decide_finely(const control::Config& config, double step_m) {
  control::SceneAnalysis& analysis = impl_->watch.analysis();
  const std::vector<planner::GraspCandidate> before = analysis.candidates;
  auto more = analysis.finder->between(step_m, before);
  impl_->planner.judge(more, impl_->lift_height_m);
  analysis.candidates.insert(analysis.candidates.end(), more.begin(), more.end());
  auto outcome = decide(config);
  analysis.candidates = before;
  return outcome;
}

hal::Result<control::Outcome> Observation::decide(const control::Config& config, const hal::Vec3& cog) {
  hal::Vec3& believed = impl_->watch.analysis().scene.target->cog;
  const hal::Vec3 before = believed;
  if ((cog - before).norm() > kRenewed_m) believed = cog;
  auto outcome = decide(config);
  believed = before;
  return outcome;
}

hal::Result<planner::MotionPlan> Observation::plan(const planner::GraspCandidate& grasp) {
  return impl_->planner.plan(sim_hal::SimConfig::home_rad(), grasp, impl_->lift_height_m);
}

}  // namespace colift::experiments
