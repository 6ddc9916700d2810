#include "tools/experiments/trials/furniture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "hal/types/units.hpp"
#include "sim_hal/scenario/random_scenario.hpp"
#include "sim_hal/synthetic/hash_random.hpp"

namespace colift::experiments {
namespace {

using hal::Vec3;
using sim_hal::Draws;
using sim_hal::Scenario;

constexpr double kArrives_s = 1.7;
constexpr double kMin_kg = 0.02;  // of a part
constexpr double kLight_kg = 2.0, kHeavy_kg = 5.0;
// beside it: from beyond, a partner close behind a short object would hide it
constexpr double kCameraLeast_m = -0.4, kCameraMost_m = 0.2;

/// Collects the bodies of one object in its frame T.
class Bodies {
 public:
  Bodies(Scenario& s, Draws& draws) : s_(s), draws_(draws) {}

  void box(const Vec3& center, const Vec3& size, const Vec3& rpy_deg = Vec3::Zero()) {
    add("box", {size.x(), size.y(), size.z()}, center, rpy_deg, size.prod());
  }

  void tube(const Vec3& from, const Vec3& to, double radius) {
    const Vec3 along = to - from;
    const double length = along.norm();
    // a cylinder's axis is z: first leaned about y, then turned about z
    const double lean = std::atan2(std::hypot(along.x(), along.y()), along.z());
    const double turn = std::atan2(along.y(), along.x());
    add("cylinder", {radius, length}, 0.5 * (from + to), {0.0, hal::rad_to_deg(lean), hal::rad_to_deg(turn)},
        M_PI * radius * radius * length);
  }

  void disc(const Vec3& center, double radius, double thickness, const Vec3& rpy_deg) {
    add("cylinder", {radius, thickness}, center, rpy_deg, M_PI * radius * radius * thickness);
  }

 private:
  void add(const char* shape, std::vector<double> size, const Vec3& center, const Vec3& rpy_deg,
           double volume) {
    sim_hal::ScenarioPart part;
    part.shape = shape;
    part.size = std::move(size);
    part.xyz = center;
    part.rpy_deg = rpy_deg;
    part.mass = volume * draws_.between(0.8, 1.25);  // of equal density but for this; scaled in the end
    s_.object.parts.push_back(std::move(part));
  }

  Scenario& s_;
  Draws& draws_;
};

// Each maker adds the bodies, says where the partner takes hold (T), and returns length, width and height.

Vec3 make_stool(Scenario& s, Draws& d) {
  Bodies b(s, d);
  const double side = d.between(0.30, 0.40), height = d.between(0.45, 0.65), top = d.between(0.02, 0.03);
  const double leg = d.between(0.03, 0.04), at = 0.5 * side - 0.5 * leg - 0.01;
  if (d.chance(0.5))
    b.box({0, 0, height - 0.5 * top}, {side, side, top});
  else
    b.disc({0, 0, height - 0.5 * top}, 0.55 * side, top, Vec3::Zero());
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0})
      b.box({x * at, y * at, 0.5 * (height - top)}, {leg, leg, height - top});
  const double rung = 0.3 * height;
  for (const double y : {-1.0, 1.0}) b.box({0, y * at, rung}, {2.0 * at - leg, 0.02, 0.025});
  for (const double x : {-1.0, 1.0}) b.box({x * at, 0, rung + 0.05}, {0.02, 2.0 * at - leg, 0.025});
  s.partner.grasp = {0.5 * side, d.between(-0.2, 0.2) * side, height - 0.5 * top};
  return {side, side, height};
}

Vec3 make_shelf(Scenario& s, Draws& d) {
  Bodies b(s, d);
  const double length = d.between(0.55, 0.80), depth = d.between(0.24, 0.32), height = d.between(0.60, 0.90);
  const double board = d.between(0.016, 0.022);
  for (const double x : {-1.0, 1.0})
    b.box({x * 0.5 * (length - board), 0, 0.5 * height}, {board, depth, height});
  const int boards = d.chance(0.5) ? 3 : 4;
  for (int i = 0; i < boards; ++i) {
    const double z = 0.06 + (height - 0.06 - 0.5 * board) * i / (boards - 1);
    b.box({0, 0, z}, {length - 2.0 * board, depth, board});
  }
  if (d.chance(0.5))
    b.box({0, 0.5 * depth - 0.004, 0.5 * height}, {length - 2.0 * board, 0.008, height - 0.08});
  s.partner.grasp = {0.5 * (length - board), d.between(-0.3, 0.3) * depth, height};
  return {length, depth, height};
}

