#pragma once

#include <optional>
#include <span>
#include <vector>

#include "hal/types/result.hpp"
#include "planner/grasp_candidate.hpp"
#include "planner/load_sharing/load_sharing.hpp"
#include "planner/load_sharing/several_agents.hpp"

namespace colift::planner {

/// One pose of a task (thesis 4.2) and what moves the object there: the object turned by R from how it stands
/// now, with accelerations of the centre of gravity.
struct TaskPose {
  Eigen::Matrix3d R =
      Eigen::Matrix3d::Identity();        ///< Turns vectors of the object now into those of the pose.
  Vec3 acceleration_m_s2 = Vec3::Zero();  ///< In W, without gravity.
  Vec3 turning_rad_s2 = Vec3::Zero();     ///< Angular acceleration in W.
  double weight = 1.0;                    ///< How much of the task it is, as in seconds.
};
using Task = std::vector<TaskPose>;

// Parts of a task, to be put one after the other. `up` is opposite to gravity.
[[nodiscard]] Task lift_task(const Vec3& up, double peak_m_s2 = 0.2);
[[nodiscard]] Task lower_task(const Vec3& up, double peak_m_s2 = 0.2);
/// Turns by `angle_rad` about a level axis, in steps, as when a table goes through a door on its side.
[[nodiscard]] Task tilt_task(const Vec3& axis, double angle_rad, int steps = 4);
/// Turns about the vertical: speeds up, then slows down, with the same peak.
[[nodiscard]] Task yaw_task(const Vec3& up, double peak_rad_s2);
/// From way point to way point along straight lines, `seconds` for each with a minimum-jerk profile's peak
/// acceleration of 5.77 d/t^2 at both ends (Flash and Hogan 1985).
[[nodiscard]] Task carry_task(std::span<const Vec3> way_points, double seconds);

/// Mass and inertia (about the centre of gravity, axes W as the object stands now; kg m^2).
struct CarriedBody {
  double mass_kg = 1.0;
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
};

/// What both agents together have to exert in each pose, in axes that turn with the object, so that grasp
/// points keep their positions: one wrench per pose, scaled by the root of its weight so that costs are
/// weighted.
[[nodiscard]] std::vector<Wrench> task_wrenches(const Task& task, const CarriedBody& body, const Vec3& up);

/// The choice for a whole task.
struct TaskChoice {
  std::optional<std::size_t> best;  ///< Index into the candidates; unset where none is possible.
  std::vector<double> costs;        ///< Eq. 4.6, one per candidate, possible or not.
};

/// The candidate among those that are Ok or Chosen whose cost summed over the poses is smallest (eq. 4.8).
/// Positions in W. Errors: BadInput (weights, an empty task).
[[nodiscard]] hal::Result<TaskChoice> choose_for_task(std::span<const GraspCandidate> candidates,
                                                      const Vec3& partner, const Vec3& cog, const Vec3& up,
                                                      const Task& task, const CarriedBody& body,
                                                      const SharingWeights& weights);

/// The same beside any number of others, whose positions are relative to `cog`: the robot takes the place
/// among them where all together need least. `robot` says its prices, not its place. Candidates within
/// `near_m` of one of the others are left out. Errors: BadInput (prices, no task).
[[nodiscard]] hal::Result<TaskChoice> choose_beside(std::span<const GraspCandidate> candidates,
                                                    std::span<const CarryingAgent> others,
                                                    CarryingAgent robot, const Vec3& cog,
                                                    std::span<const Wrench> tasks, double near_m);

}  // namespace colift::planner
