#include "planner/motion/collision/squared_distances.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "hal/types/add_bits.hpp"
#include "hal/types/avx2.hpp"

// The distance transform is separable: along x, then y, then z, each value is the least of its neighbours'
// plus their squared distance. Because distances are cut at `reach`, looking that far is exact, and cheaper
// than a lower envelope of parabolas (Felzenszwalb and Huttenlocher 2012), as it runs on 32 bytes at a time
// and mostly ends early: at a strip of corners that all are nearer than the next neighbour could make them,
// and before neighbours that hold nothing.

namespace colift::planner {
namespace {

/// What is taken together along a row: 32 values of one byte each while the square of the reach fits, else 16
/// of two. Vectors go by reference: by value their registers would depend on the processor.
template <class T>
class Strip {
 public:
  static constexpr int kLength = 32 / static_cast<int>(sizeof(T));
  typedef T Vector [[gnu::vector_size(32)]];

  explicit Strip(const T* from) { std::memcpy(&v_, from, sizeof v_); }
  void store(T* to) const { std::memcpy(to, &v_, sizeof v_); }
  /// Each value at most that of `from` plus `add`. `room`: the largest value to which it can be added.
  void lower(const T* from, T add, T room) {
    Vector other;
    std::memcpy(&other, from, sizeof other);
    other = other < room ? other : Vector{} + room;
    other += add;
    v_ = v_ < other ? v_ : other;
  }
  [[nodiscard]] bool any_above(T value) const {
    const auto above = v_ > value;
    std::uint64_t bits[4];
    std::memcpy(bits, &above, sizeof bits);
    return (bits[0] | bits[1] | bits[2] | bits[3]) != 0;
  }
  [[nodiscard]] T smallest() const {
    T all[kLength];
    std::memcpy(all, &v_, sizeof all);
    for (int half = kLength / 2; half > 0; half /= 2)
      for (int i = 0; i < half; ++i) all[i] = std::min(all[i], all[half + i]);
    return all[0];
  }

 private:
  Vector v_;
};

/// Rows of corners, each padded to whole strips, with the least value of every strip.
template <class T>
struct Volume {
  int strips, rows;
  std::vector<T> values, least;

  Volume(int row_length, int row_count, T fill)
      : strips((row_length + Strip<T>::kLength - 1) / Strip<T>::kLength),
        rows(row_count),
        values(static_cast<std::size_t>(strips * Strip<T>::kLength) * static_cast<std::size_t>(rows), fill),
        least(static_cast<std::size_t>(strips) * static_cast<std::size_t>(rows), fill) {}
  [[nodiscard]] std::ptrdiff_t strip(int row, int s) const {
    return static_cast<std::ptrdiff_t>(row) * strips + s;
  }
  [[nodiscard]] T* at(std::ptrdiff_t strip) { return values.data() + strip * Strip<T>::kLength; }
  [[nodiscard]] const T* at(std::ptrdiff_t strip) const { return values.data() + strip * Strip<T>::kLength; }
};

template <class T>
class Transform {
 public:
  Transform(const GridSize& size, const std::vector<std::uint8_t>& is_obstacle, int reach)
      : cells_(size),
        nx_(size.nx + 1),
        ny_(size.ny + 1),
        nz_(size.nz + 1),
        reach_(reach),
        far_(static_cast<T>(reach * reach)),
        is_obstacle_(is_obstacle.data()),
        least_of_(static_cast<std::size_t>(std::max(ny_, nz_) + 2 * reach), reach * reach),
        holds_before_(least_of_.size()),
        along_x_(nx_, ny_ * nz_, far_),
        other_(nx_, ny_ * nz_, far_) {}

  std::vector<std::int16_t> run() {
    along_x();
    const Range near_y = y_.grown(reach_, ny_), near_z = z_.grown(reach_, nz_);
    for (int z = z_.begin; z < z_.end; ++z) across(along_x_, other_, z * ny_, 1, y_, near_y);
    for (int y = near_y.begin; y < near_y.end; ++y) across(other_, along_x_, y, ny_, z_, near_z);
    std::vector<std::int16_t> out(static_cast<std::size_t>(nx_) * static_cast<std::size_t>(along_x_.rows));
    std::int16_t* to = out.data();
    for (int row = 0; row < along_x_.rows; ++row, to += nx_)
      std::copy_n(along_x_.at(along_x_.strip(row, 0)), nx_, to);
    return out;
  }

 private:
  static constexpr int kStrip = Strip<T>::kLength;

  /// Corners along an axis that obstacles touch; empty at first.
  struct Range {
    int begin = 0, end = 0;
    void add(int i) {
      begin = begin < end ? std::min(begin, i) : i;
      end = std::max(end, i + 1);
    }
    [[nodiscard]] Range grown(int by, int count) const {
      return begin < end ? Range{std::max(begin - by, 0), std::min(end + by, count)} : Range{};
    }
  };

  /// The obstacle cells around the corners (., y, z), one byte for each corner. False when there are none.
  bool corners(int y, int z, std::vector<std::uint8_t>& of_row) const {
    std::fill(of_row.begin(), of_row.end(), std::uint8_t{0});
    bool any = false;
    for (int cz = std::max(z - 1, 0); cz <= std::min(z, cells_.nz - 1); ++cz)
      for (int cy = std::max(y - 1, 0); cy <= std::min(y, cells_.ny - 1); ++cy) {
        const int row = cz * cells_.ny + cy;
        if (holds_something_[static_cast<std::size_t>(row)] == 0) continue;
        any = true;
        const std::uint8_t* cell = is_obstacle_ + static_cast<std::ptrdiff_t>(row) * cells_.nx;
        hal::add_bits(cell, cells_.nx, of_row.data());
        hal::add_bits(cell, cells_.nx, of_row.data() + 1);
      }
    return any;
  }

