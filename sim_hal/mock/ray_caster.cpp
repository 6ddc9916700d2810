#include "sim_hal/mock/ray_caster.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim_hal/mock/float4.hpp"

// Everything is done in inverse depth w = 1 / z of the ray (x, y, 1). There a plane is a linear function of
// the pixel, so a convex body with flat faces is hit where the smallest w of the faces that the camera is in
// front of exceeds the largest w of the others: no division, no branch. A quadric adds one square root.
// Values that grow with the row are computed in double, so that single precision along the row costs no
// accuracy that a sensor could see.

namespace colift::sim_hal {
namespace {

struct Linear {
  double x = 0.0, y = 0.0, one = 0.0;

  [[nodiscard]] float at_row(double ray_y) const { return static_cast<float>(y * ray_y + one); }
};

Linear linear(const Vec3& n) {
  return {n.x(), n.y(), n.z()};
}

// a convex piece of a shape, in camera coordinates, and the part of the image that it can cover
struct Part {
  enum class Kind { Flat, Cylinder, Sphere };
  Kind kind = Kind::Flat;
  int shape = 0;
  int u_begin = 0, u_end = 0, v_begin = 0, v_end = 0;
  int fronts = 0, backs = 0;
  Linear front[6], back[6];  // w of the planes before and behind which the camera stands
  float front_distance[6] = {};
  // quadric c w^2 + 2 b w + a = 0 with a = |direction|^2 and b^2 - a c = r^2 a - |miss|^2
  Linear direction[3], miss[3], b;
  double c = 0.0, radius = 0.0;
};

void add_plane(Part& part, const Vec3& n, const Vec3& point) {
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

// false where the part is out of sight
bool set_window(Part& part, const Pose& X_CS, const Vec3& half, const hal::CameraIntrinsics& k) {
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
  part.u_begin = pixel(u_low - 1, k.width), part.u_end = pixel(u_high + 2, k.width);
  part.v_begin = pixel(v_low - 1, k.height), part.v_end = pixel(v_high + 2, k.height);
  return part.u_begin < part.u_end && part.v_begin < part.v_end;
}

class PartList {
 public:
  PartList(const World& world, const hal::CameraIntrinsics& k, const Pose& X_WC) : k_(k) {
    const Pose X_CW = X_WC.inverse();
    for (std::size_t i = 0; i < world.shapes.size(); ++i)
      add(world.shapes[i], static_cast<int>(i), X_CW * world.shapes[i].X_WS);
  }
  [[nodiscard]] const std::vector<Part>& parts() const { return parts_; }

 private:
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
        Part part;
        part.shape = index;
        part.u_end = k_.width, part.v_end = k_.height;
        add_plane(part, X_CS.linear().col(2), X_CS.translation());
        if (part.fronts > 0) parts_.push_back(part);
        return;
      }
    }
  }

  void add_box(int index, const Pose& X_CS, const Vec3& half) {
    Part part;
    part.shape = index;
    if (!(half.minCoeff() > 0) || !set_window(part, X_CS, half, k_)) return;
    for (int axis = 0; axis < 3; ++axis)
      for (const double side : {1.0, -1.0}) {
        const Vec3 n = side * X_CS.linear().col(axis);
        add_plane(part, n, X_CS.translation() + half[axis] * n);
      }
    if (part.fronts > 0) parts_.push_back(part);
  }

  void add_cylinder(int index, const Pose& X_CS, double radius, double half_length) {
    Part part;
    part.kind = Part::Kind::Cylinder;
    part.shape = index;
    if (!(radius > 0) || !(half_length > 0)) return;
    if (!set_window(part, X_CS, Vec3(radius, radius, half_length), k_)) return;
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
    if (part.c > 0 || part.fronts > 0) parts_.push_back(part);
  }

  void add_sphere(int index, const Vec3& center_C, double radius) {
    Part part;
    part.kind = Part::Kind::Sphere;
    part.shape = index;
    Pose X = Pose::Identity();
    X.translation() = center_C;
    if (!(radius > 0) || !set_window(part, X, Vec3::Constant(radius), k_)) return;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 e = Vec3::Unit(axis);
      part.direction[axis] = linear(e);
      part.miss[axis] = linear(e.cross(center_C));
    }
    set_quadric(part, -center_C, center_C.squaredNorm(), radius);
    if (part.c > 0) parts_.push_back(part);
  }

  static void set_quadric(Part& part, const Vec3& b, double distance2, double radius) {
    part.b = linear(b);
    part.radius = radius;
    const double c = distance2 - radius * radius;
    part.c = std::abs(c) > 1e-9 ? c : std::copysign(1e-9, c);
  }

  hal::CameraIntrinsics k_;
  std::vector<Part> parts_;
};

