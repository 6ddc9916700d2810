#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "control/config/resolve_config.hpp"
#include "control/session/decide.hpp"
#include "control/session/perception_session.hpp"
#include "hal/types/result.hpp"
#include "planner/motion/motion_planner.hpp"
#include "sim_hal/mujoco/sim_world.hpp"

namespace colift::experiments {

/// Hand and its collision tables for a method's candidates, made once for all trials of a process. Any
/// thread.
struct SharedHand {
  planner::HandModel hand;
  std::shared_ptr<const planner::HandCollision> tables;
};
[[nodiscard]] const SharedHand& shared_hand(control::Method method);

/// What a trial sets: path of an entry and value, as `--set` takes them.
using Settings = std::vector<std::pair<std::string, std::string>>;

/// Configuration of an experiment (control::Command::Experiment) with a method, what the experiment says
/// about its lifts, and what the trial sets.
[[nodiscard]] control::ResolvedConfig resolved_for(control::Method method,
                                                   const std::optional<control::TaskSaid>& task = {},
                                                   const Settings& settings = {});
/// The same without the origins.
[[nodiscard]] control::Config config_for(control::Method method,
                                         const std::optional<control::TaskSaid>& task = {},
                                         const Settings& settings = {});

/// What the robot knows before it moves: the scene, the partner's grasp, a planner for the ways. Made as a
/// run makes it, on a simulated camera, with the arm at rest at home. One thread.
class Observation {
 public:
  /// Errors: NotFound (no target, or the partner was not seen in time, with the reason), BadConfig (scenario,
  /// or a method that this build lacks).
  [[nodiscard]] static hal::Result<std::unique_ptr<Observation>> make(const sim_hal::Scenario& scenario,
                                                                      control::Method method,
                                                                      std::uint64_t seed,
                                                                      double lift_height_m);
  ~Observation();

  /// Of the scene; every candidate that is Ok can be reached.
  [[nodiscard]] const control::SceneAnalysis& analysis() const;
  /// Nothing in a scenario without a partner.
  [[nodiscard]] const std::optional<perception::PartnerGrasp>& partner() const;
  [[nodiscard]] const hal::Vec3& true_partner() const;
  [[nodiscard]] const hal::Vec3& true_cog() const;

  /// The run's own decision, with any prices. Errors: those of decide_for().
  [[nodiscard]] hal::Result<control::Outcome> decide(const control::Config& config);
  /// The same among all candidates at steps of `step_m` along the lines, too.
  [[nodiscard]] hal::Result<control::Outcome> decide_finely(const control::Config& config, double step_m);
  /// The same for a partner who is elsewhere now.
  [[nodiscard]] hal::Result<control::Outcome> decide_for(const perception::PartnerGrasp& partner,
                                                         const control::Config& config);
  /// The same with a centre of gravity that is known better. Candidates are those of the look.
  [[nodiscard]] hal::Result<control::Outcome> decide(const control::Config& config, const hal::Vec3& cog);
  /// What goes on after the partner's first grasp, for experiments that watch on.
  [[nodiscard]] control::PerceptionSession& watch();
  [[nodiscard]] sim_hal::SimWorld& world();
  [[nodiscard]] hal::DepthCamera& camera();

  /// The whole way to a grasp from home. Errors: NotFound with the reason.
  [[nodiscard]] hal::Result<planner::MotionPlan> plan(const planner::GraspCandidate& grasp);

 private:
  struct Impl;
  explicit Observation(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::experiments
