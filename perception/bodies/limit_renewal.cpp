#include "perception/bodies/limit_renewal.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "hal/types/avx2.hpp"

namespace colift::perception {
namespace {

constexpr std::size_t kEvery = 3;   // a row of blocks every so many frames: at 30 Hz ten looks a second
constexpr std::uint8_t kLooks = 5;  // in a row
constexpr float kPast_m = 0.08F;    // behind what the reference and its noise explain
constexpr float kMostly = 12.0F;    // of a block's 16 pixels
constexpr int kCompany = 3;         // of its neighbours
constexpr float kRagged_m = 0.03F;  // edges of what is seen now move by some pixels

COLIFT_ALSO_AVX2 void add_past(const float* __restrict depth, const float* __restrict far, std::size_t n,
                               float* __restrict count) {
  for (std::size_t u = 0; u < n; ++u) count[u] += depth[u] > far[u] ? 1.0F : 0.0F;
}

}  // namespace

LimitRenewal::LimitRenewal(std::span<const float> reference_m, std::size_t width, const NoiseModel& noise,
                           const ChangeConfig& config, std::vector<std::uint8_t> keeps)
    : grid_(width, reference_m.size() / width),
      margin_(noise, config),
      keeps_(std::move(keeps)),
      looks_(grid_.size(), 0),
      far_m_(reference_m.begin(), reference_m.end()),
      past_(width, 0.0F) {
  keeps_.resize(grid_.size(), 0);
  for (float& depth : far_m_) depth += margin_(depth) + kPast_m;
}

std::size_t LimitRenewal::update(std::span<const float> depth_m, std::span<const std::uint8_t> robot,
                                 std::span<float> limit_m, std::span<float> behind_m) {
  std::size_t moved = 0;
  for (std::size_t row = frame_++ % kEvery; row < grid_.rows; row += kEvery) {
    look(row, depth_m, robot);
    for (std::size_t b = row * grid_.columns; b < (row + 1) * grid_.columns; ++b) {
      if (looks_[b] < kLooks || !has_company(b)) continue;
      move_back(b, depth_m, limit_m, behind_m);
      ++moved;
    }
  }
  return moved;
}

void LimitRenewal::look(std::size_t row, std::span<const float> depth_m,
                        std::span<const std::uint8_t> robot) {
  std::fill(past_.begin(), past_.end(), 0.0F);
  for (std::size_t k = 0; k < BlockGrid::kSide; ++k) {
    const std::size_t at = (row * BlockGrid::kSide + k) * grid_.width;
    add_past(depth_m.data() + at, far_m_.data() + at, grid_.width, past_.data());
  }
  for (std::size_t c = 0; c < grid_.columns; ++c) {
    const float* p = past_.data() + c * BlockGrid::kSide;
    const std::size_t b = row * grid_.columns + c;
    const bool past = p[0] + p[1] + p[2] + p[3] >= kMostly && robot[b] == 0 && keeps_[b] == 0;
    looks_[b] = past ? static_cast<std::uint8_t>(std::min<int>(looks_[b] + 1, kLooks)) : std::uint8_t{0};
  }
}

bool LimitRenewal::has_company(std::size_t block) const {
  int company = -1;  // its own look
  grid_.around(block, [&](std::size_t b) { company += looks_[b] > 0 ? 1 : 0; });
  return company >= kCompany;
}

void LimitRenewal::move_back(std::size_t block, std::span<const float> depth_m, std::span<float> limit_m,
                             std::span<float> behind_m) {
  // the nearest of what is seen: a NaN is never nearer
  float near_m = std::numeric_limits<float>::max();
  grid_.pixels(block, [&](std::size_t i) {
    if (depth_m[i] > far_m_[i]) near_m = std::min(near_m, depth_m[i]);
  });
  const float limit = near_m - margin_(near_m) - kRagged_m, far = near_m + margin_(near_m) + kPast_m;
  grid_.pixels(block, [&](std::size_t i) {
    if (limit > limit_m[i]) limit_m[i] = limit;
    if (far > far_m_[i]) far_m_[i] = far;
  });
  behind_m[block] = near_m;
}

}  // namespace colift::perception
