#include "control/config/method.hpp"

#include <limits>

#include "control/config/config.hpp"

namespace colift::control {
namespace {

// Its mean of 100 points comes three times a second and strays by centimetres as the person's arm and body
// come and go among them. Three of them have to agree; one that is missing is no end of a grasp.
constexpr double kDwell_s = 0.6;
constexpr double kLetGo_s = 0.8;
constexpr double kMoved_m = 0.08;

// The face itself is no obstacle to the hand that grasps it. Its points stray by the camera's noise, and the
// rectangle goes through their middle.
constexpr double kStray_m = 0.02;

// Its step is configurable, without a figure (section 5.3.2.2). It knows no place between two steps and no
// approach but the normal, so that of a face little lies in reach: with the fast method's 5 cm that is often
// fewer than the ten grasps that it tried on each object (section 6.1).
constexpr double kStep_m = 0.02;

}  // namespace

const char* to_string(Method method) {
  return method == Method::Fast ? "fast" : "thesis";
}

std::optional<Method> method_named(std::string_view name) {
  for (const Method method : {Method::Fast, Method::Thesis})
    if (name == to_string(method)) return method;
  return std::nullopt;
}

void set_method_defaults(Method method, Config& config) {
  if (method != Method::Thesis) return;
  config.certificate.on_breach = "report";  // the thesis has no bounds
  config.decision.weights = planner::SharingWeights::thesis();
  config.decision.share_first = false;
  config.decision.max_sideways = std::numeric_limits<double>::infinity();
  config.decision.max_press = std::numeric_limits<double>::infinity();
  config.decision.max_lever_m = std::numeric_limits<double>::infinity();
  // a grasp beside the partner's is as good as its cost (section 5.3.4); the collision world keeps the arm
  // off the person afterwards
  config.decision.near_partner_m = 0.0;
  config.thesis.partner_reference = "object";  // section 5.3.3
  config.tracker.dwell_s = kDwell_s;
  config.tracker.let_go_s = kLetGo_s;
  config.tracker.moved_m = kMoved_m;
  config.tracker.max_hidden_s = 0.0;  // it takes what it sees in a frame for what is there (section 5.3.3)
  config.candidates = planner::thesis_candidates();
  config.candidates.step_m = kStep_m;
  config.candidates.collision.feature_margin_m = kStray_m;
  config.candidates.refine_lines = config.candidates.refine_steps = 0;  // it knows no optimum to look around
}

}  // namespace colift::control
