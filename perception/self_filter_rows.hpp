#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

// The loops of the self filter over one image row, which become SIMD code. The arrays of a call do not
// overlap.

namespace colift::perception::self_filter {

/// Inverse depth less and plus its margin, m0 + m2 z^2 in depth (1/m).
void margins(const float* depth_m, float m0, float m2, int n, float* low, float* high);
/// `high` at most w = start + slope x.
void bound_above(const float* x, float start, float slope, std::size_t n, float* high);
/// `low` at least that.
void bound_below(const float* x, float start, float slope, std::size_t n, float* low);
/// 1 where low <= high.
void hit_between(const float* low, const float* high, std::size_t n, std::int32_t* hit);
/// A round body in one row: inside where curvature (w - vertex)^2 + m2 x^2 + m1 x + m0 <= 0.
struct RowOfRound {
  float m2, m1, m0, vertex0, vertex1, curvature;
};

/// 1 where that holds and the round body is met between them.
void hit_round(const float* x, const float* low, const float* high, const RowOfRound& r, std::size_t n,
               std::int32_t* hit);
/// to[i] = from[i], which are 0 or 1.
void narrow(const std::int32_t* from, int n, std::uint8_t* to);

/// f(u) for every place of [begin, end) where a row is not 0; mostly it is.
template <class F>
void for_each_marked(const std::uint8_t* row, int begin, int end, F f) {
  int u = begin;
  for (; u + 8 <= end; u += 8) {
    std::uint64_t eight = 0;
    std::memcpy(&eight, row + u, sizeof eight);
    for (int k = u; eight != 0; eight >>= 8, ++k)
      if ((eight & 0xff) != 0) f(k);
  }
  for (; u < end; ++u)
    if (row[u] != 0) f(u);
}

}  // namespace colift::perception::self_filter
