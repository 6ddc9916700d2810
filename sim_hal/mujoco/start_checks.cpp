#include "sim_hal/mujoco/start_checks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace colift::sim_hal {
namespace {

constexpr double kDeepest_m = 0.004;  // what may stand in each other at the start
constexpr double kGraspOff_m = 0.03;  // how far a partner's grasp may lie off the surface

tl::unexpected<hal::Error> bad(std::string where, std::string detail) {
  return hal::failure(hal::ErrorCode::BadConfig, std::move(where), std::move(detail));
}

// Of a point from the nearest part (m); negative inside.
double distance_to(const ObjectParts& object, const Vec3& p_T) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const ObjectParts::Part& part : object.parts) nearest = std::min(nearest, distance(part.shape, p_T));
  return nearest;
}

}  // namespace

bool on_surface(const ObjectParts& object, const Vec3& p_T) {
  return std::abs(distance_to(object, p_T)) <= kGraspOff_m;
}

hal::Result<> check_grasps(const ScenarioPartner& partner, const ObjectParts& object) {
  if (partner.kind == "none") return {};
  const auto check = [&](const Vec3& grasp_T, const std::string& where) -> hal::Result<> {
    const double off = distance_to(object, grasp_T);
    if (std::abs(off) <= kGraspOff_m) return {};
    return bad(where, fmt::format("[{:.3f}, {:.3f}, {:.3f}] lies {:.3f} m {} the object; expected a point on "
                                  "its surface (object frame)",
                                  grasp_T.x(), grasp_T.y(), grasp_T.z(), std::abs(off),
                                  off > 0.0 ? "away from" : "inside"));
  };
  if (auto done = check(partner.grasp, "partner.grasp"); !done) return done;
  for (std::size_t i = 0; i < partner.events.size(); ++i) {
    if (!partner.events[i].to) continue;
    if (auto done = check(*partner.events[i].to, fmt::format("partner.events[{}].to", i)); !done) return done;
  }
  return {};
}

hal::Result<> check_overlap(const Overlap& overlap) {
  if (overlap.object_static_m > kDeepest_m)
    return bad("object.pose", fmt::format("the object starts {:.3f} m inside the floor or the clutter",
                                          overlap.object_static_m));
  if (overlap.robot_object_m > kDeepest_m)
    return bad("object.pose",
               fmt::format("the object starts {:.3f} m inside the robot", overlap.robot_object_m));
  if (overlap.robot_static_m > kDeepest_m)
    return bad("clutter", fmt::format("the robot starts {:.3f} m inside the floor or the clutter",
                                      overlap.robot_static_m));
  return {};
}

}  // namespace colift::sim_hal
