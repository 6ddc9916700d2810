#include "perception/self_filter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "hal/types/add_bits.hpp"
#include "perception/self_filter_rows.hpp"

// In inverse depth w = 1 / z along the ray (x, y, 1) of a pixel a half space is w above or below a linear
// function of the pixel, and a round body is a parabola in w whose vertex is linear and whose smallest value
// is quadratic in the pixel. So a whole image row is tested in a few short loops without division, root or
// branch, which compilers turn into SIMD code with plain flags.

namespace colift::perception {
namespace {

using namespace self_filter;

using hal::LinkShape;
using hal::Pose;
using hal::Vec3;

constexpr double kNearest_m = 0.05;  // corners nearer to the camera's plane than this have no pixel

// coefficients of a function of the ray (x, y, 1)
struct Linear {
  double x = 0.0, y = 0.0, one = 0.0;
  [[nodiscard]] double at_row(double ray_y) const { return y * ray_y + one; }
};
Linear linear(const Vec3& n) {
  return {n.x(), n.y(), n.z()};
}

struct Span {
  int begin = 0, end = 0;
};

// a padded link shape as the camera sees it
struct Solid {
  int v_begin = 0, v_end = 0;
  int fronts = 0, backs = 0;
  std::array<Linear, 6> front, back;  // w of faces towards and away from the camera
  bool round = false;
  Eigen::Matrix3d least = Eigen::Matrix3d::Zero();  // smallest value = ray' least ray; inside where negative
  Linear vertex;                                    // w where it is taken
  double curvature = 0.0;
};

}  // namespace

struct SelfFilter::Impl {
  Impl(const hal::RobotModel& m, const hal::CameraIntrinsics& intrinsics, const Pose& X_WC_,
       const NoiseModel& noise, const SelfFilterConfig& c)
      : model(m), k(intrinsics), X_CW(X_WC_.inverse()), config(c) {
    width = static_cast<std::size_t>(k.width);
    height = static_cast<std::size_t>(k.height);
    for (int u = 0; u < k.width; ++u) ray_x.push_back(static_cast<float>((u - k.cx) / k.fx));
    for (auto* row : {&low, &high, &low_here, &high_here}) row->resize(width);
    hit.resize(width);
    mask.resize(width * height);
    wide.resize(width * height);
    band.resize(width);
    removed.reserve(width * height);
    for (const auto& link : model.links) shapes += link.shapes.size();
    solids.reserve(shapes);
    spans.resize(shapes * height);
    rows.resize(height);
    margin0 = static_cast<float>(config.noise_sigma * noise.sigma0_m);
    margin2 = static_cast<float>(config.noise_sigma * noise.sigma2_per_m + 0.5 * noise.step2_per_m);
    step2 = static_cast<float>(noise.step2_per_m);
  }

  hal::RobotModel model;
  hal::CameraIntrinsics k;
  Pose X_CW;
  SelfFilterConfig config;
  std::size_t width = 0, height = 0, shapes = 0;
  float margin0 = 0, margin2 = 0, step2 = 0;  // margin in depth z: margin0 + margin2 z^2

  std::vector<Pose> X_WL;
  std::vector<Solid> solids;
  std::vector<Span> spans;  // of each solid in each row
  std::vector<Span> rows;   // of all solids in each row
  std::vector<float> ray_x, low, high, low_here, high_here;
  std::vector<std::int32_t> hit;
  std::vector<std::uint8_t> mask, wide, band;
  std::vector<std::uint32_t> removed;

  void set_scene(const hal::JointVector& q_rad, const hal::HandPosture& hand) {
    hal::link_poses(model, q_rad, hand, X_WL);
    solids.clear();
    std::fill(rows.begin(), rows.end(), Span{k.width, 0});
    for (std::size_t i = 0; i < model.links.size(); ++i)
      for (const LinkShape& shape : model.links[i].shapes) add(shape, X_CW * X_WL[i] * shape.X_LS);
  }

