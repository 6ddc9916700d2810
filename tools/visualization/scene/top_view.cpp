#include "tools/visualization/scene/top_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tools/visualization/labels.hpp"
#include "tools/visualization/palette.hpp"
#include "tools/visualization/scene/frame_raster.hpp"
#include "tools/visualization/scene/scene_marks.hpp"

namespace colift::picture {
namespace {

constexpr double kSigmas = 2.0;

// Metres on the ground to pixels: the camera's right is right, away from the camera is up.
class GroundMap {
 public:
  GroundMap(const ScenePicture& what, const Box& area) : area_(area) {
    const Vec3 up = up_of(what);
    Vec3 ahead = what.cloud ? Vec3(what.cloud->X_WC.linear().col(2)) : Vec3::UnitX();
    ahead -= ahead.dot(up) * up;
    // a camera that looks straight down has its image's top ahead
    if (ahead.norm() < 0.1 && what.cloud) {
      ahead = -what.cloud->X_WC.linear().col(1);
      ahead -= ahead.dot(up) * up;
    }
    ahead_ = ahead.norm() > 1e-6 ? ahead.normalized() : hal::tangents(up).first;
    right_ = ahead_.cross(up);
    axes_.row(0) = right_.transpose();
    axes_.row(1) = ahead_.transpose();
  }

  [[nodiscard]] Px metres(const Vec3& p) const { return {right_.dot(p), ahead_.dot(p)}; }
  [[nodiscard]] Px at(const Vec3& p) const { return on(metres(p)); }
  [[nodiscard]] Px on(const Px& m) const {
    const Px d = scale_ * (m - middle_);
    return area_.center() + Px(d.x(), -d.y());
  }
  [[nodiscard]] Eigen::Matrix2d spread(const Eigen::Matrix3d& covariance) const {
    Eigen::Matrix<double, 2, 3> j = scale_ * axes_;
    j.row(1) *= -1;
    return j * covariance * j.transpose();
  }
  [[nodiscard]] double scale() const { return scale_; }

  // Chooses scale and middle so that all of the points are inside, `margin_px` off the rim.
  void fit(const std::vector<Vec3>& points, double margin_px) {
    Px low(1e9, 1e9), high(-1e9, -1e9);
    for (const Vec3& p : points) {
      low = low.cwiseMin(metres(p));
      high = high.cwiseMax(metres(p));
    }
    middle_ = 0.5 * (low + high);
    const Px size = (high - low).cwiseMax(0.05);
    scale_ = std::min((area_.width - 2 * margin_px) / size.x(), (area_.height - 2 * margin_px) / size.y());
  }

