// The scene as Foxglove's entities.

#include <fmt/format.h>

#include "planner/verdict_word.hpp"
#include "tools/telemetry/channels/scene_parts.hpp"

namespace colift::telemetry {
namespace {

/// By verdict, told apart by people who see few colours too (Okabe and Ito).
Colour colour_of(planner::Verdict verdict) {
  using planner::Verdict;
  switch (verdict) {
    case Verdict::Chosen:
      return {0.0, 0.62, 0.45};
    case Verdict::Ok:
      return {0.34, 0.71, 0.91};
    case Verdict::Collision:
      return {0.84, 0.37, 0.0};
    case Verdict::Unreachable:
      return {0.5, 0.5, 0.5};
    case Verdict::TooWide:
      return {0.8, 0.47, 0.65};
    case Verdict::Unstable:
      return {0.94, 0.89, 0.26};
    case Verdict::OverLimit:
      return {0.9, 0.62, 0.0};
    case Verdict::NearPartner:
      return {0.0, 0.45, 0.7};
  }
  return {};
}

/// Axes whose third, or first, is a direction.
Eigen::Matrix3d with_z(const hal::Vec3& z) {
  const auto [u, v] = hal::tangents(z);
  Eigen::Matrix3d m;
  m << u, v, z;
  return m;
}
Eigen::Matrix3d with_x(const hal::Vec3& x) {
  const auto [u, v] = hal::tangents(x);
  Eigen::Matrix3d m;
  m << x, u, v;
  return m;
}

void add_surface(Entities& out, std::size_t i, const perception::Surface& surface) {
  constexpr Colour kFace{0.95, 0.9, 0.25, 0.35};
  Json& entity = out.add(fmt::format("surface {}", i));
  if (const auto* r = std::get_if<perception::Rectangle>(&surface)) {
    Eigen::Matrix3d axes;
    axes << r->u, r->v, r->normal;
    entity["cubes"].push_back(solid_json(pose_of(r->center, axes), {r->size.x(), r->size.y(), 0.002}, kFace));
  } else {
    const auto& c = std::get<perception::Cylinder>(surface);
    entity["cylinders"].push_back(
        cylinder_json(pose_of(c.center, with_z(c.axis)), c.radius, c.length, kFace));
  }
}

void add_candidate(Entities& out, const planner::GraspCandidate& c) {
  constexpr double kLength = 0.06;
  const bool chosen = c.verdict == planner::Verdict::Chosen;
  Json& entity =
      out.add(fmt::format("candidate {}", c.id),
              Json::array({pair_json("verdict", planner::verdict_word(c.verdict)),
                           pair_json("because", c.reason), pair_json("kind", planner::name_of(c.kind)),
                           pair_json("width_m", fmt::format("{:.4f}", c.width))}));
  const double length = chosen ? 2.0 * kLength : kLength;
  entity["arrows"].push_back(arrow_json(pose_of(c.position - length * c.approach, with_x(c.approach)), length,
                                        chosen ? 0.012 : 0.006, colour_of(c.verdict)));
}

void add_path(Entities& out, const std::vector<hal::Vec3>& path_W) {
  Json points = Json::array();
  for (const hal::Vec3& p : path_W) points.push_back(xyz(p));
  out.add("path")["lines"].push_back({{"type", 0},
                                      {"pose", pose_json(hal::Pose::Identity())},
                                      {"thickness", 2.0},
                                      {"scale_invariant", true},
                                      {"points", std::move(points)},
                                      {"color", colour_json({0.0, 0.62, 0.45, 0.8})},
                                      {"colors", Json::array()},
                                      {"indices", Json::array()}});
}

/// The open hand at the grasp, and its frame H: x red, y (closing) green, z (approach) blue.
void add_gripper(Entities& out, const GripperView& gripper) {
  constexpr Colour kHand{0.0, 0.62, 0.45, 0.4};
  constexpr Colour kAxes[] = {{0.85, 0.2, 0.2}, {0.2, 0.7, 0.2}, {0.25, 0.4, 0.95}};
  Json& entity = out.add("gripper");
  for (const hal::LinkShape& s : gripper.hand_W) {
    using Kind = hal::LinkShape::Kind;
    if (s.kind == Kind::Box) entity["cubes"].push_back(solid_json(s.X_LS, s.size, kHand));
    if (s.kind == Kind::Cylinder)
      entity["cylinders"].push_back(cylinder_json(s.X_LS, s.size[0], s.size[1], kHand));
    if (s.kind == Kind::Sphere)
      entity["spheres"].push_back(solid_json(s.X_LS, hal::Vec3::Constant(2.0 * s.size[0]), kHand));
  }
  for (int i = 0; i < 3; ++i)
    entity["arrows"].push_back(arrow_json(
        pose_of(gripper.X_WH.translation(), with_x(gripper.X_WH.linear().col(i))), 0.12, 0.008, kAxes[i]));
}

}  // namespace

GripperView gripper_view(const hal::RobotModel& model, const hal::Pose& X_WH) {
  GripperView view;
  view.X_WH = X_WH;
  // wherever the arm is: only the hand's links are taken, against the palm
  std::vector<hal::Pose> X_WL;
  hal::link_poses(model, hal::JointVector::Zero(), {}, X_WL);
  const hal::Pose to_grasp = X_WH * X_WL[static_cast<std::size_t>(model.palm)].inverse();
  for (std::size_t l = 0; l < model.links.size(); ++l) {
    if (!model.in_hand(static_cast<int>(l))) continue;
    for (hal::LinkShape shape : model.links[l].shapes) {
      shape.X_LS = to_grasp * X_WL[l] * shape.X_LS;
      view.hand_W.push_back(shape);
    }
  }
  return view;
}

SceneView scene_view(const control::SceneAnalysis& analysis) {
  SceneView view;
  view.ground = analysis.scene.ground;
  if (const auto& target = analysis.scene.target) {
    view.target_center = target->obb.center;
    view.cog = target->cog;
    view.target = target->obb;
    view.shape = target->shape;
  }
  view.surfaces = analysis.scene.surfaces;
  view.candidates = analysis.candidates;
  return view;
}

std::string scene_message(hal::Timestamp at, const SceneView& s) {
  Entities out(at);
  if (s.ground) {
    const hal::Vec3 middle = s.ground->plane.foot(s.target_center);
    out.add("ground")["cubes"].push_back(solid_json(pose_of(middle, with_z(s.ground->plane.normal)),
                                                    {3.0, 3.0, 0.001}, {0.6, 0.6, 0.6, 0.25}));
  }
  if (s.target)
    out.add("target")["cubes"].push_back(
        solid_json(pose_of(s.target->center, s.target->axes), s.target->size, {0.9, 0.62, 0.0, 0.25}));
  if (s.shape)
    out.add("shape")["cubes"].push_back(
        solid_json(pose_of(s.shape->center, s.shape->axes), s.shape->size, {0.9, 0.62, 0.0, 0.1}));
  if (s.target)
    out.add("cog")["spheres"].push_back(
        solid_json(pose_of(s.cog), hal::Vec3::Constant(0.03), {0.0, 0.0, 0.0, 1.0}));
  for (std::size_t i = 0; i < s.surfaces.size(); ++i) add_surface(out, i, s.surfaces[i]);
  for (const planner::GraspCandidate& c : s.candidates) add_candidate(out, c);
  if (s.partner) {
    // two standard deviations, and never too small to be seen
    const hal::Vec3 sigma = s.partner->covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
    out.add("partner")["spheres"].push_back(solid_json(pose_of(s.partner->position),
                                                       (4.0 * sigma).cwiseMax(hal::Vec3::Constant(0.02)),
                                                       {0.8, 0.2, 0.6, 0.6}));
  }
  if (s.optimum)
    out.add("optimum")["spheres"].push_back(
        solid_json(pose_of(*s.optimum), hal::Vec3::Constant(0.02), {0.0, 0.62, 0.45, 0.5}));
  if (s.gripper) add_gripper(out, *s.gripper);
  if (!s.path_W.empty()) add_path(out, s.path_W);
  return dumped(out.take());
}

}  // namespace colift::telemetry