  void add(const LinkShape& shape, const Pose& X_CS) {
    const double pad = config.padding_m;
    Solid solid;
    Vec3 half;
    switch (shape.kind) {
      case LinkShape::Kind::Box:
        half = 0.5 * shape.size + Vec3::Constant(pad);
        break;
      case LinkShape::Kind::Cylinder:
        half = Vec3(shape.size[0], shape.size[0], 0.5 * shape.size[1]) + Vec3::Constant(pad);
        break;
      case LinkShape::Kind::Sphere:
        half = Vec3::Constant(shape.size[0] + pad);
        break;
    }
    Pose X = X_CS;
    if (shape.kind == LinkShape::Kind::Sphere) X.linear().setIdentity();
    if (shape.kind == LinkShape::Kind::Box)
      for (int axis = 0; axis < 3; ++axis) add_slab(solid, X, axis, half[axis]);
    if (shape.kind == LinkShape::Kind::Cylinder) add_slab(solid, X, 2, half[2]);
    if (shape.kind != LinkShape::Kind::Box) {
      const Vec3 axis = X.linear().col(2);
      const Eigen::Matrix3d across =
          shape.kind == LinkShape::Kind::Sphere
              ? Eigen::Matrix3d::Identity()
              : Eigen::Matrix3d(Eigen::Matrix3d::Identity() - axis * axis.transpose());
      // |across (ray / w - centre)|^2 - r^2, times w^2
      const Vec3 b = across * X.translation();
      const double c = b.squaredNorm() - half[0] * half[0];
      if (!(c > 1e-6)) return;
      solid.round = true;
      solid.curvature = c;
      solid.vertex = linear(b / c);
      solid.least = across - b * b.transpose() / c;
    }
    if (!outline(solid, X, half)) return;
    solids.push_back(solid);
  }

  static void add_slab(Solid& solid, const Pose& X, int axis, double half) {
    for (const double side : {1.0, -1.0}) {
      const Vec3 n = side * X.linear().col(axis);
      const double offset = n.dot(X.translation()) + half;
      const double e = std::abs(offset) > 1e-7 ? offset : std::copysign(1e-7, offset);
      if (e < 0)
        solid.front[static_cast<std::size_t>(solid.fronts++)] = linear(n / e);
      else
        solid.back[static_cast<std::size_t>(solid.backs++)] = linear(n / e);
    }
  }

