#include "planner/grasp/task_choice.hpp"
#include "hal/types/units.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace colift::planner {
namespace {

constexpr double kMinimumJerkPeak = 5.773503;  // 10/sqrt(3): peak acceleration times t^2 / d

bool possible(const GraspCandidate& c) {
  return c.verdict == Verdict::Ok || c.verdict == Verdict::Chosen;
}

}  // namespace

Task lift_task(const Vec3& up, double peak_m_s2) {
  Task task(3);
  task[0].acceleration_m_s2 = peak_m_s2 * up;
  task[2].acceleration_m_s2 = -peak_m_s2 * up;
  return task;
}

Task lower_task(const Vec3& up, double peak_m_s2) {
  return lift_task(up, -peak_m_s2);
}

Task tilt_task(const Vec3& axis, double angle_rad, int steps) {
  Task task;
  for (int i = 1; i <= steps; ++i) {
    TaskPose pose;
    pose.R = Eigen::AngleAxisd(angle_rad * i / steps, axis.normalized()).toRotationMatrix();
    task.push_back(pose);
  }
  return task;
}

Task yaw_task(const Vec3& up, double peak_rad_s2) {
  Task task(2);
  task[0].turning_rad_s2 = peak_rad_s2 * up;
  task[1].turning_rad_s2 = -peak_rad_s2 * up;
  return task;
}

Task carry_task(std::span<const Vec3> way_points, double seconds) {
  Task task;
  for (std::size_t i = 1; i < way_points.size(); ++i) {
    const Vec3 peak = kMinimumJerkPeak / (seconds * seconds) * (way_points[i] - way_points[i - 1]);
    TaskPose pose;
    pose.acceleration_m_s2 = peak;
    task.push_back(pose);
    pose.acceleration_m_s2 = -peak;
    task.push_back(pose);
  }
  return task;
}

std::vector<Wrench> task_wrenches(const Task& task, const CarriedBody& body, const Vec3& up) {
  std::vector<Wrench> out;
  out.reserve(task.size());
  for (const TaskPose& pose : task) {
    const double scale = std::sqrt(pose.weight);
    const Vec3 force = body.mass_kg * (hal::kGravity_m_s2 * up + pose.acceleration_m_s2);
    const Eigen::Matrix3d to_object = pose.R.transpose();
    out.push_back({scale * (to_object * force), scale * (body.inertia * (to_object * pose.turning_rad_s2))});
  }
  return out;
}

hal::Result<TaskChoice> choose_for_task(std::span<const GraspCandidate> candidates, const Vec3& partner,
                                        const Vec3& cog, const Vec3& up, const Task& task,
                                        const CarriedBody& body, const SharingWeights& weights) {
  if (task.empty()) return hal::failure(hal::ErrorCode::BadInput, "task", "has no pose");
  const auto sharing = LoadSharing::create(weights);
  if (!sharing) return tl::unexpected(sharing.error());
  const std::vector<Wrench> wrenches = task_wrenches(task, body, up);
  TaskChoice choice;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const GraspCandidate& c = candidates[i];
    choice.costs.push_back(sharing->cost(partner - cog, load_point(c) - cog, wrenches));
    if (!possible(c)) continue;
    if (!choice.best || choice.costs[i] < choice.costs[*choice.best]) choice.best = i;
  }
  return choice;
}

hal::Result<TaskChoice> choose_beside(std::span<const GraspCandidate> candidates,
                                      std::span<const CarryingAgent> others, CarryingAgent robot,
                                      const Vec3& cog, std::span<const Wrench> tasks, double near_m) {
  if (tasks.empty()) return hal::failure(hal::ErrorCode::BadInput, "task", "has no pose");
  std::vector<CarryingAgent> all(others.begin(), others.end());
  robot.position.setZero();
  all.push_back(robot);
  auto agents = SeveralAgents::create(std::move(all));
  if (!agents) return tl::unexpected(agents.error());
  TaskChoice choice;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Vec3 place = load_point(candidates[i]) - cog;
    agents->move(others.size(), place);
    choice.costs.push_back(agents->cost(tasks));
    const bool near = std::any_of(others.begin(), others.end(), [&](const CarryingAgent& a) {
      return (a.position - place).norm() < near_m;
    });
    if (near || !possible(candidates[i])) continue;
    if (!choice.best || choice.costs[i] < choice.costs[*choice.best]) choice.best = i;
  }
  return choice;
}

}  // namespace colift::planner
