#include "sim_hal/synthetic/kinect/kinect_grain.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim_hal/synthetic/hash_random.hpp"
#include "sim_hal/synthetic/kinect/kinect_tables.hpp"

namespace colift::sim_hal {
namespace {

constexpr std::uint64_t kTapeSeed = 1;
enum Stream : std::uint64_t { kShuffle, kPiece };
constexpr std::size_t kTape = 1 << 16;
constexpr std::size_t kLongest = 4096;  // piece; wider rows take several
// of one standard deviation: 3.7 of them with all 16 weights of the smoothing fit 16 bits, so that eight are
// smoothed at once
constexpr float kWhiteUnit = 512.0f;

// every quantile as often, in an order that was drawn once
const std::vector<std::int16_t>& tape() {
  static const auto numbers = [] {
    const std::array<float, 4096>& quantile = normal_quantiles();
    std::vector<std::int16_t> all(kTape);
    for (std::size_t i = 0; i < kTape; ++i)
      all[i] = static_cast<std::int16_t>(std::lround(kWhiteUnit * quantile[i % quantile.size()]));
    for (std::size_t i = kTape - 1; i > 0; --i)
      std::swap(all[i], all[hash(kTapeSeed, kShuffle, i) % (i + 1)]);
    return all;
  }();
  return numbers;
}

}  // namespace

// after 1 1 1 1 and 1 2 1 the variance is 4 * 6 times as large
const float KinectGrain::kUnit = 1.0f / (kWhiteUnit * std::sqrt(24.0f));

KinectGrain::KinectGrain(int width, std::uint64_t seed)
    : seed_(seed), across_(kLongest + 8), row_(static_cast<std::size_t>(width + 7) / 8 * 8) {}

const std::int16_t* KinectGrain::next_row() {
  for (std::size_t begin = 0; begin < row_.size(); begin += kLongest) {
    const std::size_t n = std::min(row_.size() - begin, kLongest);
    const std::int16_t *above = white(v_, begin), *here = white(v_ + 1, begin), *below = white(v_ + 2, begin);
    std::int16_t *across = across_.data(), *row = row_.data() + begin;
    for (std::size_t u = 0; u < n + 8; ++u)
      across[u] = static_cast<std::int16_t>(above[u] + 2 * here[u] + below[u]);
    for (std::size_t u = 0; u < n; ++u)
      row[u] = static_cast<std::int16_t>(across[u] + across[u + 1] + across[u + 2] + across[u + 3]);
  }
  ++v_;
  return row_.data();
}

const std::int16_t* KinectGrain::white(int v, std::size_t begin) const {
  const std::uint64_t bits = hash(seed_, kPiece, static_cast<std::uint64_t>(v) * 65536 + begin / kLongest);
  return tape().data() + bits % (kTape - kLongest - 8);
}

}  // namespace colift::sim_hal
