#include "perception/bodies/body_finder.hpp"

#include <algorithm>
#include <cmath>

#include "hal/types/avx2.hpp"

namespace colift::perception {
namespace {

constexpr std::size_t kSide = BlockGrid::kSide;
constexpr double kMiddle_px = 0.5 * (static_cast<double>(kSide) - 1.0);  // of a block
// How far a foot reaches beyond what is seen of the object, and how well ground and the object's motion
// agree.
constexpr float kFootBeside_m = 0.05F, kFootHeight_m = 0.06F, kFootMargin_m = 0.008F;
constexpr double kMinRisen = 0.6;       // fraction of a foot's area: blocks at its rim mix it with the ground
constexpr double kMoved_m = 0.002;      // an object that moved by less stands where it stood
constexpr std::size_t kMaxParts = 256;  // small ones beyond are noise everywhere: the largest count

// Sums and counts of depths that are nearer than their limits, by column over a row of blocks; a NaN compares
// false.
COLIFT_ALSO_AVX2 void sum_foreign(const float* __restrict depth, const float* __restrict limit,
                                  std::size_t width, float* __restrict sum, float* __restrict count) {
  static_assert(kSide == 4);
  const auto near = [](float z, float most) { return z < most ? z : 0.0F; };
  const auto one = [](float z, float most) { return z < most ? 1.0F : 0.0F; };
  const float *z1 = depth + width, *z2 = z1 + width, *z3 = z2 + width;
  const float *most1 = limit + width, *most2 = most1 + width, *most3 = most2 + width;
  for (std::size_t u = 0; u < width; ++u) {
    sum[u] = near(depth[u], limit[u]) + near(z1[u], most1[u]) + near(z2[u], most2[u]) + near(z3[u], most3[u]);
    count[u] = one(depth[u], limit[u]) + one(z1[u], most1[u]) + one(z2[u], most2[u]) + one(z3[u], most3[u]);
  }
}

// The space at the lower end of the object, and a little beside and below it, in which its feet are.
Eigen::AlignedBox3f space_under(std::span<const Eigen::Vector3f> object) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : object) box.extend(p);
  if (box.isEmpty()) return box;
  box.max().z() = box.min().z() + kFootHeight_m;
  box.min() -= Eigen::Vector3f(kFootBeside_m, kFootBeside_m, kFootHeight_m);
  box.max() += Eigen::Vector3f(kFootBeside_m, kFootBeside_m, 0.0F);
  return box;
}

}  // namespace

BodyFinder::BodyFinder(const ReferenceImage& reference, std::span<const Eigen::Vector3f> object,
                       std::span<const char> robot_hid, const NoiseModel& noise, const BodyConfig& config)
    : config_(config),
      noise_(noise),
      intrinsics_(reference.cloud.intrinsics),
      X_CW_(reference.cloud.X_WC.inverse().cast<float>()),
      eye_(reference.cloud.X_WC.translation().cast<float>()),
      pixel_area_(1.0 / (intrinsics_.fx * intrinsics_.fy)),
      object_(object, 0.015, std::max(config.object_margin_m, config.moved_object_margin_m) + 0.03),
      has_object_(!object.empty()),
      under_object_(space_under(object)),
      limit_m_(change_limits(reference, noise, config.change, {0, 0, intrinsics_.width, intrinsics_.height})),
      grid_(static_cast<std::size_t>(intrinsics_.width), static_cast<std::size_t>(intrinsics_.height)) {
  const std::size_t blocks = grid_.size();
  row_sum_.resize(grid_.width);
  row_count_.resize(grid_.width);
  depth_.resize(blocks);
  count_.resize(blocks);
  robot_.resize(blocks, 0);
  foreign_.resize(blocks);
  unknown_.resize(blocks);
  risen_.resize(blocks);
  for (std::size_t i = 0; i < robot_hid.size(); ++i) {
    const std::size_t b = grid_.of_pixel(i);
    if (robot_hid[i] != 0 && !reference.cloud.seen(i) && b < blocks) unknown_[b] = 1;
  }
  point_.resize(blocks);
  ray_.resize(blocks);
  behind_m_.resize(blocks);
  order_.reserve(blocks);
  stack_.reserve(blocks);
  parts_.reserve(blocks);
  bodies_.reserve(kMaxParts);
  points_.reserve(16 * static_cast<std::size_t>(config.max_points));
  const Eigen::Matrix3f R_WC = reference.cloud.X_WC.linear().cast<float>();
  for (std::size_t b = 0; b < blocks; ++b) {
    const double u = static_cast<double>(grid_.u(b)) + kMiddle_px;
    const double v = static_cast<double>(grid_.v(b)) + kMiddle_px;
    ray_[b] = R_WC * Eigen::Vector3f(static_cast<float>((u - intrinsics_.cx) / intrinsics_.fx),
                                     static_cast<float>((v - intrinsics_.cy) / intrinsics_.fy), 1.0F);
    behind_m_[b] =
        reference.cloud.depth_m[static_cast<std::size_t>(v) * grid_.width + static_cast<std::size_t>(u)];
  }
  renewal_.emplace(reference.cloud.depth_m, grid_.width, noise, config.change, object_blocks());
}

