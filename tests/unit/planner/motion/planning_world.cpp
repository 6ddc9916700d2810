#include "planning_world.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "perception/organised_cloud.hpp"
#include "sim_hal/synthetic/kinect/kinect_noise.hpp"
#include "sim_hal/synthetic/ray_caster.hpp"

namespace colift::tests {
namespace {

using hal::Pose;
using hal::Vec3;

constexpr double kHalfTurn = std::numbers::pi;

Vec3 in_table(const TableAt& table, double x, double y, double z) {
  const double c = std::cos(table.yaw_rad), s = std::sin(table.yaw_rad);
  return {table.x + c * x - s * y, table.y + s * x + c * y, z};
}

/// Points on the surface and inside of a link's shape, in the shape's frame.
std::vector<Vec3> probes(const hal::LinkShape& shape) {
  std::vector<Vec3> out;
  constexpr int kSteps = 4;
  for (int i = -kSteps; i <= kSteps; ++i) {
    const double a = static_cast<double>(i) / kSteps;
    switch (shape.kind) {
      case hal::LinkShape::Kind::Box:
        for (int j = -kSteps; j <= kSteps; ++j) {
          for (int k = -kSteps; k <= kSteps; ++k) {
            out.push_back(0.5 * shape.size.cwiseProduct(Vec3(a, static_cast<double>(j) / kSteps,
                                                             static_cast<double>(k) / kSteps)));
          }
        }
        break;
      case hal::LinkShape::Kind::Cylinder:
        for (int j = 0; j < 12; ++j) {
          const double turn = j * kHalfTurn / 6.0;
          for (const double r : {0.5, 1.0}) {
            out.emplace_back(r * shape.size.x() * std::cos(turn), r * shape.size.x() * std::sin(turn),
                             0.5 * a * shape.size.y());
          }
        }
        break;
      case hal::LinkShape::Kind::Sphere:
        for (int j = 0; j < 12; ++j) {
          const double turn = j * kHalfTurn / 6.0, r = std::sqrt(std::max(0.0, 1.0 - a * a));
          out.push_back(shape.size.x() * Vec3(r * std::cos(turn), r * std::sin(turn), a));
        }
        break;
    }
  }
  return out;
}

}  // namespace

planner::SceneConfig seen_everything() {
  planner::SceneConfig config;
  config.hidden_is_obstacle = false;
  return config;
}

PlanningWorld see_from_all_sides(const sim_hal::World& truth, const planner::SceneConfig& config) {
  PlanningWorld out{truth, perception::WorldMap(perception::WorldMapConfig{}), nullptr};
  hal::CameraIntrinsics camera;
  camera.width = 320;
  camera.height = 240;
  camera.fx = camera.fy = 240.0;
  camera.cx = 160.0;
  camera.cy = 120.0;
  std::vector<Vec3> target;
  const Vec3 middle(0.6, 0.0, 0.35);
  for (int i = 0; i < 8; ++i) {
    // high and low in turn: the low ones look under what stands on legs
    const double turn = i * kHalfTurn / 4.0 + 0.2;
    const Vec3 eye = middle + Vec3(1.7 * std::cos(turn), 1.7 * std::sin(turn), i % 2 == 0 ? 1.1 : -0.2);
    const sim_hal::Rendering image = sim_hal::cast_rays(truth, camera, sim_hal::look_at(eye, middle));
    const auto cloud = perception::deproject(sim_hal::measure_ideal(image), image.X_WC);
    std::vector<std::uint32_t> not_scene;
    for (std::uint32_t pixel = 0; pixel < cloud.size(); ++pixel) {
      if (!cloud.seen(pixel) || image.label[pixel] != sim_hal::Label::Target) continue;
      not_scene.push_back(pixel);
      target.push_back(cloud.point(pixel));
    }
    out.map.insert(cloud, not_scene);
  }
  out.map.set_target(target);
  out.scene = std::make_shared<const planner::CollisionScene>(
      planner::make_collision_scene(out.map, hal::Plane{Vec3::UnitZ(), 0.0}, {}, config));
  return out;
}

hal::JointVector home_rad() {
  hal::JointVector q;
  q << 0.0, 0.8, 0.0, 1.9, 0.0, -0.4, 0.0;
  return q;
}

void add_floor(sim_hal::World& world) {
  world.shapes.push_back(sim_hal::half_space(Vec3::Zero(), Vec3::UnitZ(), sim_hal::Label::Ground));
}

void add_table(sim_hal::World& world, const TableAt& t) {
  const double top = t.size.z(), legs = top - TableAt::kPlate;
  world.shapes.push_back(sim_hal::box(in_table(t, 0, 0, top - 0.5 * TableAt::kPlate),
                                      {t.size.x(), t.size.y(), TableAt::kPlate}, t.yaw_rad, t.label));
  for (const double sx : {-0.5, 0.5}) {
    for (const double sy : {-0.5, 0.5}) {
      const double inset = TableAt::kLeg;
      world.shapes.push_back(
          sim_hal::box(in_table(t, sx * (t.size.x() - inset), sy * (t.size.y() - inset), 0.5 * legs),
                       {TableAt::kLeg, TableAt::kLeg, legs}, t.yaw_rad, t.label));
    }
  }
}

planner::GraspCandidate grasp_at(const Vec3& position, const Vec3& approach, const Vec3& closing,
                                 double width_m) {
  planner::GraspCandidate grasp;
  grasp.position = position;
  grasp.approach = approach.normalized();
  grasp.closing = closing.normalized();
  grasp.width = width_m;
  return grasp;
}

planner::GraspCandidate plate_grasp(const TableAt& t, double side_rad, double along_m) {
  const double cx = std::cos(side_rad), sx = std::sin(side_rad);
  const double half = 0.5 * (std::abs(cx) * t.size.x() + std::abs(sx) * t.size.y());
  const double c = std::cos(side_rad + t.yaw_rad), s = std::sin(side_rad + t.yaw_rad);
  const Vec3 outward(c, s, 0.0);
  const Vec3 middle =
      in_table(t, half * cx - along_m * sx, half * sx + along_m * cx, t.size.z() - 0.5 * TableAt::kPlate);
  return grasp_at(middle, -outward, Vec3::UnitZ(), TableAt::kPlate);
}

double penetration_m(const hal::RobotModel& model, const hal::JointVector& q_rad, const sim_hal::World& world,
                     sim_hal::Label allowed) {
  std::vector<Pose> X_WL;
  hal::link_poses(model, q_rad, hal::coupled_posture(0.0), X_WL);
  double deepest = 0.0;
  for (std::size_t link = 0; link < model.links.size(); ++link) {
    // the foot stands on the floor
    if (static_cast<int>(link) < model.arm[1]) continue;
    for (const hal::LinkShape& shape : model.links[link].shapes) {
      const Pose X_WS = X_WL[link] * shape.X_LS;
      for (const Vec3& p_S : probes(shape)) {
        for (const sim_hal::Shape& solid : world.shapes) {
          if (solid.label == allowed && model.in_hand(static_cast<int>(link))) continue;
          deepest = std::max(deepest, -sim_hal::distance(solid, X_WS * p_S));
        }
      }
    }
  }
  return deepest;
}

}  // namespace colift::tests
