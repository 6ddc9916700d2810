#include "tools/visualization/scene/scene_marks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tools/visualization/palette.hpp"

namespace colift::picture {
namespace {

constexpr double kSigmas = 2.0;
const TextStyle kNameText{.size = 18, .colour = kInk, .bold = true, .halo = kWhite.with_alpha(0.9)};
const TextStyle kSizeText{.size = 15, .colour = kSurface, .halo = kWhite.with_alpha(0.8)};

// ---- surfaces
// ----------------------------------------------------------------------------------------------------

bool in_sight(const CameraView& view, const perception::Rectangle& face) {
  return face.normal.dot(view.camera_W() - face.center) > 0 && !view.hidden(face.center);
}

// What lies behind something is drawn like the hidden edges of a technical drawing.
void hide(Stroke& stroke) {
  stroke.colour.a = 0.5;
  stroke.dashes = {3, 4};
}

void draw_rectangle(Canvas& canvas, const CameraView& view, const perception::Rectangle& face) {
  const Vec3 u = 0.5 * face.size.x() * face.u, v = 0.5 * face.size.y() * face.v;
  const std::array<Vec3, 4> corner{face.center - u - v, face.center + u - v, face.center + u + v,
                                   face.center - u + v};
  const bool seen = in_sight(view, face);
  Stroke side{
      .colour = kSurface.with_alpha(0.9), .width = 1.4, .halo = kWhite.with_alpha(0.45), .halo_width = 1.0};
  if (!seen) hide(side);
  view.polygon(canvas, {corner.begin(), corner.end()}, side);
  if (!seen) return;
  const Stroke mark{.colour = kSurface, .width = 3.2};
  const double arm = std::min(0.18 * std::min(face.size.x(), face.size.y()), 0.04);
  for (std::size_t i = 0; i < 4; ++i)
    for (const std::size_t next : {(i + 1) % 4, (i + 3) % 4})
      view.line(canvas, corner[i], corner[i] + arm * (corner[next] - corner[i]).normalized(), mark);
}

void draw_cylinder(Canvas& canvas, const CameraView& view, const perception::Cylinder& bar) {
  const Vec3 axis = bar.axis.normalized(), half = 0.5 * bar.length * axis;
  Stroke side{.colour = kSurface, .width = 1.8, .halo = kWhite.with_alpha(0.5), .halo_width = 1.0};
  if (view.hidden(bar.center)) hide(side);
  for (const Vec3& end : {Vec3(bar.center - half), Vec3(bar.center + half)})
    view.polygon(canvas, ring(end, axis, bar.radius), side);
  // the two generators at which the rays of the camera touch the cylinder
  Vec3 away = view.camera_W() - bar.center;
  away -= away.dot(axis) * axis;
  if (const double distance = away.norm(); distance > bar.radius) {
    const Vec3 e = away / distance, f = axis.cross(e);
    const double c = bar.radius / distance, s = std::sqrt(1 - c * c);
    for (const double sign : {-1.0, 1.0}) {
      const Vec3 edge = bar.center + bar.radius * (c * e + sign * s * f);
      view.line(canvas, edge - half, edge + half, side);
    }
  }
  const Vec3 beyond = 0.15 * half;
  view.line(canvas, bar.center - half - beyond, bar.center + half + beyond,
            {.colour = kSurface, .width = 1.4, .dashes = {14, 4, 3, 4}});
}

// Surfaces by the area they have in the picture, largest first.
std::vector<const perception::Surface*> by_size(const std::vector<perception::Surface>& surfaces) {
  const auto area = [](const perception::Surface& s) {
    if (const auto* face = std::get_if<perception::Rectangle>(&s)) return face->size.x() * face->size.y();
    const auto& bar = std::get<perception::Cylinder>(s);
    return 2 * bar.radius * bar.length;
  };
  std::vector<const perception::Surface*> order;
  for (const perception::Surface& s : surfaces) order.push_back(&s);
  std::stable_sort(order.begin(), order.end(),
                   [&](const auto* a, const auto* b) { return area(*a) > area(*b); });
  return order;
}

void label_surfaces(const CameraView& view, const perception::Scene& scene, Labels& labels) {
  constexpr std::size_t kMost = 7;
  constexpr double kMin_px = 45;
  std::size_t written = 0;
  for (const perception::Surface* s : by_size(scene.surfaces)) {
    if (written == kMost) return;
    std::string words;
    Vec3 center;
    double longest;
    if (const auto* face = std::get_if<perception::Rectangle>(s)) {
      if (!in_sight(view, *face)) continue;
      center = face->center;
      longest = face->size.maxCoeff();
      words =
          fmt::format("{} × {} cm", centimetres(face->size.maxCoeff()), centimetres(face->size.minCoeff()));
    } else {
      const auto& bar = std::get<perception::Cylinder>(*s);
      if (view.hidden(bar.center)) continue;
      center = bar.center;
      longest = bar.length;
      words = fmt::format("Ø {} × {} cm", centimetres(2 * bar.radius), centimetres(bar.length));
    }
    const auto at = view.at(center);
    if (at && longest * view.pixels_per_metre(center) > kMin_px && labels.place(*at, words, kSizeText, 8))
      ++written;
  }
}

void draw_shape(Canvas& canvas, const CameraView& view, const hal::OrientedBox& box) {
  const Stroke edge{.colour = kTargetRim.with_alpha(0.9),
                    .width = 1.3,
                    .dashes = {6, 5},
                    .halo = kWhite.with_alpha(0.25),
                    .halo_width = 0.8};
  const auto corner = [&](int i) {
    const Vec3 sign((i & 1) ? 0.5 : -0.5, (i & 2) ? 0.5 : -0.5, (i & 4) ? 0.5 : -0.5);
    return Vec3(box.center + box.axes * sign.cwiseProduct(box.size));
  };
  for (int i = 0; i < 8; ++i)
    for (const int bit : {1, 2, 4})
      if (!(i & bit)) view.line(canvas, corner(i), corner(i | bit), edge);
}

// ---- candidates
// --------------------------------------------------------------------------------------------------

void draw_candidates(Canvas& canvas, const CameraView& view,
                     const std::vector<planner::GraspCandidate>& candidates) {
  using planner::Verdict;
  const double radius = candidates.size() > 150 ? 3.2 : candidates.size() > 60 ? 4.2 : 5.2;
  const bool with_axes = candidates.size() <= 300;
  const auto draw = [&](const planner::GraspCandidate& c) {
    const auto at = view.at(c.position);
    if (!at || !view.frame().contains(*at)) return;
    const VerdictStyle& style = style_of(c.verdict);
    const bool ok = c.verdict == Verdict::Ok;
    const bool hidden = view.hidden(c.position);
    if (with_axes && !hidden) {
      const double faint = ok ? 0.95 : 0.5;
      const double half = std::clamp(0.5 * c.width, 0.012, 0.06);
      const Stroke closing{.colour = style.colour.with_alpha(faint),
                           .width = ok ? 2.2 : 1.6,
                           .halo = kWhite.with_alpha(ok ? 0.6 : 0.0),
                           .halo_width = 0.8};
      const Stroke approach{.colour = style.colour.with_alpha(faint), .width = 1.2};
      view.line(canvas, c.position - 0.045 * c.approach, c.position, approach);
      view.line(canvas, c.position - half * c.closing, c.position + half * c.closing, closing);
    }
    if (hidden)
      canvas.disc(*at, 0.45 * radius, style.colour.with_alpha(0.6));
    else
      draw_mark(canvas, *at, ok ? radius : 0.85 * radius, style.shape, style.colour);
  };
  for (const bool possible : {false, true})
    for (const planner::GraspCandidate& c : candidates)
      if (c.verdict != Verdict::Chosen && (c.verdict == Verdict::Ok) == possible) draw(c);
}

void arrow(Canvas& canvas, const CameraView& view, const Vec3& from, const Vec3& to, const Colour& colour) {
  const auto ends = view.segment(from, to);
  if (!ends) return;
  const Px along = ends->second - ends->first;
  const Stroke shaft{.colour = colour, .width = 4.0, .halo = kWhite, .halo_width = 1.6};
  canvas.line(ends->first, ends->second, shaft);
  if (along.norm() < 8) return;
  const Px e = along.normalized(), f(-e.y(), e.x());
  const Px tip = ends->second + 8 * e;
  canvas.fill({tip + 3 * e, ends->second - 4 * e + 9 * f, ends->second - 4 * e - 9 * f}, kWhite);
  canvas.fill({tip, ends->second - 2 * e + 6.5 * f, ends->second - 2 * e - 6.5 * f}, colour);
}

void draw_gripper(Canvas& canvas, const CameraView& view, const planner::GraspCandidate& c,
                  const ScenePicture& what) {
  const Vec3 z = c.approach.normalized(), y = c.closing.normalized(), x = y.cross(z);
  const Vec3 palm = c.position - what.palm_gap_m * z;
  const double half = 0.5 * what.hand_opening_m;
  const double finger = what.palm_gap_m + 0.05;
  const Stroke limb{.colour = kInk, .width = 5.0, .halo = kWhite, .halo_width = 1.8};
  const std::vector<Vec3> outline{palm + half * y + finger * z, palm + half * y, palm - half * y,
                                  palm - half * y + finger * z};
  std::vector<Px> points;
  for (const Vec3& p : outline)
    if (const auto at = view.at(p)) points.push_back(*at);
  view.line(canvas, palm - 0.08 * z, palm, limb);
  if (points.size() == outline.size()) canvas.polyline(points, false, limb);
  view.line(canvas, palm - 0.08 * z, palm, {.colour = kInk, .width = 5.0});
  if (const auto at = view.at(c.position)) draw_mark(canvas, *at, 7.5, MarkShape::Disc, kRobot);
  // the axis that points away from the camera is drawn first
  struct Axis {
    Vec3 direction;
    Colour colour;
  };
  std::array<Axis, 3> axes{{{x, kAxisX}, {y, kAxisY}, {z, kAxisZ}}};
  const Vec3 to_camera = view.camera_W() - palm;
  std::stable_sort(axes.begin(), axes.end(), [&](const Axis& a, const Axis& b) {
    return a.direction.dot(to_camera) < b.direction.dot(to_camera);
  });
  const double length = 0.5 * what.hand_opening_m;
  for (const Axis& axis : axes) arrow(canvas, view, palm, palm + 0.75 * length * axis.direction, axis.colour);
}

// ---- load sharing
// ------------------------------------------------------------------------------------------------

void draw_uncertainty(Canvas& canvas, const CameraView& view, const Vec3& p,
                      const Eigen::Matrix3d& covariance, const Colour& colour) {
  const auto at = view.at(p);
  const auto spread = view.spread(p, covariance);
  if (!at || !spread || !(spread->trace() > 1e-6)) return;
  canvas.ellipse(*at, ellipse_of(*spread, kSigmas), colour.with_alpha(0.28),
                 {.colour = colour, .width = 2.0, .halo = kWhite.with_alpha(0.7), .halo_width = 1.2});
}

void draw_plumb_line(Canvas& canvas, const CameraView& view, const Vec3& p, const hal::Plane& ground) {
  const Vec3 foot = ground.foot(p);
  const Stroke line{.colour = kInk.with_alpha(0.85),
                    .width = 1.6,
                    .dashes = {3, 4},
                    .halo = kWhite.with_alpha(0.6),
                    .halo_width = 1.0};
  view.line(canvas, p, foot, line);
  const double radius = std::clamp(0.05 * std::abs(ground.height(p)), 0.006, 0.025);
  view.polygon(
      canvas, ring(foot, ground.normal, radius),
      {.colour = kInk.with_alpha(0.85), .width = 1.6, .halo = kWhite.with_alpha(0.6), .halo_width = 1.0});
}

}  // namespace

const planner::GraspCandidate* chosen_of(const ScenePicture& what) {
  if (!what.candidates) return nullptr;
  for (const planner::GraspCandidate& c : *what.candidates)
    if (c.verdict == planner::Verdict::Chosen) return &c;
  return nullptr;
}

const perception::Target* target_of(const ScenePicture& what) {
  return what.scene && what.scene->target ? &*what.scene->target : nullptr;
}

Vec3 up_of(const ScenePicture& what) {
  if (what.scene && what.scene->ground) return what.scene->ground->plane.normal;
  return what.cloud ? Vec3(-what.cloud->X_WC.linear().col(1)) : Vec3::UnitZ();
}

void draw_marks(Canvas& canvas, const CameraView& view, const ScenePicture& what) {
  const Canvas::Clip inside(canvas, view.frame());
  Labels labels(canvas, view.frame().grown(-4));
  const perception::Target* target = target_of(what);
  const planner::GraspCandidate* chosen = chosen_of(what);
  constexpr double kBall = 10.0;

  if (target && (target->shape.size - target->obb.size).norm() > 0.005)
    draw_shape(canvas, view, target->shape);
  if (what.scene)
    for (const perception::Surface& surface : what.scene->surfaces) {
      if (const auto* face = std::get_if<perception::Rectangle>(&surface))
        draw_rectangle(canvas, view, *face);
      else
        draw_cylinder(canvas, view, std::get<perception::Cylinder>(surface));
    }
  if (what.candidates) draw_candidates(canvas, view, *what.candidates);

  if (target && what.scene->ground) draw_plumb_line(canvas, view, target->cog, what.scene->ground->plane);
  if (target && what.partner) {
    const Stroke lever{
        .colour = kInk, .width = 2.0, .dashes = {9, 6}, .halo = kWhite.with_alpha(0.75), .halo_width = 1.4};
    view.line(canvas, what.partner->position, target->cog, lever);
    if (what.optimum) view.line(canvas, target->cog, *what.optimum, lever);
  }
  if (chosen) draw_gripper(canvas, view, *chosen, what);
  const auto keep_ball = [&](const Px& at) { labels.keep_clear(Box{at.x(), at.y(), 0, 0}.grown(kBall + 4)); };
  if (target) {
    draw_uncertainty(canvas, view, target->cog, target->cog_covariance, kCog);
    if (const auto at = view.at(target->cog)) draw_ball(canvas, *at, kBall, kCog), keep_ball(*at);
  }
  if (what.partner) {
    draw_uncertainty(canvas, view, what.partner->position, what.partner->covariance, kPartner);
    if (const auto at = view.at(what.partner->position))
      draw_ball(canvas, *at, kBall, kPartner), keep_ball(*at);
  }
  if (what.optimum)
    if (const auto at = view.at(*what.optimum)) draw_optimum(canvas, *at, 9), keep_ball(*at);

  const auto name = [&](const Vec3& p, const std::string& words, const Colour& colour) {
    TextStyle style = kNameText;
    style.colour = colour;
    if (const auto at = view.at(p); at && view.frame().contains(*at))
      labels.place(*at, words, style, 18, true);
  };
  if (chosen) {
    // words stay off the sketched hand
    const Vec3 z = chosen->approach.normalized(), y = chosen->closing.normalized();
    const Vec3 palm = chosen->position - what.palm_gap_m * z;
    for (const double side : {-1.0, -0.5, 0.0, 0.5, 1.0})
      for (const double ahead : {0.0, 0.5, 1.0}) {
        if (std::abs(side) < 1.0 && ahead > 0.0) continue;
        const auto at =
            view.at(palm + 0.5 * what.hand_opening_m * side * y + (what.palm_gap_m + 0.05) * ahead * z);
        if (at) keep_ball(*at);
      }
    if (const auto at = view.at(chosen->position)) keep_ball(*at);
    for (const Vec3& tip : {Vec3(y.cross(z)), z})
      if (const auto at = view.at(palm + 0.4 * what.hand_opening_m * tip)) keep_ball(*at);
    const std::string share = what.share ? fmt::format(", {:.0f} %", 100 * *what.share) : "";
    name(chosen->position - (what.palm_gap_m + 0.08) * chosen->approach.normalized(),
         fmt::format("robot #{}{}", chosen->id, share), kRobot.towards(kInk, 0.45));
  }
  if (what.partner) name(what.partner->position, "partner", kPartner.towards(kInk, 0.25));
  if (target) name(target->cog, "centre of gravity", rgb(0x8A4B00));
  if (what.candidates && what.candidates->size() <= 400)
    for (const planner::GraspCandidate& c : *what.candidates)
      if (const auto at = view.at(c.position); at && !view.hidden(c.position))
        labels.keep_clear(Box{at->x(), at->y(), 0, 0}.grown(4));
  if (what.scene) label_surfaces(view, *what.scene, labels);
}

}  // namespace colift::picture
