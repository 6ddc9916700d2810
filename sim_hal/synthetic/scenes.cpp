#include "sim_hal/synthetic/scenes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/types/units.hpp"
#include "sim_hal/synthetic/scene_objects.hpp"

namespace colift::sim_hal {
namespace {

constexpr double kClear_m = 0.15;  // clutter stands clear of the object and of other clutter by this

/// Area that is seen of each of two kinds of surface, square to the rays (m^2).
struct SeenArea {
  std::size_t target_pixels = 0;
  double target_m2 = 0.0, largest_clutter_m2 = 0.0;
};

SeenArea seen_area(const World& world, const hal::CameraIntrinsics& k, const Pose& X_WC) {
  const Rendering image = cast_rays(world, k, X_WC);
  std::vector<double> area(world.shapes.size(), 0.0);
  SeenArea seen;
  for (std::size_t i = 0; i < image.shape.size(); ++i) {
    if (image.shape[i] < 0) continue;
    const double z = static_cast<double>(image.depth_m[i]);
    area[static_cast<std::size_t>(image.shape[i])] += z * z / (k.fx * k.fy);
    if (image.label[i] == Label::Target) ++seen.target_pixels;
  }
  for (std::size_t s = 0; s < area.size(); ++s) {
    if (world.shapes[s].label == Label::Target) seen.target_m2 += area[s];
    if (world.shapes[s].label == Label::Clutter)
      seen.largest_clutter_m2 = std::max(seen.largest_clutter_m2, area[s]);
  }
  return seen;
}

bool whole_object_in_view(const SyntheticScene& scene) {
  constexpr double kMargin_px = 6.0, kEmptyColumns_px = 8.0, kNearest_m = 0.6;
  const Pose X_CW = scene.X_WC.inverse();
  const hal::CameraIntrinsics& k = scene.intrinsics;
  for (const Shape& shape : scene.world.shapes) {
    if (shape.label != Label::Target) continue;
    for (const Vec3& corner : corners(shape)) {
      const Vec3 p = X_CW * corner;
      if (p.z() < kNearest_m) return false;
      const double u = k.fx * p.x() / p.z() + k.cx, v = k.fy * p.y() / p.z() + k.cy;
      if (u < kMargin_px || u > k.width - kEmptyColumns_px - kMargin_px) return false;
      if (v < kMargin_px || v > k.height - kMargin_px) return false;
    }
  }
  return true;
}

class SceneMaker {
 public:
  SceneMaker(ObjectKind kind, std::uint64_t seed, std::uint64_t attempt)
      : kind_(kind), draws_(seed, 1000 + 100 * static_cast<std::uint64_t>(kind) + attempt) {}

  SyntheticScene make(std::uint64_t seed) {
    const ObjectModel model = make_object(kind_, draws_);
    SyntheticScene scene;
    scene.kind = kind_;
    scene.name = fmt::format("{}, seed {}", model.name, seed);
    scene.world.shapes.push_back(half_space(Vec3::Zero(), Vec3::UnitZ(), Label::Ground));
    scene.world.shapes.back().reflectivity = draws_.between(0.4, 0.8);
    place(model, scene);
    put_camera(scene);
    if (!whole_object_in_view(scene)) {
      scene.world.shapes.clear();
      return scene;
    }
    put_wall(scene);
    put_clutter(model, scene);
    return scene;
  }

 private:
  void place(const ObjectModel& model, SyntheticScene& scene) {
    X_WT_.linear() =
        Eigen::AngleAxisd(hal::deg_to_rad(draws_.between(-180, 180)), Vec3::UnitZ()).toRotationMatrix();
    X_WT_.translation() = Vec3(draws_.between(-0.2, 0.2), draws_.between(-0.2, 0.2), 0.0);
    bounds_ = model.bounds();
    const double reflectivity = draws_.between(0.35, 0.9);
    for (const auto* list : {&model.parts, &model.supports})
      for (Shape s : *list) {
        s.X_WS = X_WT_ * s.X_WS;
        s.reflectivity = reflectivity;
        scene.world.shapes.push_back(s);
      }
    const auto turned = [&](const Vec3& direction) { return Vec3(X_WT_.linear() * direction); };
    for (TrueFace f : model.faces) {
      f.center = X_WT_ * f.center, f.normal = turned(f.normal), f.u = turned(f.u), f.v = turned(f.v);
      scene.faces.push_back(f);
    }
    for (TrueCylinder c : model.cylinders) {
      c.center = X_WT_ * c.center, c.axis = turned(c.axis);
      scene.cylinders.push_back(c);
    }
    for (const Vec3& p : model.graspable) scene.graspable.push_back(X_WT_ * p);
    scene.cog = X_WT_ * model.cog();
  }

  void put_camera(SyntheticScene& scene) {
    close_wall_ = draws_.chance(0.2);
    const double azimuth = hal::deg_to_rad(draws_.between(-180, 180));
    const double down = hal::deg_to_rad(close_wall_ ? draws_.between(25, 31) : draws_.between(25, 50));
    const double away = draws_.between(1.2, 2.2);
    towards_camera_ = {std::cos(azimuth), std::sin(azimuth), 0.0};
    const Vec3 middle = X_WT_ * bounds_.center();
    // nobody aims a camera at the exact middle
    const Vec3 aim = middle + Vec3(draws_.between(-0.06, 0.06), draws_.between(-0.06, 0.06), 0.0);
    const Vec3 eye = aim + away * (std::cos(down) * towards_camera_ + std::sin(down) * Vec3::UnitZ());
    scene.X_WC = look_at(eye, aim);
  }

