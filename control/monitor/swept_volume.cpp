#include "control/monitor/swept_volume.hpp"

#include <algorithm>
#include <cmath>

#include "planner/motion/collision/collision_spheres.hpp"

namespace colift::control {
namespace {

constexpr double kExcess_m = 0.03;  // coarse: a fifth of the uncertainty of a person's distance
constexpr double kStep_s = 0.25;    // of a trajectory: 6 cm of the palm at its max speed
constexpr int kMaxSteps = 24;

}  // namespace

SweptVolume::SweptVolume(const hal::RobotModel& model) : model_(model), spheres_(model.links.size()) {
  const std::vector<int> body = planner::arm_body(model);
  for (std::size_t l = 0; l < model.links.size(); ++l) {
    if (body[l] == 0) continue;  // fixed to the floor: nobody is run over by it
    for (const hal::LinkShape& shape : model.links[l].shapes)
      planner::cover_shape(shape, kExcess_m, spheres_[l]);
  }
}

void SweptVolume::add_links(const hal::JointVector& q_rad, const hal::HandPosture& hand,
                            perception::SphereSet& out) {
  hal::link_poses(model_, q_rad, hand, X_WL_);
  for (std::size_t l = 0; l < spheres_.size(); ++l)
    for (const auto& [center, radius] : spheres_[l]) out.add(X_WL_[l] * center, radius);
}

void SweptVolume::add_path(const planner::Trajectory& trajectory, double from_s, double to_s,
                           const hal::HandPosture& hand, perception::SphereSet& out) {
  const double length_s = std::abs(to_s - from_s);
  const int steps = std::clamp(static_cast<int>(std::ceil(length_s / kStep_s)), 1, kMaxSteps);
  for (int i = 0; i <= steps; ++i)
    add_links(trajectory.sample(from_s + (to_s - from_s) * i / steps).q_rad, hand, out);
}

}  // namespace colift::control
