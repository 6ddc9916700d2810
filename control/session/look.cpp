#include "control/session/look.hpp"

#include "perception/ground_and_target/block_planes.hpp"
#include "perception/shape/shape_completion.hpp"
#include "perception/surfaces/find_surfaces.hpp"
#ifdef COLIFT_THESIS
#include "perception/thesis/thesis_target.hpp"
#endif

namespace colift::control {
namespace {

// milliseconds since the last call
class Stopwatch {
 public:
  explicit Stopwatch(const hal::Clock& clock) : clock_(clock), last_(clock.now()) {}
  double lap() {
    const hal::Timestamp now = clock_.now();
    const double ms = 1e3 * hal::seconds(now - last_);
    last_ = now;
    return ms;
  }

 private:
  const hal::Clock& clock_;
  hal::Timestamp last_;
};

void look_fast(Look& out, const LookInput& input, const Config& c, Stopwatch& watch) {
  using namespace perception;
  out.cloud = deproject(input.frame, input.X_WC);
  std::optional<hal::Vec3> up;
  if (input.base_frame_known)
    up = hal::Vec3::UnitZ();
  else if (input.frame.up_C)
    up = input.X_WC.linear() * *input.frame.up_C;

  const std::vector<BlockPlane> blocks = fit_block_planes(out.cloud, c.noise, c.ground.blocks);
  GroundResult ground = find_ground(out.cloud, blocks, up, c.noise, c.ground);
  out.ms.ground = watch.lap();
  out.scene.ground = ground.ground;
  out.scene.because = ground.because;
  if (!ground.ground) return;

  TargetResult found = find_target(out.cloud, blocks, *ground.ground, c.noise, c.target, input.at_W);
  out.ms.target = watch.lap();
  out.scene.because = found.because;
  out.rejected = std::move(found.rejected);
  if (!found.target) return;

  Target& target = *found.target;
  out.scene.surfaces = find_surfaces(out.cloud, target, *ground.ground, c.noise, c.surfaces);
  const CompletedShape shape =
      complete_shape(out.cloud, target, out.scene.surfaces, *ground.ground, c.noise, c.completion);
  target.cog = shape.cog;
  target.cog_covariance = shape.covariance;
  target.shape = shape.box;
  out.scene.target = std::move(target);
  out.ms.surfaces = watch.lap();
}

// The face itself is no obstacle to the hand that grasps it. Its points stray by the camera's noise, and the
// rectangle goes through their middle.
planner::CandidateConfig thesis_candidates() {
  constexpr double kStray_m = 0.02;
  planner::CandidateConfig config = planner::thesis_candidates();
  config.collision.feature_margin_m = kStray_m;
  return config;
}

}  // namespace

hal::Result<Look> look(LookInput input, Method method, const Config& c, const planner::HandModel& hand,
                       const hal::Clock& clock,
                       const std::shared_ptr<const planner::HandCollision>& hand_tables) {
  Look out;
  out.method = method;
  out.base_frame_known = input.base_frame_known;
  Stopwatch whole(clock), watch(clock);
  if (method == Method::Fast) {
    look_fast(out, input, c, watch);
  } else {
#ifdef COLIFT_THESIS
    out.cloud = perception::deproject(input.frame, input.X_WC);
    out.scene = perception::thesis_scene(out.cloud, c.thesis);
    out.ms.target = watch.lap();
#else
    return hal::failure(hal::ErrorCode::BadConfig, "method",
                        "this build has no thesis method (COLIFT_THESIS=OFF)");
#endif
  }
  if (out.scene.target) {
    const bool fast = method == Method::Fast;
    const planner::CandidateConfig candidates = fast ? c.candidates : thesis_candidates();
    out.finder = std::make_shared<planner::CandidateFinder>(out.scene, fast ? &out.cloud : nullptr, hand,
                                                            candidates, fast ? hand_tables : nullptr);
    out.candidates = out.finder->find();
    out.ms.candidates = watch.lap();
    out.because = planner::explain(out.candidates);
  } else {
    out.because = out.scene.because;
  }
  out.ms.total = whole.lap();
  out.frame = std::move(input.frame);
  return out;
}

}  // namespace colift::control
