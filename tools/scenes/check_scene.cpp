#include "tools/scenes/check_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "control/session/decide.hpp"
#include "control/session/scene_analysis.hpp"
#include "perception/motion/object_motion.hpp"
#include "perception/reference_image.hpp"

namespace colift::tools {
namespace {

using control::SceneAnalysis;

constexpr double kPure = 0.85, kCovered = 0.6, kMost = 0.5;
constexpr double kHand_m = 0.10, kHandPartly_m = 0.20;
constexpr double kRise_m = 0.01, kRiseError_m = 0.015;

struct Answer {
  SceneVerdict verdict;
  std::string truth, found;
};

hal::Result<SceneAnalysis> analyse(const hal::DepthFrame& frame, const Setup& setup) {
  control::SceneAnalysisInput input;  // in the camera's own frame: nobody knows where it stands
  input.frame = frame;
  return control::analyse_scene(std::move(input), setup.method, setup.config, setup.hand, hal::SteadyClock(),
                                setup.hand_tables);
}

std::string words_of(const hal::Vec3& p) {
  return fmt::format("at ({:.2f}, {:.2f}, {:.2f})", p.x(), p.y(), p.z());
}

std::string size_words(const perception::Target& t) {
  const auto& s = t.obb.size;
  return fmt::format("{:.2f} x {:.2f} x {:.2f} m {}", s.x(), s.y(), s.z(), words_of(t.obb.center));
}

Answer of_empty(const SceneAnalysis& seen) {
  const auto& target = seen.scene.target;
  return {target ? SceneVerdict::Wrong : SceneVerdict::Right, "no target",
          target ? size_words(*target) : seen.reason};
}

// points, because the thesis's target has no pixels
Answer of_object(const SceneAnalysis& seen, const RecordedSteps& scene, const SceneTruth& truth,
                 double leaf_m) {
  const std::string is = fmt::format("{}, {} pixels", scene.file.object, truth.object_count);
  const auto& target = seen.scene.target;
  if (!target || target->points.empty()) return {SceneVerdict::Nothing, is, seen.reason};
  std::vector<bool> covered(truth.object_pixels.size(), false);
  std::size_t own = 0;
  for (const Eigen::Vector3f& p : target->points) {
    const auto at = seen.cloud.project(p.cast<double>());
    if (!seen.cloud.contains(at.u, at.v)) continue;
    const auto i =
        static_cast<std::size_t>(std::lround(at.v)) * static_cast<std::size_t>(seen.cloud.width()) +
        static_cast<std::size_t>(std::lround(at.u));
    own += truth.object_pixels[i] ? 1 : 0;
    // a point of the thesis's stands for its voxel
    const int half = target->pixels.empty()
                         ? static_cast<int>(std::ceil(0.5 * leaf_m * seen.cloud.intrinsics.fx / at.depth_m))
                         : 0;
    const int u = static_cast<int>(std::lround(at.u)), v = static_cast<int>(std::lround(at.v));
    for (int y = std::max(0, v - half); y <= std::min(seen.cloud.height() - 1, v + half); ++y)
      for (int x = std::max(0, u - half); x <= std::min(seen.cloud.width() - 1, u + half); ++x)
        covered[static_cast<std::size_t>(y * seen.cloud.width() + x)] = true;
  }
  const double pure = static_cast<double>(own) / static_cast<double>(target->points.size());
  std::size_t there = 0, found = 0;
  for (std::size_t i = 0; i < covered.size(); ++i) {
    if (!truth.object_pixels[i] || !seen.cloud.seen(i)) continue;
    ++there;
    found += covered[i] ? 1 : 0;
  }
  const double part = static_cast<double>(found) / static_cast<double>(std::max<std::size_t>(there, 1));
  const std::string words =
      fmt::format("{}: {:.0f} % of it are the object's, {:.0f} % of the object's pixels are in it",
                  size_words(*target), 1e2 * pure, 1e2 * part);
  if (pure < kMost) return {SceneVerdict::Wrong, is, words};
  return {pure >= kPure && part >= kCovered ? SceneVerdict::Right : SceneVerdict::Partly, is, words};
}

hal::Result<Answer> of_hand(const SceneAnalysis& seen, const RecordedSteps& scene, const SceneTruth& truth,
                            const control::Config& config) {
  const std::size_t places = truth.hands.size();
  const std::string is = fmt::format(
      "near it {}{}", words_of(truth.hands.front()),
      places > 1 ? fmt::format(" and at {} more (hand_px in scene.json picks one)", places - 1) : "");
  if (!seen.scene.target) return Answer{SceneVerdict::Nothing, is, "no target to take hold of"};
  control::PartnerInput partner;
  partner.frame = scene.frames[static_cast<std::size_t>(SceneStep::Hand)].back();
  const auto outcome = control::decide(seen, partner, config, hal::SteadyClock());
  if (!outcome) return tl::unexpected(outcome.error());
  if (!outcome->partner) return Answer{SceneVerdict::Nothing, is, outcome->partner_reason};
  const hal::Vec3& p = outcome->partner->position;
  // of two hands the middle counts
  double off = std::numeric_limits<double>::infinity();
  for (const hal::Vec3& a : truth.hands)
    for (const hal::Vec3& b : truth.hands) off = std::min(off, (p - 0.5 * (a + b)).norm());
  const auto verdict = off <= kHand_m         ? SceneVerdict::Right
                       : off <= kHandPartly_m ? SceneVerdict::Partly
                                              : SceneVerdict::Wrong;
  return Answer{verdict, is, fmt::format("{}, {:.0f} mm off", words_of(p), 1e3 * off)};
}

hal::Result<Answer> of_lift(const SceneAnalysis& seen, const RecordedSteps& scene,
                            const control::Config& config) {
  const auto& lifted = scene.file.lifted_m;
  const std::string is = lifted ? fmt::format("lifted by {:.0f} mm", 1e3 * *lifted)
                                : fmt::format("lifted, more than {:.0f} mm", 1e3 * kRise_m);
  if (!seen.scene.target || !seen.scene.ground)
    return Answer{SceneVerdict::Nothing, is, "no target to follow"};
  const auto& standing = scene.frames[static_cast<std::size_t>(SceneStep::Object)];
  auto reference =
      perception::build_reference(standing, hal::Pose::Identity(), config.noise, config.partner.reference);
  if (!reference) return Answer{SceneVerdict::Nothing, is, reference.error().text()};
  auto follower =
      perception::ObjectFollower::make(*reference, *seen.scene.target, config.noise, config.object_motion);
  if (!follower) return Answer{SceneVerdict::Nothing, is, follower.error().text()};
  std::optional<perception::ObjectMotion> motion;
  std::string why;
  for (const hal::DepthFrame& frame : scene.frames[static_cast<std::size_t>(SceneStep::Lift)])
    motion = follower->update(frame, &why);
  if (!motion) return Answer{SceneVerdict::Nothing, is, "lost on the way: " + why};
  const double rise = motion->rise(seen.scene.target->obb.center, seen.scene.ground->plane.normal);
  const std::string words =
      fmt::format("rises by {:.0f} mm, {:.0f} % of its points found again", 1e3 * rise, 1e2 * motion->seen);
  const bool near = !lifted || std::abs(rise - *lifted) <= kRiseError_m;
  const bool up = rise > kRise_m || (lifted && near);
  return Answer{up && near ? SceneVerdict::Right
                : up       ? SceneVerdict::Partly
                           : SceneVerdict::Wrong,
                is, words};
}

}  // namespace

hal::Result<std::vector<SceneRow>> check_scene(const RecordedSteps& scene, const SceneTruth& truth,
                                               const Setup& setup) {
  std::vector<SceneRow> rows;
  const auto add = [&](SceneStep step, Answer answer) {
    const auto known = scene.file.known.find(to_string(step));
    const SceneVerdict worst = setup.method == control::Method::Fast && known != scene.file.known.end()
                                   ? known->second
                                   : SceneVerdict::Right;
    rows.push_back({step, setup.method, answer.verdict, std::move(answer.truth), std::move(answer.found),
                    answer.verdict <= worst});
  };
  const auto last = [&](SceneStep step) -> const hal::DepthFrame& {
    return scene.frames[static_cast<std::size_t>(step)].back();
  };
  const auto empty = analyse(last(SceneStep::Empty), setup);
  if (!empty) return tl::unexpected(empty.error());
  add(SceneStep::Empty, of_empty(*empty));
  const auto object = analyse(last(SceneStep::Object), setup);
  if (!object) return tl::unexpected(object.error());
  add(SceneStep::Object, of_object(*object, scene, truth, setup.config.thesis.voxel_leaf_m));
  auto hand = of_hand(*object, scene, truth, setup.config);
  if (!hand) return tl::unexpected(hand.error());
  add(SceneStep::Hand, std::move(*hand));
  if (setup.method == control::Method::Fast) {
    auto lift = of_lift(*object, scene, setup.config);
    if (!lift) return tl::unexpected(lift.error());
    add(SceneStep::Lift, std::move(*lift));
  }
  return rows;
}

}  // namespace colift::tools