std::vector<std::uint8_t> BodyFinder::object_blocks() const {
  std::vector<std::uint8_t> found(grid_.size(), 0);
  if (!has_object_) return found;
  for (std::size_t b = 0; b < found.size(); ++b) {
    const Eigen::Vector3f p = eye_ + behind_m_[b] * ray_[b];
    if (!p.allFinite() || object_.nearest(p.x(), p.y(), p.z()) == ObjectGrid::kNone) continue;
    grid_.around(b, [&](std::size_t n) { found[n] = 1; });
  }
  return found;
}

const std::vector<Body>& BodyFinder::find(const hal::DepthFrame& frame, std::span<const std::uint32_t> robot,
                                          const hal::Pose& X_WTnow_WTref) {
  bodies_.clear();
  points_.clear();
  if (frame.depth_m.size() != limit_m_.size()) return bodies_;
  mark(frame.depth_m);
  leave_out_robot(robot);
  renewal_->update(frame.depth_m, robot_, limit_m_, behind_m_);
  place_blocks(X_WTnow_WTref);
  connect();
  join_parts();
  return bodies_;
}

// Sums and counts of foreign depths by block.
void BodyFinder::mark(const std::vector<float>& depth_m) {
  for (std::size_t row = 0; row < grid_.rows; ++row) {
    const std::size_t at = row * kSide * grid_.width;
    float* sum = row_sum_.data();
    float* count = row_count_.data();
    sum_foreign(depth_m.data() + at, limit_m_.data() + at, grid_.width, sum, count);
    for (std::size_t c = 0; c < grid_.columns; ++c) {
      const std::size_t u = c * kSide, b = row * grid_.columns + c;
      depth_[b] = sum[u] + sum[u + 1] + sum[u + 2] + sum[u + 3];
      count_[b] = count[u] + count[u + 1] + count[u + 2] + count[u + 3];
    }
  }
}

// Beside the robot the sensor mixes its depth with what is behind it: nothing there is trusted.
void BodyFinder::leave_out_robot(std::span<const std::uint32_t> robot) {
  std::fill(robot_.begin(), robot_.end(), std::uint8_t{0});
  for (const std::uint32_t i : robot)
    if (const std::size_t b = grid_.of_pixel(i); b < robot_.size()) robot_[b] = 1;
  if (robot.empty()) return;
  for (std::size_t b = 0; b < robot_.size(); ++b)
    if (robot_[b] != 0) grid_.around(b, [&](std::size_t n) { count_[n] = 0.0F; });
}

void BodyFinder::place_blocks(const hal::Pose& X_WTnow_WTref) {
  const bool moved =
      X_WTnow_WTref.translation().norm() > kMoved_m || !X_WTnow_WTref.linear().isIdentity(kMoved_m);
  const Eigen::Isometry3f X_ref_now = X_WTnow_WTref.inverse().cast<float>();
  const auto margin = static_cast<float>(moved ? config_.moved_object_margin_m : config_.object_margin_m);
  const auto sigma0 = static_cast<float>(2.0 * noise_.sigma0_m),
             sigma2 = static_cast<float>(2.0 * noise_.sigma2_per_m);
  const auto least = static_cast<float>(config_.min_block_px);
  for (std::size_t b = 0; b < count_.size(); ++b) {
    foreign_[b] = risen_[b] = 0;
    if (count_[b] < least) continue;
    const float z = depth_[b] / count_[b];
    depth_[b] = z;
    point_[b] = eye_ + z * ray_[b];
    if (has_object_) {
      const Eigen::Vector3f p = moved ? Eigen::Vector3f(X_ref_now * point_[b]) : point_[b];
      const std::int32_t patch = object_.nearest(p.x(), p.y(), p.z());
      if (patch != ObjectGrid::kNone &&
          (p - object_.patches()[static_cast<std::size_t>(patch)]).norm() < margin + sigma0 + sigma2 * z * z)
        continue;
      risen_[b] = moved && was_ground_under_object(p) ? 1 : 0;
    }
    foreign_[b] = 1;
  }
}

// Feet that are lower than what counts as standing on the ground are the ground, until the object is lifted.
bool BodyFinder::was_ground_under_object(const Eigen::Vector3f& p_W) const {
  if (!under_object_.contains(p_W)) return false;
  const Eigen::Vector3f p = X_CW_ * p_W;
  const float u = p.x() / p.z() * static_cast<float>(intrinsics_.fx) + static_cast<float>(intrinsics_.cx);
  const float v = p.y() / p.z() * static_cast<float>(intrinsics_.fy) + static_cast<float>(intrinsics_.cy);
  const bool in_image = p.z() > 0.0F && u >= 0.0F && v >= 0.0F &&
                        u < static_cast<float>(kSide * grid_.columns) &&
                        v < static_cast<float>(kSide * grid_.rows);
  if (!in_image) return false;
  const std::size_t column = static_cast<std::size_t>(u) / kSide, row = static_cast<std::size_t>(v) / kSide;
  const auto noise_m = static_cast<float>(2.0 * noise_.sigma(static_cast<double>(p.z())));
  return std::abs(behind_m_[row * grid_.columns + column] - p.z()) < kFootMargin_m + noise_m;
}

