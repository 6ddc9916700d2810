#include "perception/motion/window_sums.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace colift::perception {

WindowSums window_sums(const InverseDepth& object, int u, int v, const SampledWindow& window) {
  // the samples of a row that are in the image
  int first = -window.u, last = window.u;
  while (u + first < 0) first += window.step_u;
  while (u + last >= object.width) last -= window.step_u;
  const auto middle =
      static_cast<double>(object.values[static_cast<std::size_t>(v) * static_cast<std::size_t>(object.width) +
                                        static_cast<std::size_t>(u)]);
  WindowSums s;
  for (int dv = -window.v; dv <= window.v; dv += window.step_v) {
    if (v + dv < 0 || v + dv >= object.height) continue;
    const float* const row = object.values.data() + static_cast<std::ptrdiff_t>(v + dv) * object.width + u;
    int n = 0, sum_u = 0, sum_uu = 0;
    double w = 0.0, wu = 0.0;
    for (int du = first; du <= last; du += window.step_u) {
      if (!(row[du] > 0)) continue;
      const double d = static_cast<double>(row[du]) - middle;
      ++n;
      sum_u += du;
      sum_uu += du * du;
      w += d;
      wu += d * du;
      s.ww += d * d;
    }
    s.n += n;
    s.u += sum_u;
    s.v += dv * n;
    s.uu += sum_uu;
    s.uv += dv * sum_u;
    s.vv += dv * dv * n;
    s.w += w;
    s.wu += wu;
    s.wv += dv * w;
  }
  return s;
}

QuadraticSums quadratic_sums(const InverseDepth& object, int u, int v, const SampledWindow& window) {
  constexpr std::size_t kOrders = 5;  // u^i v^j up to i + j = 4
  const auto at = [&](int du, int dv) {
    return static_cast<double>(
        object.values[static_cast<std::size_t>(v + dv) * static_cast<std::size_t>(object.width) +
                      static_cast<std::size_t>(u + du)]);
  };
  const double middle = at(0, 0);
  QuadraticSums s;
  s.right.setZero();
  // whole numbers: their sums are exact
  std::array<std::array<int, kOrders>, kOrders> moment{};
  for (int dv = -window.v; dv <= window.v; dv += window.step_v) {
    if (v + dv < 0 || v + dv >= object.height) continue;
    std::array<int, kOrders> row{};
    for (int du = -window.u; du <= window.u; du += window.step_u) {
      if (u + du < 0 || u + du >= object.width) continue;
      const double here = at(du, dv);
      if (!(here > 0)) continue;
      const double w = here - middle;
      Eigen::Matrix<double, 6, 1> terms;
      terms << 1, du, dv, du * du, du * dv, dv * dv;
      s.right += w * terms;
      s.squares += w * w;
      int power = 1;
      for (int& sum : row) {
        sum += power;
        power *= du;
      }
    }
    for (std::size_t i = 0; i < kOrders; ++i) {
      int power = 1;
      for (std::size_t j = 0; i + j < kOrders; ++j) {
        moment[i][j] += power * row[i];
        power *= dv;
      }
    }
  }
  s.n = moment[0][0];
  constexpr std::array<std::array<std::size_t, 2>, 6> kPowers{
      {{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}}};  // of the terms
  for (std::size_t i = 0; i < kPowers.size(); ++i)
    for (std::size_t j = 0; j < kPowers.size(); ++j)
      s.normal(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          moment[kPowers[i][0] + kPowers[j][0]][kPowers[i][1] + kPowers[j][1]];
  return s;
}

}  // namespace colift::perception
