#include "tools/visualization/scene/solid_rays.hpp"

#include <algorithm>
#include <cmath>

namespace colift::picture {
namespace {

constexpr float kNever = std::numeric_limits<float>::infinity();

// Both crossings of a ray with a sphere or, in the plane, a circle; from > to where it misses.
struct Span {
  float from = kNever, to = -kNever;
};

Span quadratic(float a, float half_b, float c) {
  if (a < 1e-12f) return c <= 0 ? Span{-kNever, kNever} : Span{};
  const float disc = half_b * half_b - a * c;
  if (disc < 0) return {};
  const float root = std::sqrt(disc);
  return {(-half_b - root) / a, (-half_b + root) / a};
}

float cast_box(const Vec3f& half, const Vec3f& o, const Vec3f& d, float before, Vec3f* normal) {
  float enter = -kNever, leave = kNever;
  int face = 0;
  for (int i = 0; i < 3; ++i) {
    if (std::abs(d[i]) < 1e-12f) {
      if (std::abs(o[i]) > half[i]) return before;
      continue;
    }
    const float a = (-half[i] - o[i]) / d[i], b = (half[i] - o[i]) / d[i];
    if (std::min(a, b) > enter) {
      enter = std::min(a, b);
      face = i;
    }
    leave = std::min(leave, std::max(a, b));
  }
  if (enter > leave || enter <= 0 || enter >= before) return before;
  if (normal) {
    *normal = Vec3f::Zero();
    (*normal)[face] = d[face] > 0 ? -1.0f : 1.0f;
  }
  return enter;
}

float cast_ball(const Vec3f& middle, float radius, const Vec3f& o, const Vec3f& d, float before,
                Vec3f* normal) {
  const Vec3f from = o - middle;
  const Span span = quadratic(d.squaredNorm(), from.dot(d), from.squaredNorm() - radius * radius);
  if (span.from > span.to || span.from <= 0 || span.from >= before) return before;
  if (normal) *normal = (from + span.from * d) / radius;
  return span.from;
}

float cast_cylinder(float radius, float half, const Vec3f& o, const Vec3f& d, float before, Vec3f* normal) {
  const Span side = quadratic(d.x() * d.x() + d.y() * d.y(), o.x() * d.x() + o.y() * d.y(),
                              o.x() * o.x() + o.y() * o.y() - radius * radius);
  Span ends{-kNever, kNever};
  if (std::abs(d.z()) < 1e-12f) {
    if (std::abs(o.z()) > half) return before;
  } else {
    const float a = (-half - o.z()) / d.z(), b = (half - o.z()) / d.z();
    ends = {std::min(a, b), std::max(a, b)};
  }
  const float enter = std::max(side.from, ends.from), leave = std::min(side.to, ends.to);
  if (enter > leave || enter <= 0 || enter >= before) return before;
  if (normal) {
    if (ends.from > side.from)
      *normal = Vec3f(0, 0, d.z() > 0 ? -1.0f : 1.0f);
    else
      *normal = Vec3f(o.x() + enter * d.x(), o.y() + enter * d.y(), 0) / radius;
  }
  return enter;
}

float cast_capsule(float radius, float half, const Vec3f& o, const Vec3f& d, float before, Vec3f* normal) {
  float t = before;
  const Span side = quadratic(d.x() * d.x() + d.y() * d.y(), o.x() * d.x() + o.y() * d.y(),
                              o.x() * o.x() + o.y() * o.y() - radius * radius);
  if (side.from <= side.to && side.from > 0 && side.from < t) {
    const Vec3f p = o + side.from * d;
    if (std::abs(p.z()) <= half) {
      t = side.from;
      if (normal) *normal = Vec3f(p.x(), p.y(), 0) / radius;
    }
  }
  for (const float end : {-half, half}) t = cast_ball({0, 0, end}, radius, o, d, t, normal);
  return t;
}

}  // namespace

RaySolid ray_solid(const Solid& solid) {
  RaySolid ray;
  ray.kind = solid.kind;
  ray.R_SW = solid.X_WS.linear().transpose().cast<float>();
  ray.origin = ray.middle = solid.X_WS.translation().cast<float>();
  const Vec3f size = solid.size.cast<float>();
  switch (solid.kind) {
    case Solid::Kind::Box:
      ray.size = 0.5f * size;
      ray.reach = ray.size.norm();
      break;
    case Solid::Kind::Cylinder:
      ray.size = {size.x(), 0.5f * size.y(), 0};
      ray.reach = ray.size.norm();
      break;
    case Solid::Kind::Capsule:
      ray.size = {size.x(), 0.5f * size.y(), 0};
      ray.reach = ray.size.x() + ray.size.y();
      break;
    case Solid::Kind::Sphere:
      ray.size = {size.x(), 0, 0};
      ray.reach = size.x();
      break;
    case Solid::Kind::Ground:
      ray.reach = kNever;
      break;
  }
  return ray;
}

float cast(const RaySolid& solid, const Vec3f& from, const Vec3f& along, float before, Vec3f* normal) {
  const Vec3f to = solid.middle - from;
  const float ahead = to.dot(along), reach = solid.reach;
  if (ahead > before + reach || ahead < -reach || to.squaredNorm() - ahead * ahead > reach * reach)
    return before;
  const Vec3f o = solid.R_SW * (from - solid.origin), d = solid.R_SW * along;
  float t = before;
  switch (solid.kind) {
    case Solid::Kind::Box:
      t = cast_box(solid.size, o, d, before, normal);
      break;
    case Solid::Kind::Cylinder:
      t = cast_cylinder(solid.size.x(), solid.size.y(), o, d, before, normal);
      break;
    case Solid::Kind::Capsule:
      t = cast_capsule(solid.size.x(), solid.size.y(), o, d, before, normal);
      break;
    case Solid::Kind::Sphere:
      t = cast_ball(Vec3f::Zero(), solid.size.x(), o, d, before, normal);
      break;
    case Solid::Kind::Ground: {
      // seen from below the ground is not there
      const float down = -o.z() / d.z();
      if (d.z() > -1e-9f || down <= 0 || down >= before) return before;
      t = down;
      if (normal) *normal = Vec3f::UnitZ();
      break;
    }
  }
  if (normal && t < before) *normal = solid.R_SW.transpose() * *normal;
  return t;
}

bool may_meet(const Bundle& bundle, const RaySolid& solid) {
  if (!std::isfinite(solid.reach)) return true;
  const Vec3f to = solid.middle - bundle.from;
  const float ahead = to.dot(bundle.along);
  const float room = solid.reach + bundle.radius;
  if (ahead < -room || ahead > bundle.length + room) return false;
  const float wide = room + bundle.spread * std::max(0.0f, std::min(ahead + room, bundle.length));
  const float aside = to.squaredNorm() - ahead * ahead;
  return aside <= wide * wide;
}

}  // namespace colift::picture
