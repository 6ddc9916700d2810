#include "sim_hal/synthetic/ray_parts.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace colift::sim_hal {
namespace {

Linear linear(const Vec3& n) {
  return {n.x(), n.y(), n.z()};
}

void add_plane(RayPart& part, const Vec3& n, const Vec3& point) {
  const double offset = n.dot(point);
  // a camera within the plane sees it as a line: a hair's breadth beside is as true and needs no special case
  const double e = std::abs(offset) > 1e-7 ? offset : std::copysign(1e-7, offset);
  if (e < 0) {
    part.front_distance[part.fronts] = static_cast<float>(-e);
    part.front[part.fronts++] = linear(n / e);
  } else {
    part.back[part.backs++] = linear(n / e);
  }
}

// a part of the image
struct Window {
  int u_begin = 0, u_end = 0, v_begin = 0, v_end = 0;
};

// false where the box is out of sight
bool find_window(Window& window, const Pose& X_CS, const Vec3& half, const hal::CameraIntrinsics& k) {
  double u_low = 1e9, u_high = -1e9, v_low = 1e9, v_high = -1e9;
  int behind = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 sign(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    const Vec3 p = X_CS * Vec3(half.cwiseProduct(sign));
    if (p.z() < 1e-3) {
      ++behind;
      continue;
    }
    const double u = k.fx * p.x() / p.z() + k.cx, v = k.fy * p.y() / p.z() + k.cy;
    u_low = std::min(u_low, u), u_high = std::max(u_high, u);
    v_low = std::min(v_low, v), v_high = std::max(v_high, v);
  }
  if (behind == 8) return false;
  if (behind > 0) u_low = v_low = -1e9, u_high = v_high = 1e9;
  const auto pixel = [](double value, int size) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(size)));
  };
  window = {pixel(u_low - 1, k.width), pixel(u_high + 2, k.width), pixel(v_low - 1, k.height),
            pixel(v_high + 2, k.height)};
  return window.u_begin < window.u_end && window.v_begin < window.v_end;
}

// rays of a row that can hit, by their x
struct Interval {
  double low = -1e9, high = 1e9;

  // only where slope * x + at_0 > 0
  void keep_positive(double slope, double at_0) {
    if (slope > 0) low = std::max(low, -at_0 / slope);
    if (slope < 0) high = std::min(high, -at_0 / slope);
    if (slope == 0 && at_0 <= 0) high = -1e9;
  }
};

// where every face towards the camera is nearer than every other, and before the camera
void narrow_flat(const RayPart& part, double y, Interval& x) {
  for (int i = 0; i < part.fronts; ++i) {
    const Linear& front = part.front[i];
    const double at_0 = front.y * y + front.one;
    x.keep_positive(front.x, at_0);
    for (int k = 0; k < part.backs; ++k) {
      const Linear& back = part.back[k];
      x.keep_positive(front.x - back.x, at_0 - (back.y * y + back.one));
    }
  }
}

// where r^2 |direction|^2 - |miss|^2, a parabola over the row, is positive
void narrow_quadric(const RayPart& part, double y, Interval& x) {
  double p2 = 0, p1 = 0, p0 = 0;  // p2 x^2 + 2 p1 x + p0
  const auto add = [&](const Linear& l, double weight) {
    const double at_0 = l.y * y + l.one;
    p2 += weight * l.x * l.x, p1 += weight * l.x * at_0, p0 += weight * at_0 * at_0;
  };
  const bool sphere = part.kind == RayPart::Kind::Sphere;
  for (int i = 0; i < (sphere ? 3 : 2); ++i) add(part.direction[i], part.radius * part.radius);
  for (int i = 0; i < (sphere ? 3 : 1); ++i) add(part.miss[i], -1.0);
  if (!(p2 < -1e-12)) return;
  const double root2 = p1 * p1 - p2 * p0;
  const double half = std::sqrt(std::max(root2, 0.0)) / -p2;
  // a hair's breadth above the vertex rounding may still find a hit
  x.low = std::max(x.low, p1 / -p2 - half), x.high = std::min(x.high, p1 / -p2 + half);
}

class PartList {
 public:
  explicit PartList(const hal::CameraIntrinsics& k) : k_(k) {}
  [[nodiscard]] std::vector<RayPart> take() { return std::move(parts_); }