 private:
  Box area_;
  Vec3 ahead_, right_;
  Eigen::Matrix<double, 2, 3> axes_;
  Px middle_ = Px::Zero();
  double scale_ = 100.0;
};

std::vector<Vec3> base_of(const hal::OrientedBox& box) {
  std::vector<Vec3> corners;
  for (const auto& [x, y] :
       std::array<std::array<double, 2>, 4>{{{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}})
    corners.push_back(box.center + box.axes * Vec3(x * box.size.x(), y * box.size.y(), 0));
  return corners;
}

bool finite(const Vec3& p) {
  return p.allFinite();
}

std::vector<Vec3> all_points(const ScenePicture& what) {
  std::vector<Vec3> points;
  if (const perception::Target* target = target_of(what)) {
    for (const hal::OrientedBox* box : {&target->obb, &target->shape})
      for (const Vec3& p : base_of(*box)) points.push_back(p);
    points.push_back(target->cog);
  }
  if (what.partner) points.push_back(what.partner->position);
  if (const planner::GraspCandidate* c = chosen_of(what)) points.push_back(c->position - 0.11 * c->approach);
  if (what.candidates)
    for (const planner::GraspCandidate& c : *what.candidates) points.push_back(c.position);
  std::erase_if(points, [](const Vec3& p) { return !finite(p); });
  return points;
}

void draw_grid(Canvas& canvas, const Box& area, const GroundMap& map, double step_m) {
  const double step = step_m * map.scale();
  if (step < 6) return;
  const Px origin = map.on(Px(0, 0));
  const Stroke line{.colour = rgb(0xE3EAED), .width = 1.0};
  for (double x = area.x + std::fmod(std::fmod(origin.x() - area.x, step) + step, step); x < area.right();
       x += step)
    canvas.line({x, area.y}, {x, area.bottom()}, line);
  for (double y = area.y + std::fmod(std::fmod(origin.y() - area.y, step) + step, step); y < area.bottom();
       y += step)
    canvas.line({area.x, y}, {area.right(), y}, line);
}

// 1, 2 or 5 times a power of ten that takes about a quarter of the width.
double round_length(double metres) {
  const double decade = std::pow(10.0, std::floor(std::log10(metres)));
  for (const double factor : {5.0, 2.0})
    if (factor * decade <= metres) return factor * decade;
  return decade;
}

void draw_scale_bar(Canvas& canvas, const Box& area, double pixels_per_metre, Labels& labels) {
  const double metres = round_length(0.28 * area.width / pixels_per_metre);
  const double length = metres * pixels_per_metre;
  const Px left(area.x + 14, area.bottom() - 16), right = left + Px(length, 0);
  const Stroke bar{.colour = kInk, .width = 2.4};
  canvas.line(left, right, bar);
  for (const Px& end : {left, right}) canvas.line(end - Px(0, 5), end + Px(0, 5), bar);
  const std::string words =
      metres < 0.995 ? fmt::format("{:g} cm", 100 * metres) : fmt::format("{:g} m", metres);
  canvas.text((left + right) / 2 - Px(0, 9), words,
              {.size = 15, .colour = kInk, .align = Align::Middle, .halo = kWhite});
  labels.keep_clear(Box{left.x(), left.y() - 28, std::max(length, 60.0), 36});
}

void draw_camera(Canvas& canvas, const Box& area, const GroundMap& map, const ScenePicture& what,
                 Labels& labels) {
  if (!what.cloud) return;
  // at its place if that is in view, else on the rim in its direction
  const Px place = map.at(what.cloud->X_WC.translation());
  const double x = std::clamp(place.x(), area.x + 0.5 * area.width, area.right() - 60);
  const Px at = area.contains(place) && place.y() < area.bottom() - 20 ? place : Px(x, area.bottom() - 18);
  canvas.fill({at + Px(0, 2), at + Px(-11, -14), at + Px(11, -14)}, kSoftInk.with_alpha(0.35));
  canvas.fill(Box{at.x() - 9, at.y() - 2, 18, 11}, kSoftInk, 2);
  canvas.text(at + Px(16, 8), "camera", {.size = 14, .colour = kSoftInk, .halo = kWhite});
  labels.keep_clear(Box{at.x() - 14, at.y() - 16, 90, 28});
}

void draw_footprint(Canvas& canvas, const GroundMap& map, const perception::Target& target) {
  std::vector<Px> rim;
  for (const Vec3& p : base_of(target.obb)) rim.push_back(map.at(p));
  canvas.fill(rim, kTarget.with_alpha(0.22));
  constexpr std::size_t kMostDots = 4000;
  const std::size_t every = target.points.size() / kMostDots + 1;
  for (std::size_t i = 0; i < target.points.size(); i += every) {
    const Px at = map.at(target.points[i].cast<double>());
    canvas.fill(Box{at.x() - 1, at.y() - 1, 2, 2}, kTarget.towards(kTargetRim, 0.3).with_alpha(0.6));
  }
  canvas.polyline(rim, true, {.colour = kTargetRim, .width = 1.6});
  if ((target.shape.size - target.obb.size).norm() > 0.005) {
    std::vector<Px> completed;
    for (const Vec3& p : base_of(target.shape)) completed.push_back(map.at(p));
    canvas.polyline(completed, true, {.colour = kTargetRim, .width = 1.4, .dashes = {6, 5}});
  }
}

void draw_ball_with_spread(Canvas& canvas, const GroundMap& map, const Vec3& p,
                           const Eigen::Matrix3d& covariance, const Colour& colour) {
  const Eigen::Matrix2d spread = map.spread(covariance);
  if (spread.allFinite() && spread.trace() > 1e-6)
    canvas.ellipse(map.at(p), ellipse_of(spread, kSigmas), colour.with_alpha(0.25),
                   {.colour = colour, .width = 1.6});
  draw_ball(canvas, map.at(p), 8, colour);
}

void draw_hand(Canvas& canvas, const GroundMap& map, const planner::GraspCandidate& c,
               const ScenePicture& what) {
  const Vec3 palm = c.position - what.palm_gap_m * c.approach, half = 0.5 * what.hand_opening_m * c.closing;
  const Vec3 reach = (what.palm_gap_m + 0.05) * c.approach;
  const Stroke limb{.colour = kInk, .width = 3.4, .halo = kWhite, .halo_width = 1.4};
  canvas.line(map.at(palm - 0.08 * c.approach), map.at(palm), limb);
  canvas.polyline(
      {map.at(palm + half + reach), map.at(palm + half), map.at(palm - half), map.at(palm - half + reach)},
      false, limb);
  draw_mark(canvas, map.at(c.position), 7, MarkShape::Disc, kRobot);
}

// Line between both grasps with the foot of the centre of gravity on it: its two parts are the levers.
void draw_levers(Canvas& canvas, const GroundMap& map, const Vec3& partner, const Vec3& robot,
                 const Vec3& cog, Labels& labels) {
  const Px a = map.metres(partner), b = map.metres(robot), g = map.metres(cog);
  const Px ab = b - a;
  const double length = ab.norm();
  if (length < 0.02) return;
  const double t = (g - a).dot(ab) / (length * length);
  const Px foot = a + t * ab, e = ab / length;
  canvas.line(map.on(a), map.on(b),
              {.colour = kInk, .width = 2.4, .halo = kWhite.with_alpha(0.8), .halo_width = 1.4});
  if ((g - foot).norm() * map.scale() > 4)
    canvas.line(map.on(g), map.on(foot),
                {.colour = kInk, .width = 1.4, .dashes = {3, 3}, .halo = kWhite, .halo_width = 1.0});
  const Px tick = 6.0 / map.scale() * Px(-e.y(), e.x());
  canvas.line(map.on(Px(foot + tick)), map.on(Px(foot - tick)), {.colour = kInk, .width = 2.0});
  if (t <= 0.02 || t >= 0.98) return;
  labels.place(map.on(Px(0.5 * (a + foot))), length_text(t * length),
               {.size = 16, .colour = kPartner, .bold = true, .halo = kWhite}, 8, true);
  labels.place(map.on(Px(0.5 * (foot + b))), length_text((1 - t) * length),
               {.size = 16, .colour = kRobot.towards(kInk, 0.3), .bold = true, .halo = kWhite}, 8, true);
}

void draw_optimum_line(Canvas& canvas, const Box& area, const GroundMap& map, const ScenePicture& what,
                       const Vec3& cog) {
  const Stroke dashed{
      .colour = kInk, .width = 1.6, .dashes = {7, 5}, .halo = kWhite.with_alpha(0.8), .halo_width = 1.2};
  canvas.line(map.at(what.partner->position), map.at(cog), dashed);
  if (!what.optimum || !finite(*what.optimum)) return;
  canvas.line(map.at(cog), map.at(*what.optimum), dashed);
  if (area.contains(map.at(*what.optimum))) draw_optimum(canvas, map.at(*what.optimum), 8);
}

}  // namespace

bool has_top_view(const ScenePicture& what) {
  return !all_points(what).empty();
}

void draw_top_view(Canvas& canvas, const Box& area, const ScenePicture& what) {
  const Canvas::Clip inside(canvas, area);
  canvas.fill(area, kPaper, 6);
  std::vector<Vec3> points = all_points(what);
  if (points.empty()) {
    canvas.text(area.center(), "nothing to see from above",
                {.size = 16, .colour = kSoftInk, .align = Align::Middle});
    return;
  }
  GroundMap map(what, area);
  const double margin = 0.11 * std::min(area.width, area.height) + 10;
  map.fit(points, margin);
  if (what.optimum && finite(*what.optimum)) {
    // a far optimum shall not make the rest small
    const double before = map.scale();
    points.push_back(*what.optimum);
    map.fit(points, margin);
    if (map.scale() < 0.6 * before) {
      points.pop_back();
      map.fit(points, margin);
    }
  }
  Labels labels(canvas, area.grown(-4));
  const double height = what.scene && what.scene->ground && what.cloud
                            ? what.scene->ground->plane.height(what.cloud->X_WC.translation())
                            : 1.0;
  draw_grid(canvas, area, map, grid_step_m(height));
  const perception::Target* target = target_of(what);
  if (target) draw_footprint(canvas, map, *target);
  draw_camera(canvas, area, map, what, labels);
  draw_scale_bar(canvas, area, map.scale(), labels);
  if (what.candidates) {
    const double radius = what.candidates->size() > 100 ? 2.8 : 4.0;
    for (const bool possible : {false, true})
      for (const planner::GraspCandidate& c : *what.candidates)
        if (finite(c.position) && c.verdict != planner::Verdict::Chosen &&
            (c.verdict == planner::Verdict::Ok) == possible)
          draw_mark(canvas, map.at(c.position), possible ? radius : 0.8 * radius, style_of(c.verdict).shape,
                    style_of(c.verdict).colour);
  }
  const planner::GraspCandidate* chosen = chosen_of(what);
  if (target && what.partner) draw_optimum_line(canvas, area, map, what, target->cog);
  if (chosen) draw_hand(canvas, map, *chosen, what);
  const auto keep = [&](const Vec3& p) {
    labels.keep_clear(Box{map.at(p).x(), map.at(p).y(), 0, 0}.grown(11));
  };
  if (chosen) keep(chosen->position);
  if (target) keep(target->cog);
  if (what.partner) keep(what.partner->position);
  if (target && what.partner && chosen)
    draw_levers(canvas, map, what.partner->position, chosen->position, target->cog, labels);
  if (chosen) draw_mark(canvas, map.at(chosen->position), 7, MarkShape::Disc, kRobot);
  if (target) draw_ball_with_spread(canvas, map, target->cog, target->cog_covariance, kCog);
  if (what.partner)
    draw_ball_with_spread(canvas, map, what.partner->position, what.partner->covariance, kPartner);
}

hal::Result<> write_top_view(const std::filesystem::path& png, const ScenePicture& what, int side_px) {
  Canvas canvas(side_px, side_px, kPaper);
  draw_top_view(canvas, {0, 0, static_cast<double>(side_px), static_cast<double>(side_px)}, what);
  return canvas.write_png(png);
}

}  // namespace colift::picture