// what is nearest so far along one image row
struct Row {
  std::vector<float> ray_x, w, normal_dot_ray, shape;

  explicit Row(std::size_t n) : ray_x(n), w(n), normal_dot_ray(n), shape(n) {}

  void take(int u, Float4 mask, Float4 w_new, Float4 dot_new, Float4 shape_new) {
    select(mask, w_new, Float4::load(&w[u])).store(&w[u]);
    select(mask, dot_new, Float4::load(&normal_dot_ray[u])).store(&normal_dot_ray[u]);
    select(mask, shape_new, Float4::load(&shape[u])).store(&shape[u]);
  }
};

template <int kFronts, int kBacks>
void cast_flat(const Part& part, double ray_y, Row& row) {
  Float4 front_x[kFronts], front_0[kFronts], distance[kFronts], back_x[kBacks + 1], back_0[kBacks + 1];
  for (int i = 0; i < kFronts; ++i) {
    front_x[i] = Float4(static_cast<float>(part.front[i].x));
    front_0[i] = Float4(part.front[i].at_row(ray_y));
    distance[i] = Float4(part.front_distance[i]);
  }
  for (int i = 0; i < kBacks; ++i) {
    back_x[i] = Float4(static_cast<float>(part.back[i].x));
    back_0[i] = Float4(part.back[i].at_row(ray_y));
  }
  const Float4 shape(static_cast<float>(part.shape));
  for (int u = part.u_begin & ~3; u < part.u_end; u += 4) {
    const Float4 x = Float4::load(&row.ray_x[u]);
    Float4 in = front_0[0] + front_x[0] * x, e = distance[0];
    for (int i = 1; i < kFronts; ++i) {
      const Float4 w = front_0[i] + front_x[i] * x;
      e = select(greater(in, w), distance[i], e);
      in = min(in, w);
    }
    Float4 out = Float4::load(&row.w[u]);  // at least 0: what is nearest so far also hides
    for (int i = 0; i < kBacks; ++i) out = max(out, back_0[i] + back_x[i] * x);
    const Float4 hit = greater(in, out);
    if (any(hit)) row.take(u, hit, in, in * e, shape);
  }
}

template <int kDimensions>
void cast_quadric(const Part& part, double ray_y, Row& row) {
  Float4 d_x[kDimensions], d_0[kDimensions], miss_x[3], miss_0[3];
  constexpr int kMisses = kDimensions == 2 ? 1 : 3;
  for (int i = 0; i < kDimensions; ++i) {
    d_x[i] = Float4(static_cast<float>(part.direction[i].x));
    d_0[i] = Float4(part.direction[i].at_row(ray_y));
  }
  for (int i = 0; i < kMisses; ++i) {
    miss_x[i] = Float4(static_cast<float>(part.miss[i].x));
    miss_0[i] = Float4(part.miss[i].at_row(ray_y));
  }
  const Float4 b_x(static_cast<float>(-part.b.x)), b_0(-part.b.at_row(ray_y));
  const Float4 inverse_c(static_cast<float>(1.0 / part.c)), r2(static_cast<float>(part.radius * part.radius));
  const Float4 inverse_r(static_cast<float>(1.0 / part.radius)), zero(0.0f), far_in(1e30f);
  const Float4 shape(static_cast<float>(part.shape));
  const bool outside = part.c > 0;
  Float4 cap_x[2], cap_0[2], cap_distance[2];
  for (int i = 0; i < part.fronts; ++i) {
    cap_x[i] = Float4(static_cast<float>(part.front[i].x));
    cap_0[i] = Float4(part.front[i].at_row(ray_y));
    cap_distance[i] = Float4(part.front_distance[i]);
  }
  Float4 end_x[2], end_0[2];
  for (int i = 0; i < part.backs; ++i) {
    end_x[i] = Float4(static_cast<float>(part.back[i].x));
    end_0[i] = Float4(part.back[i].at_row(ray_y));
  }
  for (int u = part.u_begin & ~3; u < part.u_end; u += 4) {
    const Float4 x = Float4::load(&row.ray_x[u]);
    Float4 a = zero, miss2 = zero;
    for (int i = 0; i < kDimensions; ++i) {
      const Float4 d = d_0[i] + d_x[i] * x;
      a = a + d * d;
    }
    for (int i = 0; i < kMisses; ++i) {
      const Float4 m = miss_0[i] + miss_x[i] * x;
      miss2 = miss2 + m * m;
    }
    const Float4 discriminant = r2 * a - miss2;
    const Float4 crossed = greater(discriminant, zero);
    if (!any(crossed)) continue;
    const Float4 root = sqrt(max(discriminant, zero));
    const Float4 minus_b = b_0 + b_x * x;
    Float4 in = outside ? (minus_b + root) * inverse_c : far_in;
    Float4 dot = root * inverse_r;
    Float4 out = max(Float4::load(&row.w[u]), (minus_b - root) * inverse_c);
    for (int i = 0; i < part.fronts; ++i) {
      const Float4 w = cap_0[i] + cap_x[i] * x;
      dot = select(greater(in, w), w * cap_distance[i], dot);
      in = min(in, w);
    }
    for (int i = 0; i < part.backs; ++i) out = max(out, end_0[i] + end_x[i] * x);
    const Float4 hit = both(crossed, greater(in, out));
    if (any(hit)) row.take(u, hit, in, dot, shape);
  }
}

