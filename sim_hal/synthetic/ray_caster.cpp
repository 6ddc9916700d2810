#include "sim_hal/synthetic/ray_caster.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "sim_hal/synthetic/float4.hpp"

namespace colift::sim_hal {
namespace {

// what is nearest so far along one image row
struct Row {
  const float* ray_x;
  float *w, *normal_dot_ray, *shape;

  void take(int u, Float4 mask, Float4 w_new, Float4 dot_new, Float4 shape_new) const {
    select(mask, w_new, Float4::load(w + u)).store(w + u);
    select(mask, dot_new, Float4::load(normal_dot_ray + u)).store(normal_dot_ray + u);
    select(mask, shape_new, Float4::load(shape + u)).store(shape + u);
  }
};

template <int kFronts, int kBacks>
void cast_flat(const RayPart& part, double ray_y, Columns run, const Row& row) {
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
  for (int u = run.begin; u < run.end; u += 4) {
    const Float4 x = Float4::load(row.ray_x + u);
    Float4 in = front_0[0] + front_x[0] * x, e = distance[0];
    for (int i = 1; i < kFronts; ++i) {
      const Float4 w = front_0[i] + front_x[i] * x;
      e = select(greater(in, w), distance[i], e);
      in = min(in, w);
    }
    Float4 out = Float4::load(row.w + u);  // at least 0: what is nearest so far also hides
    for (int i = 0; i < kBacks; ++i) out = max(out, back_0[i] + back_x[i] * x);
    const Float4 hit = greater(in, out);
    if (any(hit)) row.take(u, hit, in, in * e, shape);
  }
}

template <int kDimensions>
void cast_quadric(const RayPart& part, double ray_y, Columns run, const Row& row) {
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
  for (int u = run.begin; u < run.end; u += 4) {
    const Float4 x = Float4::load(row.ray_x + u);
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
    Float4 out = max(Float4::load(row.w + u), (minus_b - root) * inverse_c);
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

void cast_part(const RayPart& part, double ray_y, Columns run, const Row& row) {
  if (part.kind == RayPart::Kind::Cylinder) return cast_quadric<2>(part, ray_y, run, row);
  if (part.kind == RayPart::Kind::Sphere) return cast_quadric<3>(part, ray_y, run, row);
  if (part.backs == 0) return cast_flat<1, 0>(part, ray_y, run, row);
  if (part.fronts == 1) return cast_flat<1, 5>(part, ray_y, run, row);
  if (part.fronts == 2) return cast_flat<2, 4>(part, ray_y, run, row);
  return cast_flat<3, 3>(part, ray_y, run, row);
}

// A shape that moved by less is not cast anew: a thousandth of the Kinect's smallest step in depth. Counted
// from where it was when it was cast, so that nothing creeps away.
constexpr double kUnseen_m = 1e-6;

bool same(const Shape& a, const Shape& b) {
  return a.kind == b.kind && a.size == b.size && a.label == b.label &&
         (a.X_WS.matrix() - b.X_WS.matrix()).cwiseAbs().maxCoeff() <= kUnseen_m;
}

// sets the bits of all groups of four that have one of these columns
void mark(std::uint64_t* row, const Columns& columns) {
  if (columns.begin >= columns.end) return;
  const int first = columns.begin / 4, last = (columns.end - 1) / 4;
  for (int word = first / 64; word <= last / 64; ++word) {
    const int low = std::max(first - 64 * word, 0), high = std::min(last - 64 * word, 63);
    row[word] |= ~std::uint64_t{0} << low & ~std::uint64_t{0} >> (63 - high);
  }
}

}  // namespace

RayCaster::RayCaster(const hal::CameraIntrinsics& intrinsics, const Pose& X_WC) {
  image_.intrinsics = intrinsics;
  image_.X_WC = X_WC;
  const auto width = static_cast<std::size_t>(intrinsics.width);
  const auto height = static_cast<std::size_t>(intrinsics.height);
  const std::size_t pixels = width * height, whole = (width + 3) / 4 * 4;
  image_.depth_m.resize(pixels);
  image_.cos_incidence.resize(pixels);
  image_.shape.resize(pixels);
  image_.label.resize(pixels);
  for (std::vector<float>* row : {&ray_x_, &w_, &normal_dot_ray_, &shape_}) row->resize(whole);
  for (std::size_t u = 0; u < whole; ++u)
    ray_x_[u] = static_cast<float>((static_cast<double>(u) - intrinsics.cx) / intrinsics.fx);
  words_ = (whole / 4 + 63) / 64;
}

const Rendering& RayCaster::cast(const World& world) {
  const bool first = stale_.empty();  // nothing is known of any pixel
  stale_.assign(words_ * static_cast<std::size_t>(image_.intrinsics.height), 0);
  for (int v = 0; first && v < image_.intrinsics.height; ++v)
    mark(&stale_[static_cast<std::size_t>(v) * words_], {0, image_.intrinsics.width});
  take_over(world);
  for (int v = 0; v < image_.intrinsics.height; ++v) cast_row(v);
  return image_;
}

void RayCaster::take_over(const World& world) {
  const Pose X_CW = image_.X_WC.inverse();
  for (std::size_t i = world.shapes.size(); i < seen_.size(); ++i) mark_stale(seen_[i].parts);
  seen_.resize(world.shapes.size());
  image_.reflectivity.clear();
  labels_.assign(1, Label::Nothing);
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    const Shape& shape = world.shapes[i];
    image_.reflectivity.push_back(static_cast<float>(shape.reflectivity));
    labels_.push_back(shape.label);
    if (seen_[i].known && same(seen_[i].shape, shape)) continue;
    mark_stale(seen_[i].parts);
    seen_[i] = {shape, true, ray_parts(shape, static_cast<int>(i), image_.intrinsics, X_CW * shape.X_WS)};
    mark_stale(seen_[i].parts);
  }
}

void RayCaster::mark_stale(const std::vector<RayPart>& parts) {
  for (const RayPart& part : parts) {
    std::size_t row = static_cast<std::size_t>(part.v_begin) * words_;
    for (const Columns& columns : part.rows) {
      mark(&stale_[row], columns);
      row += words_;
    }
  }
}

void RayCaster::cast_row(int v) {
  const std::uint64_t* stale = &stale_[static_cast<std::size_t>(v) * words_];
  if (std::all_of(stale, stale + words_, [](std::uint64_t word) { return word == 0; })) return;
  row_parts_.clear();
  for (const Seen& seen : seen_)
    for (const RayPart& part : seen.parts)
      if (const Columns columns = part.at_row(v); columns.begin < columns.end)
        row_parts_.push_back({&part, columns});
  for (std::size_t word = 0; word < words_; ++word)
    for (std::uint64_t left = stale[word]; left != 0;) {
      const int from = std::countr_zero(left), to = from + std::countr_one(left >> from);
      const int columns = 256 * static_cast<int>(word);  // before those of this word
      cast_columns(v, {columns + 4 * from, columns + 4 * to});
      left = to < 64 ? left >> to << to : 0;
    }
}

void RayCaster::cast_columns(int v, Columns run) {
  const double ray_y = (v - image_.intrinsics.cy) / image_.intrinsics.fy;
  const Row row{ray_x_.data(), w_.data(), normal_dot_ray_.data(), shape_.data()};
  std::fill(row.w + run.begin, row.w + run.end, 0.0f);
  std::fill(row.shape + run.begin, row.shape + run.end, -1.0f);
  for (const auto& [part, columns] : row_parts_) {
    const Columns both{std::max(run.begin, columns.begin & ~3), std::min(run.end, columns.end)};
    if (both.begin < both.end) cast_part(*part, ray_y, both, row);
  }
  finish(v, run, static_cast<float>(ray_y * ray_y) + 1.0f);
}

// turns inverse depth into depth and the normal's part of the ray into the cosine
void RayCaster::finish(int v, Columns run, float one_plus_y2) {
  const Float4 one(1.0f), y2(one_plus_y2), zero(0.0f), nothing(std::numeric_limits<float>::quiet_NaN());
  const int width = image_.intrinsics.width;
  const std::size_t row = static_cast<std::size_t>(v) * static_cast<std::size_t>(width);
  float *depth = &image_.depth_m[row], *cosine = &image_.cos_incidence[row];
  std::int16_t* shape = &image_.shape[row];
  Label* label = &image_.label[row];
  const Label* labels = labels_.data() + 1;
  const float *ray_x = ray_x_.data(), *w = w_.data(), *dot = normal_dot_ray_.data(), *nearest = shape_.data();
  const auto four = [&](int u, float* z, float* cos, std::int16_t* index) {
    const Float4 x = Float4::load(ray_x + u), hit = greater(Float4::load(nearest + u), Float4(-0.5f));
    const Float4 facing = Float4::load(dot + u) / sqrt(x * x + y2);
    select(hit, min(facing, one), zero).store(cos);
    select(hit, one / Float4::load(w + u), nothing).store(z);
    truncate(Float4::load(nearest + u), index);
  };
  int u = run.begin;
  for (; u + 4 <= std::min(run.end, width); u += 4) {
    four(u, depth + u, cosine + u, shape + u);
    for (int k = u; k < u + 4; ++k) label[k] = labels[shape[k]];
  }
  if (u >= std::min(run.end, width)) return;
  float z[4], cos[4];
  std::int16_t index[4];
  four(u, z, cos, index);
  for (int k = 0; u + k < width; ++k) {
    depth[u + k] = z[k], cosine[u + k] = cos[k], shape[u + k] = index[k];
    label[u + k] = labels[index[k]];
  }
}

Rendering cast_rays(const World& world, const hal::CameraIntrinsics& intrinsics, const Pose& X_WC) {
  RayCaster caster(intrinsics, X_WC);
  (void)caster.cast(world);
  return std::move(caster.image_);
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