  void put_wall(SyntheticScene& scene) {
    const bool far_wall = draws_.chance(0.45);
    if (!close_wall_ && !far_wall) return;
    const double turn = hal::deg_to_rad(draws_.between(-20, 20));
    const Vec3 normal = Eigen::AngleAxisd(turn, Vec3::UnitZ()) * towards_camera_;
    double behind = 1e9;  // of the object's points, the one that is furthest back
    for (const Shape& s : scene.world.shapes)
      if (s.label == Label::Target || s.label == Label::Clutter)
        for (const Vec3& p : corners(s)) behind = std::min(behind, normal.dot(p));
    const double gap = close_wall_ ? draws_.between(0.20, 0.30) : draws_.between(0.5, 1.6);
    wall_ = half_space((behind - gap) * normal, normal, Label::Wall);
    wall_->reflectivity = draws_.between(0.5, 0.9);
    scene.world.shapes.push_back(*wall_);
  }

  void put_clutter(const ObjectModel& model, SyntheticScene& scene) {
    const hal::CameraIntrinsics k = coarse(scene.intrinsics);
    const SeenArea before = seen_area(scene.world, k, scene.X_WC);
    int wanted = draws_.below(5);
    for (int attempt = 0; attempt < 40 && wanted > 0; ++attempt) {
      const Shape candidate = random_clutter(model);
      if (!stands_clear(candidate, scene)) continue;
      World with = scene.world;
      with.shapes.push_back(candidate);
      const SeenArea after = seen_area(with, k, scene.X_WC);
      // hides nothing of the object, and is not what a person would call the largest thing here
      if (after.target_pixels != before.target_pixels) continue;
      if (after.largest_clutter_m2 > std::max(before.largest_clutter_m2, 0.5 * before.target_m2)) continue;
      scene.world = std::move(with);
      --wanted;
    }
  }

  Shape random_clutter(const ObjectModel& model) {
    const Vec3 half = 0.5 * model.bounds().sizes();
    const double angle = hal::deg_to_rad(draws_.between(-180, 180));
    const double away = std::hypot(half.x(), half.y()) * draws_.between(0.4, 1.0) + draws_.between(0.15, 1.2);
    Vec3 p = X_WT_ * Vec3(away * std::cos(angle), away * std::sin(angle), 0.0);
    const double height = draws_.between(0.08, 0.35), yaw = hal::deg_to_rad(draws_.between(-180, 180));
    const double x = draws_.between(0.08, 0.32), y = draws_.between(0.08, 0.32);
    p.z() = 0.5 * height;
    Shape s = draws_.chance(0.6) ? box(p, {x, y, height}, yaw, Label::Clutter)
                                 : cylinder(p, Vec3::UnitZ(), 0.4 * x, height, Label::Clutter);
    s.reflectivity = draws_.chance(0.25) ? draws_.between(0.04, 0.15) : draws_.between(0.3, 0.9);
    return s;
  }

  [[nodiscard]] bool stands_clear(const Shape& candidate, const SyntheticScene& scene) const {
    const double radius =
        candidate.kind == Shape::Kind::Box ? 0.5 * candidate.size.head<2>().norm() : candidate.size[0];
    const Vec3 p = candidate.X_WS.translation();
    const Vec3 in_T = X_WT_.inverse() * Vec3(p.x(), p.y(), 0.0);
    const Vec3 outside = ((in_T - bounds_.center()).cwiseAbs() - 0.5 * bounds_.sizes()).cwiseMax(0.0);
    if (outside.head<2>().norm() < radius + kClear_m) return false;
    if (wall_ && distance(*wall_, p) < radius + kClear_m) return false;
    if ((p - scene.X_WC.translation()).head<2>().norm() < radius + 0.4) return false;
    for (const Shape& other : scene.world.shapes) {
      if (other.label != Label::Clutter) continue;
      const double other_radius =
          other.kind == Shape::Kind::Box ? 0.5 * other.size.head<2>().norm() : other.size[0];
      if ((other.X_WS.translation() - p).head<2>().norm() < radius + other_radius + kClear_m) return false;
    }
    return true;
  }

  ObjectKind kind_;
  Draws draws_;
  Pose X_WT_ = Pose::Identity();
  hal::Aabb bounds_;
  Vec3 towards_camera_ = Vec3::UnitX();
  bool close_wall_ = false;
  std::optional<Shape> wall_;
};

}  // namespace

SyntheticScene make_scene(ObjectKind kind, std::uint64_t seed) {
  // a camera that cuts the object is drawn again; about every third is
  SyntheticScene scene;
  for (std::uint64_t attempt = 0; attempt < 90 && scene.world.shapes.empty(); ++attempt)
    scene = SceneMaker(kind, seed, attempt).make(seed);
  return scene;
}

}  // namespace colift::sim_hal