void BodyFinder::connect() {
  order_.clear();
  parts_.clear();
  for (std::size_t b = 0; b < foreign_.size(); ++b)
    if (foreign_[b] == 1) grow_part(b);
}

// All blocks that hang together with `seed`, over the image without a step in depth.
void BodyFinder::grow_part(std::size_t seed) {
  const auto jump0 = static_cast<float>(config_.jump_m + 4.0 * noise_.sigma0_m);
  const auto jump2 = static_cast<float>(4.0 * noise_.sigma2_per_m + 2.0 * noise_.step2_per_m);
  Part part;
  part.first = order_.size();
  stack_.clear();
  stack_.push_back(static_cast<std::uint32_t>(seed));
  foreign_[seed] = 2;
  while (!stack_.empty()) {
    const std::size_t b = stack_.back();
    stack_.pop_back();
    order_.push_back(static_cast<std::uint32_t>(b));
    const float z = depth_[b];
    const double area_m2 = static_cast<double>(count_[b] * z * z) * pixel_area_;
    part.area_m2 += area_m2;
    part.unknown_m2 += unknown_[b] != 0 ? area_m2 : 0.0;
    part.risen_m2 += risen_[b] != 0 ? area_m2 : 0.0;
    part.box.extend(point_[b].cast<double>());
    grid_.around(b, [&](std::size_t n) {
      if (foreign_[n] != 1 || std::abs(depth_[n] - z) > jump0 + jump2 * z * z) return;
      foreign_[n] = 2;
      stack_.push_back(static_cast<std::uint32_t>(n));
    });
  }
  part.count = order_.size() - part.first;
  if (part.area_m2 <= config_.max_foot_m2 && part.risen_m2 >= kMinRisen * part.area_m2) return;
  if (part.area_m2 >= config_.min_part_m2 && part.unknown_m2 <= config_.max_unknown_fraction * part.area_m2)
    parts_.push_back(part);
}

void BodyFinder::join_parts() {
  const auto larger = [](const Part& a, const Part& b) { return a.area_m2 > b.area_m2; };
  std::sort(parts_.begin(), parts_.end(), larger);
  if (parts_.size() > kMaxParts) parts_.resize(kMaxParts);
  int bodies = 0;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    if (parts_[i].body >= 0) continue;
    parts_[i].body = bodies;
    // whatever is near to a part that belongs to it already, until nothing comes in any more
    for (bool grew = true; grew;) {
      grew = false;
      for (Part& other : parts_) {
        if (other.body >= 0) continue;
        for (const Part& own : parts_) {
          if (own.body != bodies || own.box.exteriorDistance(other.box) > config_.join_m) continue;
          other.body = bodies;
          grew = true;
          break;
        }
      }
    }
    ++bodies;
  }
  for (int n = 0; n < bodies; ++n) make_body(n);
  std::sort(bodies_.begin(), bodies_.end(),
            [](const Body& a, const Body& b) { return a.area_m2 > b.area_m2; });
}

void BodyFinder::make_body(int number) {
  Body body;
  std::size_t blocks = 0;
  for (const Part& part : parts_) {
    if (part.body != number) continue;
    body.area_m2 += part.area_m2;
    body.box.extend(part.box);
    blocks += part.count;
  }
  if (body.area_m2 < config_.min_body_m2) return;
  body.first = points_.size();
  int left = intrinsics_.width, right = 0, upper = intrinsics_.height;
  const std::size_t stride = 1 + blocks / static_cast<std::size_t>(config_.max_points);
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  std::size_t at = 0;
  for (const Part& part : parts_) {
    if (part.body != number) continue;
    for (std::size_t i = part.first; i < part.first + part.count; ++i) {
      const std::size_t b = order_[i];
      const int u = static_cast<int>(grid_.u(b)), v = static_cast<int>(grid_.v(b));
      left = std::min(left, u);
      upper = std::min(upper, v);
      right = std::max(right, u + static_cast<int>(kSide));
      sum += point_[b];
      if (at++ % stride != 0) continue;
      const float along = ray_[b].norm();
      // behind a pixel without reference the room is open
      const float room = (behind_m_[b] - depth_[b]) * along;
      const auto most = static_cast<float>(config_.hidden_m);
      points_.push_back({point_[b], ray_[b] / along, room < most ? std::max(room, 0.0F) : most});
    }
  }
  body.count = points_.size() - body.first;
  body.top_seen = upper > 0;
  body.whole = body.top_seen && left > 0 && right < intrinsics_.width;
  body.center = (sum / static_cast<float>(blocks)).cast<double>();
  bodies_.push_back(body);
}

}  // namespace colift::perception
