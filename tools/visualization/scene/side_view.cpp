#include "tools/visualization/scene/side_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/types/units.hpp"
#include "tools/visualization/labels.hpp"
#include "tools/visualization/palette.hpp"

namespace colift::picture {
namespace {

constexpr double kHeading = 44, kFoot = 40, kBetween = 16;
constexpr double kTallest = 0.9;  // of a panel, by its width

struct Extent {
  double left = 1e9, right = -1e9, low = 1e9, high = -1e9;

  void take(double x, double z) {
    left = std::min(left, x);
    right = std::max(right, x);
    low = std::min(low, z);
    high = std::max(high, z);
  }
  [[nodiscard]] bool empty() const { return left > right; }
};

// How far a solid reaches from its middle along a unit direction.
double reach(const Solid& solid, const Vec3& along) {
  const Vec3 d = solid.X_WS.linear().transpose() * along;
  switch (solid.kind) {
    case Solid::Kind::Box:
      return 0.5 * d.cwiseAbs().dot(solid.size);
    case Solid::Kind::Cylinder:
      return solid.size.x() * std::hypot(d.x(), d.y()) + 0.5 * solid.size.y() * std::abs(d.z());
    case Solid::Kind::Capsule:
      return solid.size.x() + 0.5 * solid.size.y() * std::abs(d.z());
    case Solid::Kind::Sphere:
      return solid.size.x();
    case Solid::Kind::HalfSpace:
      return 0.0;
  }
  return 0.0;
}

Extent extent(const SolidScene& scene, SolidRole role, const Vec3& across) {
  Extent e;
  for (const Solid& solid : scene.solids) {
    if (solid.role != role || !solid.X_WS.matrix().allFinite()) continue;
    const Vec3 p = solid.X_WS.translation();
    const double x = across.dot(p), half = reach(solid, across), up = reach(solid, Vec3::UnitZ());
    e.take(x - half, p.z() - up);
    e.take(x + half, p.z() + up);
  }
  return e;
}

struct Frame {
  Vec3 across, ahead;               // across the picture to the right, and into it
  double left, low, metres, scale;  // of the picture (m, px/m)
};

// Looks so that the partner is at one end of the picture and the robot at the other one.
Frame frame_of(const SideView& what, double width, double height) {
  Frame f;
  Vec3 line = what.partner - what.robot;
  line.z() = 0;
  f.across = line.norm() > 0.05 ? line.normalized() : Vec3::UnitY();
  f.ahead = Vec3::UnitZ().cross(f.across);
  if (what.seen_from && f.ahead.dot(*what.seen_from - 0.5 * (what.partner + what.robot)) > 0) {
    f.across = -f.across;
    f.ahead = -f.ahead;
  }
  Extent e = extent(what.before, SolidRole::Target, f.across);
  for (const SolidScene* scene : {&what.before, &what.lifted})
    for (const SolidRole role : {SolidRole::Target, SolidRole::Hand}) {
      const Extent other = extent(*scene, role, f.across);
      if (other.empty()) continue;
      e.take(other.left, other.low);
      e.take(other.right, other.high);
    }
  for (const Vec3& p : {what.partner, what.robot})
    if (p.allFinite()) e.take(f.across.dot(p), p.z());
  if (e.empty()) e = {-0.5, 0.5, 0, 1};
  e.low = std::min(e.low, 0.0);
  // some of the arm and of the person at either end, head-room for the words
  e.left -= 0.22;
  e.right += 0.22;
  e.high += 0.16;
  e.low -= 0.05;
  f.scale = std::min(width / (e.right - e.left), height / (e.high - e.low));
  f.left = 0.5 * (e.left + e.right) - 0.5 * width / f.scale;
  f.low = e.low;
  f.metres = e.high - e.low;
  return f;
}

// What stands between the eye and the object would hide it.
SolidScene without_what_hides(const SolidScene& scene, const Frame& f) {
  double object = 1e9;
  for (const Solid& s : scene.solids)
    if (s.role == SolidRole::Target)
      object = std::min(object, f.ahead.dot(s.X_WS.translation()) - reach(s, f.ahead));
  SolidScene out = scene;
  std::erase_if(out.solids, [&](const Solid& s) {
    const bool thing = s.role == SolidRole::Clutter || s.role == SolidRole::Wall;
    return s.role == SolidRole::Wall || (thing && f.ahead.dot(s.X_WS.translation()) < object);
  });
  return out;
}

void draw_panel(Canvas& canvas, const Box& area, const Frame& f, const SolidScene& scene) {
  SolidView view;
  view.width = static_cast<int>(area.width);
  view.height = static_cast<int>(area.height);
  view.height_m = f.metres;
  const double x = f.left + 0.5 * area.width / f.scale, z = f.low + 0.5 * f.metres;
  view.target = x * f.across + z * Vec3::UnitZ();
  view.eye = view.target - 5.0 * f.ahead;
  canvas.image(static_cast<int>(area.x), static_cast<int>(area.y), view.width, view.height,
               cast_solids(without_what_hides(scene, f), view));
}

void dimension(Canvas& canvas, const Px& low, const Px& high, const std::string& words, Labels& labels) {
  const Stroke line{.colour = kInk, .width = 1.8, .halo = kPaper, .halo_width = 1.4};
  canvas.line(low, high, line);
  const double way = high.y() < low.y() ? 1 : -1;
  for (const auto& [end, sign] : {std::pair(low, -way), std::pair(high, way)}) {
    canvas.line(end, end + Px(-4, 7 * sign), line);
    canvas.line(end, end + Px(4, 7 * sign), line);
  }
  labels.place(low + Px(0, 26 * way), words, {.size = 18, .colour = kInk, .bold = true, .halo = kPaper}, 4,
               true);
}

}  // namespace

Canvas draw_side_view(const SideView& what) {
  const double width = 0.5 * (what.width - kBetween);
  const Frame f = frame_of(what, width, kTallest * width);
  const double height = std::floor(f.metres * f.scale);
  Canvas canvas(what.width, static_cast<int>(kHeading + height + kFoot), kPaper);
  const Box left{0, kHeading, std::floor(width), height},
      right{what.width - std::floor(width), kHeading, std::floor(width), height};
  draw_panel(canvas, left, f, what.before);
  draw_panel(canvas, right, f, what.lifted);

  for (const Box& area : {left, right}) {
    const double floor = area.bottom() + f.low * f.scale;
    canvas.fill(Box{area.x, floor, area.width, area.bottom() - floor}, rgb(0xE6EAED));
    canvas.line({area.x, floor}, {area.right(), floor}, {.colour = kSoftInk, .width = 1.6});
    canvas.outline(area, {.colour = kRule, .width = 1.2}, 4);
  }
  const auto at = [&](const Box& area, double across, double z) {
    return Px(area.x + (across - f.left) * f.scale, area.bottom() - (z - f.low) * f.scale);
  };
  const TextStyle heading{.size = 20, .colour = kInk, .bold = true};
  canvas.text({left.x + 10, 28}, "Before the lift", heading);
  canvas.text({right.x + 10, 28}, "At the top", heading);
  const Extent before = extent(what.before, SolidRole::Target, f.across),
               lifted = extent(what.lifted, SolidRole::Target, f.across);
  Labels labels(canvas, right.grown(-4));
  if (!before.empty() && !lifted.empty()) {
    // the object's top before, in both pictures
    const Stroke level{.colour = kInk.with_alpha(0.75),
                       .width = 1.5,
                       .dashes = {7, 5},
                       .halo = kPaper.with_alpha(0.7),
                       .halo_width = 1.2};
    for (const Box& area : {left, right})
      canvas.line({area.x + 8, at(area, 0, before.high).y()},
                  {area.right() - 8, at(area, 0, before.high).y()}, level);
    const double across = before.left + 0.5 * (before.right - before.left);
    if (what.height_m)
      dimension(canvas, at(right, across, before.high), at(right, across, before.high + *what.height_m),
                fmt::format("lifted {}", length_text(*what.height_m)), labels);
  }
  const auto share = [&](const Vec3& grasp, const char* who, double part, const Colour& colour) {
    const double rise = what.height_m.value_or(0.0);
    const Px p = at(right, f.across.dot(grasp), grasp.z() + rise);
    labels.place(p - Px(0, 34), fmt::format("{} {:.0f} %", who, 100 * part),
                 {.size = 18,
                  .colour = colour.towards(kInk, 0.3),
                  .bold = true,
                  .align = Align::Middle,
                  .halo = kPaper},
                 8, true);
  };
  if (what.share && std::isfinite(*what.share)) {
    share(what.partner, "partner", 1 - *what.share, kPartner);
    share(what.robot, "robot", *what.share, kRobot);
  }
  const std::string tilt = what.tilt_rad && std::isfinite(*what.tilt_rad)
                               ? fmt::format("   tilted {:.1f}°", hal::rad_to_deg(*what.tilt_rad))
                               : "";
  canvas.text({left.x + 10, kHeading + height + 26},
              "both to the same scale, seen across the line between both grasps",
              {.size = 15, .colour = kSoftInk});
  canvas.text({right.right() - 10, 28}, tilt, {.size = 18, .colour = kInk, .align = Align::Right});
  return canvas;
}

}  // namespace colift::picture