Vec3 make_ladder(Scenario& s, Draws& d) {
  Bodies b(s, d);
  const double thick = d.between(0.024, 0.03), deep = d.between(0.06, 0.08), wide = d.between(0.34, 0.42);
  if (d.chance(0.5)) {  // on its edge
    const double length = d.between(0.9, 1.4);
    for (const double z : {0.5 * thick, wide - 0.5 * thick}) b.box({0, 0, z}, {length, deep, thick});
    const int rungs = static_cast<int>(length / 0.28);
    for (int i = 0; i < rungs; ++i)
      b.box({(i + 0.5) / rungs * length - 0.5 * length, 0, 0.5 * wide}, {0.03, 0.03, wide - 2.0 * thick});
    s.partner.grasp = {0.5 * length - 0.05, 0.0, wide};
    return {length, deep, wide};
  }
  const double height = d.between(0.75, 1.0), foot = 0.28 * height;  // open, it stands on four feet
  const double lean = std::atan2(foot, height);
  const double rail = (height - 0.5 * deep * std::sin(lean)) / std::cos(lean);  // on its lower corner
  for (const double y : {-1.0, 1.0})
    for (const double x : {-1.0, 1.0})
      b.box({x * 0.5 * foot, y * 0.5 * (wide - thick), 0.5 * height}, {0.5 * deep, thick, rail},
            {0, -x * hal::rad_to_deg(lean), 0});
  const int rungs = 3;
  for (int i = 1; i <= rungs; ++i) {
    const double z = height * i / (rungs + 1.0);
    b.box({-foot * (1.0 - z / height), 0, z}, {0.07, wide - 2.0 * thick, 0.025});
  }
  b.box({foot * 0.4, 0, 0.6 * height}, {0.02, wide - 2.0 * thick, 0.03});
  b.box({0, 0, height}, {0.14, wide, 0.03});
  s.partner.grasp = {0.07, d.between(-0.2, 0.2) * wide, height + 0.015};
  return {2.0 * foot, wide, height + 0.015};
}

Vec3 make_crate(Scenario& s, Draws& d) {
  Bodies b(s, d);
  const double length = d.between(0.50, 0.80), width = d.between(0.30, 0.45), height = d.between(0.22, 0.35);
  const double wall = d.between(0.012, 0.02);
  b.box({0, 0, 0.5 * wall}, {length, width, wall});
  for (const double x : {-1.0, 1.0})
    b.box({x * 0.5 * (length - wall), 0, 0.5 * (height + wall)}, {wall, width, height - wall});
  for (const double y : {-1.0, 1.0})
    b.box({0, y * 0.5 * (width - wall), 0.5 * (height + wall)}, {length - 2.0 * wall, wall, height - wall});
  s.partner.grasp = {0.5 * length, d.between(-0.3, 0.3) * width, height};
  return {length, width, height};
}

void add_handle(Bodies& b, const Vec3& center, const Vec3& along, const Vec3& out, double span) {
  constexpr double kBar_m = 0.022, kStands_m = 0.045;
  const Vec3 across = along.cross(out);
  const auto extent = [&](double l, double o) -> Vec3 {
    return (l * along + kBar_m * across + o * out).cwiseAbs();
  };
  b.box(center + kStands_m * out, extent(span, 0.018));
  for (const double end : {-1.0, 1.0})
    b.box(center + 0.5 * kStands_m * out + end * 0.5 * (span - 0.02) * along, extent(0.02, kStands_m));
}