  void find_rows() {
    const int count = cells_.ny * cells_.nz;
    holds_something_.resize(static_cast<std::size_t>(count));
    for (int row = 0; row < count; ++row) {
      const std::uint8_t* cell = is_obstacle_ + static_cast<std::ptrdiff_t>(row) * cells_.nx;
      holds_something_[static_cast<std::size_t>(row)] =
          std::memchr(cell, 1, static_cast<std::size_t>(cells_.nx)) != nullptr;
    }
  }

  COLIFT_ALSO_AVX2 void along_x() {
    find_rows();
    const int padding = (reach_ + kStrip - 1) / kStrip;  // strips on either side of a row
    std::vector<std::uint8_t> corner(static_cast<std::size_t>(nx_));
    std::vector<T> line(static_cast<std::size_t>((along_x_.strips + 2 * padding) * kStrip), far_);
    std::vector<std::uint8_t> strip_has(static_cast<std::size_t>(along_x_.strips + 2 * padding), 0);
    for (int row = 0; row < along_x_.rows; ++row) {
      if (!corners(row % ny_, row / ny_, corner)) continue;
      y_.add(row % ny_);
      z_.add(row / ny_);
      T* const first = line.data() + padding * kStrip;
      for (int x = 0; x < nx_; ++x) first[x] = corner[static_cast<std::size_t>(x)] != 0 ? T{0} : far_;
      for (int s = 0; s < along_x_.strips; ++s)
        strip_has[static_cast<std::size_t>(s + padding)] = Strip<T>(first + s * kStrip).smallest() == 0;
      for (int s = 0; s < along_x_.strips; ++s) {
        const auto near = strip_has.begin() + s;
        if (std::none_of(near, near + 2 * padding + 1, [](std::uint8_t has) { return has != 0; })) continue;
        const T* const here = first + s * kStrip;
        Strip<T> strip(here);
        for (int k = 1; k < reach_ && strip.any_above(square(k)); ++k) {
          strip.lower(here - k, square(k), room(k));
          strip.lower(here + k, square(k), room(k));
        }
        const std::ptrdiff_t to = along_x_.strip(row, s);
        strip.store(along_x_.at(to));
        along_x_.least[static_cast<std::size_t>(to)] = strip.smallest();
      }
    }
  }

  /// A line of rows that are neighbours, `stride` apart: what `sources` hold spreads to `reached`.
  COLIFT_ALSO_AVX2 void across(const Volume<T>& in, Volume<T>& out, int first, int stride,
                               const Range& sources, const Range& reached) {
    const std::ptrdiff_t step = in.strip(stride, 0);
    const auto far = static_cast<int>(far_);
    int* const least = least_of_.data() + reach_;  // of each strip of the line; far beyond its sources
    int* const holds_before = holds_before_.data() + reach_;  // how many of those before it hold something
    for (int s = 0; s < in.strips; ++s) {
      const std::ptrdiff_t begin = in.strip(first, s);
      for (int i = sources.begin; i < sources.end; ++i)
        least[i] = static_cast<int>(in.least[static_cast<std::size_t>(begin + i * step)]);
      int holding = 0;
      for (int i = reached.begin - reach_; i < reached.end + reach_; ++i) {
        holds_before[i] = holding;
        holding += least[i] < far;
      }
      for (int i = reached.begin; i < reached.end; ++i) {
        // most strips have nothing within reach: they are far in `in`, and in `out` already
        if (holds_before[i + reach_] == holds_before[i - reach_ + 1]) continue;
        const std::ptrdiff_t at = begin + i * step;
        Strip<T> strip(in.at(at));
        for (int k = 1; k < reach_; ++k) {
          const bool before = least[i - k] + k * k < far, after = least[i + k] + k * k < far;
          if (!before && !after) continue;
          if (!strip.any_above(square(k))) break;
          if (before) strip.lower(in.at(at - k * step), square(k), room(k));
          if (after) strip.lower(in.at(at + k * step), square(k), room(k));
        }
        strip.store(out.at(at));
        out.least[static_cast<std::size_t>(at)] = strip.smallest();
      }
      std::fill(least + sources.begin, least + sources.end, far);
    }
  }

  static T square(int k) { return static_cast<T>(k * k); }
  [[nodiscard]] T room(int k) const { return static_cast<T>(far_ - k * k); }

  GridSize cells_;
  int nx_, ny_, nz_;  // corners
  int reach_;
  T far_;
  const std::uint8_t* is_obstacle_;
  std::vector<std::uint8_t> holds_something_;  // by row of cells
  std::vector<int> least_of_, holds_before_;   // of a line of strips, and `reach` more on either side
  Range y_, z_;                                // of the corners of obstacles
  Volume<T> along_x_, other_;
};

}  // namespace

std::vector<std::int16_t> squared_distances(const GridSize& size,
                                            const std::vector<std::uint8_t>& is_obstacle, int reach) {
  if (reach * reach <= 255) return Transform<std::uint8_t>(size, is_obstacle, reach).run();
  return Transform<std::int16_t>(size, is_obstacle, reach).run();
}

}  // namespace colift::planner