  // The pixels of each row that the box around a solid covers; false where it is out of sight.
  bool outline(Solid& solid, const Pose& X, const Vec3& half) {
    std::array<Eigen::Vector2d, 8> corner;
    double v_low = 1e9, v_high = -1e9;
    bool whole_image = false, visible = false;
    for (unsigned i = 0; i < 8; ++i) {
      const Vec3 sign(i & 1U ? 1 : -1, i & 2U ? 1 : -1, i & 4U ? 1 : -1);
      const Vec3 p = X * Vec3(half.cwiseProduct(sign));
      if (p.z() < kNearest_m) {
        whole_image = true;
        continue;
      }
      visible = true;
      corner[i] = {k.fx * p.x() / p.z() + k.cx, k.fy * p.y() / p.z() + k.cy};
      v_low = std::min(v_low, corner[i].y()), v_high = std::max(v_high, corner[i].y());
    }
    if (!visible) return false;
    if (whole_image) v_low = 0.0, v_high = k.height;
    const auto row_of = [&](double v) {
      return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(k.height)));
    };
    solid.v_begin = row_of(std::floor(v_low - 1)), solid.v_end = row_of(std::ceil(v_high + 2));
    Span* row = &spans[solids.size() * height];
    for (int v = solid.v_begin; v < solid.v_end; ++v)
      row[v] = whole_image ? Span{0, k.width} : Span{k.width, 0};
    if (!whole_image)
      for (unsigned i = 0; i < 8; ++i)
        for (const unsigned bit : {1U, 2U, 4U})
          if (!(i & bit)) widen(row, corner[i], corner[i | bit]);
    for (int v = solid.v_begin; v < solid.v_end; ++v) {
      Span& all = rows[static_cast<std::size_t>(v)];
      all.begin = std::min(all.begin, row[v].begin), all.end = std::max(all.end, row[v].end);
    }
    return true;
  }

  // takes an edge of the outline into the rows that it crosses, a pixel wider on all sides
  void widen(Span* row, Eigen::Vector2d a, Eigen::Vector2d b) const {
    if (a.y() > b.y()) std::swap(a, b);
    const double slope = b.y() - a.y() > 1e-9 ? (b.x() - a.x()) / (b.y() - a.y()) : 0.0;
    const int first = static_cast<int>(std::floor(std::clamp(a.y() - 1, 0.0, static_cast<double>(k.height))));
    const int last = static_cast<int>(std::ceil(std::clamp(b.y() + 2, 0.0, static_cast<double>(k.height))));
    const bool level = b.y() - a.y() < 2.0;
    for (int v = first; v < last; ++v) {
      double u_low = std::min(a.x(), b.x()), u_high = std::max(a.x(), b.x());
      if (!level) {
        const double at_low = a.x() + slope * (std::clamp(v - 1.0, a.y(), b.y()) - a.y());
        const double at_high = a.x() + slope * (std::clamp(v + 1.0, a.y(), b.y()) - a.y());
        u_low = std::min(at_low, at_high), u_high = std::max(at_low, at_high);
      }
      const auto column = [&](double u) {
        return static_cast<int>(std::clamp(u, 0.0, static_cast<double>(k.width)));
      };
      row[v].begin = std::min(row[v].begin, column(u_low - 1));
      row[v].end = std::max(row[v].end, column(u_high + 2));
    }
  }

  // Marks one row's pixels of all solids in `hit`.
  void test_row(const float* depth_m, int v) {
    const Span all = rows[static_cast<std::size_t>(v)];
    margins(depth_m + all.begin, margin0, margin2, all.end - all.begin, low.data() + all.begin,
            high.data() + all.begin);
    std::fill(hit.begin() + all.begin, hit.begin() + all.end, 0);
    const double ray_y = (v - k.cy) / k.fy;
    for (std::size_t s = 0; s < solids.size(); ++s) {
      const Solid& solid = solids[s];
      if (v < solid.v_begin || v >= solid.v_end) continue;
      const Span span = spans[s * height + static_cast<std::size_t>(v)];
      if (span.begin < span.end) test_solid(solid, span, ray_y);
    }
  }

  void test_solid(const Solid& solid, const Span& span, double ray_y) {
    const auto begin = static_cast<std::size_t>(span.begin);
    const auto n = static_cast<std::size_t>(span.end) - begin;
    const float* x = ray_x.data() + begin;
    float* lo = low_here.data();
    float* hi = high_here.data();
    std::copy_n(low.data() + begin, n, lo);
    std::copy_n(high.data() + begin, n, hi);
    for (int i = 0; i < solid.fronts; ++i) {
      const Linear& plane = solid.front[static_cast<std::size_t>(i)];
      const auto slope = static_cast<float>(plane.x), start = static_cast<float>(plane.at_row(ray_y));
      bound_above(x, start, slope, n, hi);
    }
    for (int i = 0; i < solid.backs; ++i) {
      const Linear& plane = solid.back[static_cast<std::size_t>(i)];
      const auto slope = static_cast<float>(plane.x), start = static_cast<float>(plane.at_row(ray_y));
      bound_below(x, start, slope, n, lo);
    }
    std::int32_t* out = hit.data() + begin;
    if (!solid.round) {
      hit_between(lo, hi, n, out);
      return;
    }
    const Eigen::Matrix3d& m = solid.least;
    const RowOfRound round{static_cast<float>(m(0, 0)),
                           static_cast<float>(2.0 * (m(0, 1) * ray_y + m(0, 2))),
                           static_cast<float>(m(1, 1) * ray_y * ray_y + 2.0 * m(1, 2) * ray_y + m(2, 2)),
                           static_cast<float>(solid.vertex.at_row(ray_y)),
                           static_cast<float>(solid.vertex.x),
                           static_cast<float>(solid.curvature)};
    hit_round(x, lo, hi, round, n, out);
  }

  // Window of all solids, `px` wider.
  struct Window {
    int u_begin, v_begin, u_end, v_end;
  };
  [[nodiscard]] Window window(int px) const {
    Window all{k.width, k.height, 0, 0};
    for (const Solid& solid : solids) {
      all.v_begin = std::min(all.v_begin, solid.v_begin);
      all.v_end = std::max(all.v_end, solid.v_end);
    }
    for (int v = all.v_begin; v < all.v_end; ++v) {
      const Span& row = rows[static_cast<std::size_t>(v)];
      all.u_begin = std::min(all.u_begin, row.begin), all.u_end = std::max(all.u_end, row.end);
    }
    return {std::max(0, all.u_begin - px), std::max(0, all.v_begin - px), std::min(k.width, all.u_end + px),
            std::min(k.height, all.v_end + px)};
  }

  [[nodiscard]] std::size_t at(int u, int v) const {
    return static_cast<std::size_t>(v) * width + static_cast<std::size_t>(u);
  }

  // Marks in `mask` what the solids hit, within the window; everything else in it is cleared.
  void mark(const std::vector<float>& depth_m, const Window& in) {
    for (int v = in.v_begin; v < in.v_end; ++v) {
      std::fill(mask.begin() + static_cast<std::ptrdiff_t>(at(in.u_begin, v)),
                mask.begin() + static_cast<std::ptrdiff_t>(at(in.u_end, v)), std::uint8_t{0});
      const Span row = rows[static_cast<std::size_t>(v)];
      if (row.begin >= row.end) continue;
      test_row(depth_m.data() + at(0, v), v);
      narrow(hit.data() + row.begin, row.end - row.begin, mask.data() + at(row.begin, v));
    }
  }

  // Marks 2 what lies within `px` of the robot and fits to none of its neighbours: where the window of the
  // sensor sees the robot and what is behind it, the depth is neither.
  void mark_edges(const std::vector<float>& depth_m, const Window& in, int px) {
    for (int v = in.v_begin; v < in.v_end; ++v) {
      const std::uint8_t* row = &mask[at(0, v)];
      std::uint8_t* out = &wide[at(0, v)];
      std::copy(row + in.u_begin, row + in.u_end, out + in.u_begin);
      for (int shift = 1; shift <= px; ++shift) {
        const int n = in.u_end - in.u_begin - shift;
        hal::add_bits(row + in.u_begin, n, out + in.u_begin + shift);
        hal::add_bits(row + in.u_begin + shift, n, out + in.u_begin);
      }
    }
    for (int v = in.v_begin; v < in.v_end; ++v) {
      std::fill(band.begin() + in.u_begin, band.begin() + in.u_end, std::uint8_t{0});
      const int last = std::min(v + px, in.v_end - 1);
      for (int y = std::max(v - px, in.v_begin); y <= last; ++y)
        hal::add_bits(&wide[at(in.u_begin, y)], in.u_end - in.u_begin, band.data() + in.u_begin);
      std::uint8_t* const row = &mask[at(0, v)];
      for_each_marked(band.data(), in.u_begin, in.u_end, [&](int u) {
        if (row[u] == 0 && alone(depth_m, u, v)) row[u] = 2;
      });
    }
  }

  [[nodiscard]] bool alone(const std::vector<float>& depth_m, int u, int v) const {
    const float z = depth_m[at(u, v)];
    const float jump = static_cast<float>(config.jump_m) + 2.0f * step2 * z * z;
    int like = 0;
    for (int y = std::max(v - 1, 0); y <= std::min(v + 1, k.height - 1); ++y)
      for (int x = std::max(u - 1, 0); x <= std::min(u + 1, k.width - 1); ++x) {
        const std::size_t i = at(x, y);
        if ((x == u && y == v) || mask[i] == 1) continue;
        like += std::abs(depth_m[i] - z) < jump ? 1 : 0;
      }
    return like < config.min_neighbours;
  }

  void remove(std::vector<float>& depth_m, const Window& in) {
    for (int v = in.v_begin; v < in.v_end; ++v)
      for_each_marked(&mask[at(0, v)], in.u_begin, in.u_end, [&](int u) {
        const std::size_t i = at(u, v);
        if (!(depth_m[i] == depth_m[i])) return;
        depth_m[i] = std::numeric_limits<float>::quiet_NaN();
        removed.push_back(static_cast<std::uint32_t>(i));
      });
  }
};