Vec3 make_suitcase(Scenario& s, Draws& d) {
  Bodies b(s, d);
  const double length = d.between(0.60, 0.80), width = d.between(0.20, 0.28), height = d.between(0.42, 0.52);
  b.box({0, 0, 0.5 * height}, {length, width, height});
  add_handle(b, {0, 0, height}, Vec3::UnitX(), Vec3::UnitZ(), d.between(0.15, 0.19));
  const double span = d.between(0.15, 0.19), z = d.between(0.5, 0.75) * height;
  add_handle(b, {-0.5 * length, 0, z}, Vec3::UnitZ(), -Vec3::UnitX(), span);
  add_handle(b, {0.5 * length, 0, z}, Vec3::UnitZ(), Vec3::UnitX(), span);
  s.partner.grasp = {0.5 * length + 0.054, 0.0, z};
  return {length + 0.11, width, height + 0.06};
}

Vec3 make_box_with_lid(Scenario& s, Draws& d) {
  Bodies b(s, d);
  const double length = d.between(0.55, 0.85), width = d.between(0.11, 0.15), height = d.between(0.22, 0.34);
  const double lid = d.between(0.03, 0.05), over = d.between(0.004, 0.012);
  b.box({0, 0, 0.5 * (height - lid)}, {length, width, height - lid});
  b.box({0, 0, height - 0.5 * lid}, {length + 2.0 * over, width + 2.0 * over, lid});
  s.partner.grasp = {0.5 * length + over, d.between(-0.2, 0.2) * width, height - 0.5 * lid};
  return {length + 2.0 * over, width + 2.0 * over, height};
}

Vec3 make_bench(Scenario& s, Draws& d) {
  Bodies b(s, d);
  const double length = d.between(0.9, 1.3), width = d.between(0.25, 0.34), height = d.between(0.40, 0.48);
  const double top = d.between(0.025, 0.035), at = 0.5 * length - d.between(0.12, 0.2);
  b.box({0, 0, height - 0.5 * top}, {length, width, top});
  for (const double x : {-1.0, 1.0})
    b.box({x * at, 0, 0.5 * (height - top)}, {0.03, 0.85 * width, height - top});
  b.box({0, 0, 0.4 * height}, {2.0 * at - 0.03, 0.025, 0.06});
  s.partner.grasp = {0.5 * length, d.between(-0.3, 0.3) * width, height - 0.5 * top};
  return {length, width, height};
}

Vec3 make_frame(Scenario& s, Draws& d) {
  Bodies b(s, d);
  const double base = d.between(0.9, 1.05), hub = d.between(0.28, 0.33), tube = d.between(0.014, 0.018);
  const Vec3 rear(-0.5 * base, 0, hub), front(0.5 * base, 0, hub), crank(-0.08, 0, hub - 0.05);
  const Vec3 seat(-0.20, 0, hub + 0.42), head(0.33, 0, hub + 0.40);
  b.tube(seat + Vec3(0, 0, -0.02), head + Vec3(0, 0, -0.04), tube);
  b.tube(crank, head + Vec3(0, 0, -0.10), tube);
  b.tube(crank, seat + Vec3(-0.02, 0, 0.08), tube);
  b.tube(rear, crank, 0.8 * tube);
  b.tube(rear, seat + Vec3(0, 0, -0.04), 0.8 * tube);
  b.tube(front, head, tube);
  b.tube(head + Vec3(0, -0.26, 0.02), head + Vec3(0, 0.26, 0.02), 0.9 * tube);
  b.box(seat + Vec3(-0.03, 0, 0.10), {0.24, 0.12, 0.05});
  for (const Vec3& at : {rear, front}) {  // a stand under each axle instead of a wheel
    b.tube({at.x(), 0, 0.02}, at, tube);
    b.box({at.x(), 0, 0.01}, {0.06, 0.34, 0.02});
  }
  s.partner.grasp = {0.33, 0.0, hub + 0.42 + 0.9 * tube};
  return {base + 0.06, 0.52, hub + 0.56};
}

// what hand and arm bear half of, as tables and chairs of the other experiments
void set_mass(sim_hal::ScenarioObject& object, double mass_kg) {
  double sum = 0.0;
  for (const sim_hal::ScenarioPart& part : object.parts) sum += part.mass;
  object.mass = 0.0;
  for (sim_hal::ScenarioPart& part : object.parts) {
    part.mass = std::max(kMin_kg, part.mass / sum * mass_kg);
    object.mass += part.mass;
  }
}