  void add(const Shape& shape, int index, const Pose& X_CS) {
    switch (shape.kind) {
      case Shape::Kind::Box:
        return add_box(index, X_CS, 0.5 * shape.size);
      case Shape::Kind::Cylinder:
        return add_cylinder(index, X_CS, shape.size[0], 0.5 * shape.size[1]);
      case Shape::Kind::Sphere:
        return add_sphere(index, X_CS.translation(), shape.size[0]);
      case Shape::Kind::Capsule: {
        const Vec3 cap(0, 0, 0.5 * shape.size[1]);
        add_cylinder(index, X_CS, shape.size[0], cap.z());
        add_sphere(index, X_CS * cap, shape.size[0]);
        return add_sphere(index, X_CS * Vec3(-cap), shape.size[0]);
      }
      case Shape::Kind::HalfSpace: {
        RayPart part;
        part.shape = index;
        add_plane(part, X_CS.linear().col(2), X_CS.translation());
        if (part.fronts > 0) keep(part, {0, k_.width, 0, k_.height});
        return;
      }
    }
  }

 private:
  void add_box(int index, const Pose& X_CS, const Vec3& half) {
    RayPart part;
    part.shape = index;
    Window window;
    if (!(half.minCoeff() > 0) || !find_window(window, X_CS, half, k_)) return;
    for (int axis = 0; axis < 3; ++axis)
      for (const double side : {1.0, -1.0}) {
        const Vec3 n = side * X_CS.linear().col(axis);
        add_plane(part, n, X_CS.translation() + half[axis] * n);
      }
    if (part.fronts > 0) keep(part, window);
  }

  void add_cylinder(int index, const Pose& X_CS, double radius, double half_length) {
    RayPart part;
    part.kind = RayPart::Kind::Cylinder;
    part.shape = index;
    if (!(radius > 0) || !(half_length > 0)) return;
    Window window;
    if (!find_window(window, X_CS, Vec3(radius, radius, half_length), k_)) return;
    const Vec3 axis = X_CS.linear().col(2);
    add_plane(part, axis, X_CS.translation() + half_length * axis);
    add_plane(part, -axis, X_CS.translation() - half_length * axis);
    // the camera as seen from the cylinder, across its axis
    const Vec3 ex = X_CS.linear().col(0), ey = X_CS.linear().col(1);
    const double ox = -ex.dot(X_CS.translation()), oy = -ey.dot(X_CS.translation());
    part.direction[0] = linear(ex);
    part.direction[1] = linear(ey);
    part.miss[0] = linear(ox * ey - oy * ex);
    set_quadric(part, ox * ex + oy * ey, ox * ox + oy * oy, radius);
    if (part.c > 0 || part.fronts > 0) keep(part, window);
  }

  void add_sphere(int index, const Vec3& center_C, double radius) {
    RayPart part;
    part.kind = RayPart::Kind::Sphere;
    part.shape = index;
    Pose X = Pose::Identity();
    X.translation() = center_C;
    Window window;
    if (!(radius > 0) || !find_window(window, X, Vec3::Constant(radius), k_)) return;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 e = Vec3::Unit(axis);
      part.direction[axis] = linear(e);
      part.miss[axis] = linear(e.cross(center_C));
    }
    set_quadric(part, -center_C, center_C.squaredNorm(), radius);
    if (part.c > 0) keep(part, window);
  }

  void keep(RayPart& part, const Window& window) {
    part.v_begin = window.v_begin;
    for (int v = window.v_begin; v < window.v_end; ++v) {
      const double y = (v - k_.cy) / k_.fy;
      Interval x;
      part.kind == RayPart::Kind::Flat ? narrow_flat(part, y, x) : narrow_quadric(part, y, x);
      const auto column = [&](double value) {
        return static_cast<int>(std::clamp(k_.fx * value + k_.cx, -2.0, k_.width + 2.0));
      };
      part.rows.push_back(
          {std::max(window.u_begin, column(x.low) - 1), std::min(window.u_end, column(x.high) + 3)});
    }
    parts_.push_back(std::move(part));
  }

  static void set_quadric(RayPart& part, const Vec3& b, double distance2, double radius) {
    part.b = linear(b);
    part.radius = radius;
    const double c = distance2 - radius * radius;
    part.c = std::abs(c) > 1e-9 ? c : std::copysign(1e-9, c);
  }

  hal::CameraIntrinsics k_;
  std::vector<RayPart> parts_;
};

}  // namespace

std::vector<RayPart> ray_parts(const Shape& shape, int index, const hal::CameraIntrinsics& intrinsics,
                               const Pose& X_CS) {
  PartList list(intrinsics);
  list.add(shape, index, X_CS);
  return list.take();
}

}  // namespace colift::sim_hal