void cast_part(const Part& part, double ray_y, Row& row) {
  if (part.kind == Part::Kind::Cylinder) return cast_quadric<2>(part, ray_y, row);
  if (part.kind == Part::Kind::Sphere) return cast_quadric<3>(part, ray_y, row);
  if (part.backs == 0) return cast_flat<1, 0>(part, ray_y, row);
  if (part.fronts == 1) return cast_flat<1, 5>(part, ray_y, row);
  if (part.fronts == 2) return cast_flat<2, 4>(part, ray_y, row);
  return cast_flat<3, 3>(part, ray_y, row);
}

// turns inverse depth into depth and the normal's part of the ray into the cosine, for the whole row
void finish(Row& row, float one_plus_y2) {
  const Float4 one(1.0f), y2(one_plus_y2), zero(0.0f), nothing(std::numeric_limits<float>::quiet_NaN());
  for (std::size_t u = 0; u < row.w.size(); u += 4) {
    const Float4 hit = greater(Float4::load(&row.shape[u]), Float4(-0.5f)), x = Float4::load(&row.ray_x[u]);
    const Float4 cosine = Float4::load(&row.normal_dot_ray[u]) / sqrt(x * x + y2);
    select(hit, min(cosine, one), zero).store(&row.normal_dot_ray[u]);
    select(hit, one / Float4::load(&row.w[u]), nothing).store(&row.w[u]);
  }
}

}  // namespace

Rendering cast_rays(const World& world, const hal::CameraIntrinsics& intrinsics, const Pose& X_WC) {
  const auto width = static_cast<std::size_t>(intrinsics.width);
  const auto height = static_cast<std::size_t>(intrinsics.height);
  Rendering image;
  image.intrinsics = intrinsics;
  image.X_WC = X_WC;
  image.depth_m.resize(width * height);
  image.cos_incidence.resize(width * height);
  image.shape.resize(width * height);
  image.label.resize(width * height);
  for (const Shape& shape : world.shapes)
    image.reflectivity.push_back(static_cast<float>(shape.reflectivity));

  std::vector<Label> labels{Label::Nothing};
  for (const Shape& shape : world.shapes) labels.push_back(shape.label);

  const PartList list(world, intrinsics, X_WC);
  Row row((width + 3) / 4 * 4);
  for (std::size_t u = 0; u < row.ray_x.size(); ++u)
    row.ray_x[u] = static_cast<float>((static_cast<double>(u) - intrinsics.cx) / intrinsics.fx);

  for (std::size_t v = 0; v < height; ++v) {
    const double ray_y = (static_cast<double>(v) - intrinsics.cy) / intrinsics.fy;
    std::fill(row.w.begin(), row.w.end(), 0.0f);
    std::fill(row.shape.begin(), row.shape.end(), -1.0f);
    for (const Part& part : list.parts())
      if (static_cast<int>(v) >= part.v_begin && static_cast<int>(v) < part.v_end)
        cast_part(part, ray_y, row);

    const std::size_t begin = v * width;
    finish(row, static_cast<float>(ray_y * ray_y) + 1.0f);
    std::copy_n(row.w.begin(), width, &image.depth_m[begin]);
    std::copy_n(row.normal_dot_ray.begin(), width, &image.cos_incidence[begin]);
    for (std::size_t u = 0; u < width; ++u) image.shape[begin + u] = static_cast<std::int16_t>(row.shape[u]);
    for (std::size_t u = 0; u < width; ++u)
      image.label[begin + u] = labels[static_cast<std::size_t>(image.shape[begin + u] + 1)];
  }
  return image;
}

Pose look_at(const Vec3& eye, const Vec3& target) {
  const Vec3 forward = (target - eye).normalized();
  Vec3 right = forward.cross(Vec3::UnitZ());
  // straight down or up has no level: rows then run along y
  right = right.norm() > 1e-9 ? right.normalized() : Vec3(0, -1, 0);
  Pose X_WC = Pose::Identity();
  X_WC.linear() << right, forward.cross(right), forward;
  X_WC.translation() = eye;
  return X_WC;
}

}  // namespace colift::sim_hal