// a shelf that shows its back alone has nothing to grasp: it stands the other way round
void open_towards_camera(Scenario& s) {
  const double turn = hal::deg_to_rad(s.object.yaw_deg);
  const Vec3 to_camera = s.camera.xyz - s.object.xyz;
  if (std::cos(turn) * to_camera.y() - std::sin(turn) * to_camera.x() < 0.0) return;
  for (sim_hal::ScenarioPart& part : s.object.parts) part.xyz.y() *= -1.0;
}

// a suitcase stands across the view, as far as that leaves its end towards the robot: both handles are seen
void turn_across_view(Scenario& s, double length_m, double bearing) {
  constexpr double kMost_rad = 0.6;
  const double yaw = hal::deg_to_rad(s.object.yaw_deg);
  const Vec3 near_end = s.object.xyz - 0.5 * length_m * Vec3(std::cos(yaw), std::sin(yaw), 0.0);
  const Vec3 view = s.object.xyz - s.camera.xyz;
  double across = std::atan2(view.y(), view.x()) + 0.5 * std::numbers::pi;
  while (across - bearing > 0.5 * std::numbers::pi) across -= std::numbers::pi;
  while (across - bearing < -0.5 * std::numbers::pi) across += std::numbers::pi;
  const double turned = bearing + std::clamp(across - bearing, -kMost_rad, kMost_rad);
  s.object.xyz = near_end + 0.5 * length_m * Vec3(std::cos(turned), std::sin(turned), 0.0);
  s.object.yaw_deg = hal::rad_to_deg(turned);
}

using Maker = Vec3 (*)(Scenario&, Draws&);
struct Kind {
  const char* name;
  Maker make;
  double near_m, far_m;  // distance of its near end from the robot's axis
};
constexpr std::array<Kind, 8> kKinds{{{"stool", make_stool, 0.66, 0.78},
                                      {"shelf", make_shelf, 0.46, 0.58},
                                      {"ladder", make_ladder, 0.50, 0.65},
                                      {"crate", make_crate, 0.48, 0.62},
                                      {"suitcase", make_suitcase, 0.72, 0.84},
                                      {"lidded-box", make_box_with_lid, 0.50, 0.65},
                                      {"bench", make_bench, 0.65, 0.80},
                                      {"frame", make_frame, 0.38, 0.50}}};

}  // namespace

const std::vector<std::string>& furniture_kinds() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out;
    for (const Kind& kind : kKinds) out.emplace_back(kind.name);
    return out;
  }();
  return names;
}

Scenario furniture_layout(int index, std::uint64_t seed) {
  Draws draws(sim_hal::hash(seed, 7800, static_cast<std::uint64_t>(index)), 7800);
  const Kind& kind = kKinds[static_cast<std::size_t>(index) % kKinds.size()];
  Scenario s;
  s.name = fmt::format("{} {}", kind.name, index / static_cast<int>(kKinds.size()));
  s.object.kind = "bodies";
  const Vec3 size = kind.make(s, draws);
  set_mass(s.object, draws.between(kLight_kg, kHeavy_kg));
  s.object.friction = draws.between(0.6, 0.9);
  const double bearing = draws.between(-0.25, 0.25), yaw = bearing + draws.between(-0.3, 0.3);
  const double away = draws.between(kind.near_m, kind.far_m) + 0.5 * size.x() * std::cos(yaw - bearing);
  s.object.xyz = {away * std::cos(bearing), away * std::sin(bearing), 0.0};
  s.object.yaw_deg = hal::rad_to_deg(yaw);
  s.partner.kind = "compliant";
  s.partner.arrives_s = kArrives_s;
  s.object.size = {size.x(), size.y(), size.z()};
  sim_hal::draw_camera(s, draws, kCameraLeast_m, kCameraMost_m);
  s.object.size.clear();  // the parts have sizes
  if (kind.make == &make_shelf) open_towards_camera(s);
  if (kind.make == &make_suitcase) turn_across_view(s, size.x(), bearing);
  return s;
}

}  // namespace colift::experiments
