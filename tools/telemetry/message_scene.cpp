// The scene as Foxglove's entities.

#include <fmt/format.h>

#include "tools/telemetry/json_parts.hpp"
#include "tools/telemetry/messages.hpp"

namespace colift::telemetry {
namespace {

struct Colour {
  double r = 0.0, g = 0.0, b = 0.0, a = 1.0;
};

Json colour(const Colour& c) {
  return {{"r", c.r}, {"g", c.g}, {"b", c.b}, {"a", c.a}};
}

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

hal::Pose pose_of(const hal::Vec3& at, const Eigen::Matrix3d& axes = Eigen::Matrix3d::Identity()) {
  hal::Pose pose = hal::Pose::Identity();
  pose.translation() = at;
  pose.linear() = axes;
  return pose;
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

Json solid(const hal::Pose& pose, const hal::Vec3& size, const Colour& c) {
  return {{"pose", pose_json(pose)}, {"size", xyz(size)}, {"color", colour(c)}};
}

/// Entities of one message.
class Entities {
 public:
  explicit Entities(hal::Timestamp at) : time_(time_json(at)) {}

  Json& add(const std::string& id, Json metadata = Json::array()) {
    all_.push_back({{"timestamp", time_},
                    {"frame_id", kWorldFrame},
                    {"id", id},
                    {"lifetime", {{"sec", 0}, {"nsec", 0}}},
                    {"frame_locked", false},
                    {"metadata", std::move(metadata)},
                    {"arrows", Json::array()},
                    {"cubes", Json::array()},
                    {"spheres", Json::array()},
                    {"cylinders", Json::array()},
                    {"lines", Json::array()},
                    {"triangles", Json::array()},
                    {"texts", Json::array()},
                    {"models", Json::array()}});
    return all_.back();
  }
  [[nodiscard]] Json take(hal::Timestamp at) {
    // what is no longer there goes first
    Json gone = Json::array({{{"timestamp", time_json(at)}, {"type", 1}, {"id", ""}}});
    return {{"deletions", std::move(gone)}, {"entities", std::move(all_)}};
  }

 private:
  Json time_, all_ = Json::array();
};

Json pair(const char* key, std::string value) {
  return {{"key", key}, {"value", std::move(value)}};
}

void add_surface(Entities& out, std::size_t i, const perception::Surface& surface) {
  constexpr Colour kFace{0.95, 0.9, 0.25, 0.35};
  Json& entity = out.add(fmt::format("surface {}", i));
  if (const auto* r = std::get_if<perception::Rectangle>(&surface)) {
    Eigen::Matrix3d axes;
    axes << r->u, r->v, r->normal;
    entity["cubes"].push_back(solid(pose_of(r->center, axes), {r->size.x(), r->size.y(), 0.002}, kFace));
  } else {
    const auto& c = std::get<perception::Cylinder>(surface);
    Json j = solid(pose_of(c.center, with_z(c.axis)), {2 * c.radius, 2 * c.radius, c.length}, kFace);
    j["bottom_scale"] = 1.0;
    j["top_scale"] = 1.0;
    entity["cylinders"].push_back(std::move(j));
  }
}

void add_candidate(Entities& out, const planner::GraspCandidate& c) {
  constexpr double kLength = 0.06;
  const bool chosen = c.verdict == planner::Verdict::Chosen;
  Json& entity = out.add(
      fmt::format("candidate {}", c.id),
      Json::array({pair("verdict", verdict_word(c.verdict)), pair("because", c.because),
                   pair("kind", planner::name_of(c.kind)), pair("width_m", fmt::format("{:.4f}", c.width))}));
  const double length = chosen ? 2.0 * kLength : kLength;
  entity["arrows"].push_back(
      {{"pose", pose_json(pose_of(c.position - length * c.approach, with_x(c.approach)))},
       {"shaft_length", 0.75 * length},
       {"shaft_diameter", chosen ? 0.012 : 0.006},
       {"head_length", 0.25 * length},
       {"head_diameter", chosen ? 0.024 : 0.012},
       {"color", colour(colour_of(c.verdict))}});
}

void add_way(Entities& out, const std::vector<hal::Vec3>& way) {
  Json points = Json::array();
  for (const hal::Vec3& p : way) points.push_back(xyz(p));
  out.add("way")["lines"].push_back({{"type", 0},
                                     {"pose", pose_json(hal::Pose::Identity())},
                                     {"thickness", 2.0},
                                     {"scale_invariant", true},
                                     {"points", std::move(points)},
                                     {"color", colour({0.0, 0.62, 0.45, 0.8})},
                                     {"colors", Json::array()},
                                     {"indices", Json::array()}});
}

}  // namespace

SceneView scene_view(const control::Look& look) {
  SceneView view;
  view.ground = look.scene.ground;
  if (const auto& target = look.scene.target) {
    view.target_center = target->obb.center;
    view.cog = target->cog;
    view.target = target->obb;
    view.shape = target->shape;
  }
  view.surfaces = look.scene.surfaces;
  view.candidates = look.candidates;
  return view;
}

std::string scene_message(hal::Timestamp at, const SceneView& s) {
  Entities out(at);
  if (s.ground) {
    const hal::Vec3 middle = s.ground->plane.foot(s.target_center);
    out.add("ground")["cubes"].push_back(
        solid(pose_of(middle, with_z(s.ground->plane.normal)), {3.0, 3.0, 0.001}, {0.6, 0.6, 0.6, 0.25}));
  }
  if (s.target)
    out.add("target")["cubes"].push_back(
        solid(pose_of(s.target->center, s.target->axes), s.target->size, {0.9, 0.62, 0.0, 0.25}));
  if (s.shape)
    out.add("shape")["cubes"].push_back(
        solid(pose_of(s.shape->center, s.shape->axes), s.shape->size, {0.9, 0.62, 0.0, 0.1}));
  if (s.target)
    out.add("cog")["spheres"].push_back(
        solid(pose_of(s.cog), hal::Vec3::Constant(0.03), {0.0, 0.0, 0.0, 1.0}));
  for (std::size_t i = 0; i < s.surfaces.size(); ++i) add_surface(out, i, s.surfaces[i]);
  for (const planner::GraspCandidate& c : s.candidates) add_candidate(out, c);
  if (s.partner) {
    // two standard deviations, and never too small to be seen
    const hal::Vec3 sigma = s.partner->covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
    out.add("partner")["spheres"].push_back(solid(pose_of(s.partner->position),
                                                  (4.0 * sigma).cwiseMax(hal::Vec3::Constant(0.02)),
                                                  {0.8, 0.2, 0.6, 0.6}));
  }
  if (s.optimum)
    out.add("optimum")["spheres"].push_back(
        solid(pose_of(*s.optimum), hal::Vec3::Constant(0.02), {0.0, 0.62, 0.45, 0.5}));
  if (!s.way_W.empty()) add_way(out, s.way_W);
  return dumped(out.take(at));
}

}  // namespace colift::telemetry