SelfFilter::SelfFilter(const hal::RobotModel& model, const hal::CameraIntrinsics& intrinsics,
                       const Pose& X_WC, const NoiseModel& noise, const SelfFilterConfig& config)
    : impl_(std::make_unique<Impl>(model, intrinsics, X_WC, noise, config)) {}
SelfFilter::~SelfFilter() = default;
SelfFilter::SelfFilter(SelfFilter&&) noexcept = default;
SelfFilter& SelfFilter::operator=(SelfFilter&&) noexcept = default;

const std::vector<std::uint32_t>& SelfFilter::remove(hal::DepthFrame& frame, const hal::JointVector& q_rad,
                                                     const hal::HandPosture& hand) {
  Impl& impl = *impl_;
  impl.removed.clear();
  if (frame.depth_m.size() != impl.mask.size()) return impl.removed;
  impl.set_scene(q_rad, hand);
  if (impl.solids.empty()) return impl.removed;
  const int px = static_cast<int>(std::lround(impl.config.shadow_padding_px));
  // shapes may mark anything in their rows, edges lie `px` around them; one more for neighbours
  const Impl::Window window = impl.window(px + 1);
  impl.mark(frame.depth_m, window);
  if (px > 0) impl.mark_edges(frame.depth_m, window, px);
  impl.remove(frame.depth_m, window);
  return impl.removed;
}

}  // namespace colift::perception
