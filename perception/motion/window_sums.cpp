#include "perception/motion/window_sums.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace colift::perception {

WindowIntegrals::WindowIntegrals(const InverseDepth& object) {
  int u_end = 0, v_end = 0;
  u0_ = object.width, v0_ = object.height;
  double sum = 0.0, n = 0.0;
  for (int v = 0; v < object.height; ++v) {
    const float* const row = object.values.data() + static_cast<std::ptrdiff_t>(v) * object.width;
    for (int u = 0; u < object.width; ++u) {
      if (!(row[u] > 0)) continue;
      u0_ = std::min(u0_, u), u_end = std::max(u_end, u + 1);
      v0_ = std::min(v0_, v), v_end = std::max(v_end, v + 1);
      sum += static_cast<double>(row[u]);
      ++n;
    }
  }
  width_ = std::max(0, u_end - u0_), height_ = std::max(0, v_end - v0_);
  mean_ = n > 0 ? sum / n : 0.0;
  // one row and one column more, of zeros
  const std::size_t row_length = static_cast<std::size_t>(width_) + 1;
  sums_.resize(row_length * (static_cast<std::size_t>(height_) + 1));
  for (int v = 0; v < height_; ++v) {
    const float* const row = object.values.data() + static_cast<std::ptrdiff_t>(v0_ + v) * object.width + u0_;
    const Sums* above = sums_.data() + static_cast<std::size_t>(v) * row_length;
    Sums* here = sums_.data() + static_cast<std::size_t>(v + 1) * row_length;
    Sums in_row{};
    for (int u = 0; u < width_; ++u) {
      if (row[u] > 0) {
        const double w = static_cast<double>(row[u]) - mean_, x = u, y = v;
        const Sums terms{1.0, x, y, x * x, x * y, y * y, w, w * x, w * y, w * w};
        for (std::size_t i = 0; i < terms.size(); ++i) in_row[i] += terms[i];
      }
      ++above, ++here;
      for (std::size_t i = 0; i < in_row.size(); ++i) (*here)[i] = (*above)[i] + in_row[i];
    }
  }
}

const WindowIntegrals::Sums& WindowIntegrals::above_left(int u, int v) const {
  return sums_[static_cast<std::size_t>(v) * (static_cast<std::size_t>(width_) + 1) +
               static_cast<std::size_t>(u)];
}

WindowSums WindowIntegrals::sums(const InverseDepth& object, int u, int v, const Window& window) const {
  const int left = std::clamp(u - window.u - u0_, 0, width_),
            right = std::clamp(u + window.u + 1 - u0_, 0, width_),
            top = std::clamp(v - window.v - v0_, 0, height_),
            low = std::clamp(v + window.v + 1 - v0_, 0, height_);
  const Sums &a = above_left(left, top), &b = above_left(right, top), &c = above_left(left, low),
             &d = above_left(right, low);
  Sums s;
  for (std::size_t i = 0; i < s.size(); ++i) s[i] = (d[i] - c[i]) - (b[i] - a[i]);
  // from the object's corner and mean to the middle of the window
  const double x = u - u0_, y = v - v0_;
  const auto value =
      static_cast<double>(object.values[static_cast<std::size_t>(v) * static_cast<std::size_t>(object.width) +
                                        static_cast<std::size_t>(u)]);
  const double m = value - mean_;
  WindowSums out;
  out.n = s[0];
  out.u = s[1] - x * s[0], out.v = s[2] - y * s[0];
  out.uu = s[3] - x * (2 * s[1] - x * s[0]);
  out.uv = s[4] - x * s[2] - y * out.u;
  out.vv = s[5] - y * (2 * s[2] - y * s[0]);
  out.w = s[6] - m * s[0];
  out.wu = (s[7] - x * s[6]) - m * out.u;
  out.wv = (s[8] - y * s[6]) - m * out.v;
  out.ww = s[9] - m * (2 * s[6] - m * s[0]);
  return out;
}

QuadraticSums quadratic_sums(const InverseDepth& object, int u, int v, const Window& window) {
  constexpr std::size_t kOrders = 5;  // u^i v^j up to i + j = 4
  const int first = std::max(-window.u, -u), last = std::min(window.u, object.width - 1 - u);
  const int top = std::max(-window.v, -v), low = std::min(window.v, object.height - 1 - v);
  const float* const at = object.values.data() + static_cast<std::ptrdiff_t>(v) * object.width + u;
  const auto middle = static_cast<double>(*at);
  QuadraticSums s;
  s.right.setZero();
  // whole numbers: their sums are exact
  std::array<std::array<int, kOrders>, kOrders> moment{};
  for (int dv = top; dv <= low; ++dv) {
    const float* const row = at + static_cast<std::ptrdiff_t>(dv) * object.width;
    std::array<int, kOrders> in_row{};
    double w0 = 0.0, w1 = 0.0, w2 = 0.0;
    for (int du = first; du <= last; ++du) {
      if (!(row[du] > 0)) continue;
      const double w = static_cast<double>(row[du]) - middle, wu = w * du;
      w0 += w, w1 += wu, w2 += wu * du;
      s.squares += w * w;
      const int square = du * du;
      in_row[0] += 1, in_row[1] += du, in_row[2] += square;
      in_row[3] += square * du, in_row[4] += square * square;
    }
    Eigen::Matrix<double, 6, 1> right;
    right << w0, w1, dv * w0, w2, dv * w1, dv * dv * w0;
    s.right += right;
    for (std::size_t i = 0; i < kOrders; ++i) {
      int power = 1;
      for (std::size_t j = 0; i + j < kOrders; ++j) {
        moment[i][j] += power * in_row[i];
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
