#include "perception/motion/window_sums.hpp"

#include <catch2/catch.hpp>

#include "sim_hal/synthetic/hash_random.hpp"

namespace {

using namespace colift;
using perception::InverseDepth;
using perception::Window;
using perception::WindowSums;

/// An object with holes in it, up to borders of the image.
InverseDepth object() {
  InverseDepth o;
  o.width = 60, o.height = 40;
  o.values.resize(60 * 40);
  sim_hal::Draws draws(3, 1);
  for (int v = 0; v < 33; ++v)
    for (int u = 2; u < 60; ++u)
      if (!draws.chance(0.2))
        o.values[static_cast<std::size_t>(v * 60 + u)] = static_cast<float>(draws.between(0.4, 0.8));
  return o;
}

WindowSums by_definition(const InverseDepth& o, int u, int v, const Window& w) {
  WindowSums s;
  const auto middle = static_cast<double>(o.values[static_cast<std::size_t>(v * o.width + u)]);
  for (int dv = -w.v; dv <= w.v; ++dv)
    for (int du = -w.u; du <= w.u; ++du) {
      if (u + du < 0 || v + dv < 0 || u + du >= o.width || v + dv >= o.height) continue;
      const auto inverse =
          static_cast<double>(o.values[static_cast<std::size_t>((v + dv) * o.width + u + du)]);
      if (!(inverse > 0)) continue;
      const double d = inverse - middle;
      s.n += 1, s.u += du, s.v += dv, s.uu += du * du, s.uv += du * dv, s.vv += dv * dv;
      s.w += d, s.wu += d * du, s.wv += d * dv, s.ww += d * d;
    }
  return s;
}

}  // namespace

TEST_CASE("sums of a window are those of its pixels, at borders and holes too") {
  const InverseDepth o = object();
  const perception::WindowIntegrals integrals(o);
  const std::vector<Window> windows{{15, 15}, {9, 9}, {3, 15}, {2, 9}, {5, 5}};
  for (const Window& window : windows) {
    int most = 0;
    for (int v = 0; v < 40; ++v)
      for (int u = 0; u < 60; u += 3) {
        const WindowSums is = integrals.sums(o, u, v, window), must = by_definition(o, u, v, window);
        CAPTURE(u, v, window.u, window.v);
        REQUIRE(is.n == must.n);
        REQUIRE(is.uu == Approx(must.uu).margin(1e-9));
        REQUIRE(is.uv == Approx(must.uv).margin(1e-9));
        REQUIRE(is.vv == Approx(must.vv).margin(1e-9));
        REQUIRE(is.u == Approx(must.u).margin(1e-9));
        REQUIRE(is.v == Approx(must.v).margin(1e-9));
        REQUIRE(is.w == Approx(must.w).margin(1e-9));
        REQUIRE(is.wu == Approx(must.wu).margin(1e-9));
        REQUIRE(is.wv == Approx(must.wv).margin(1e-9));
        REQUIRE(is.ww == Approx(must.ww).margin(1e-9));
        most = std::max(most, static_cast<int>(is.n));
      }
    CHECK(most > window.pixels() / 2);
  }
}

TEST_CASE("the normal equations of a curved window are those of their definition", "[motion]") {
  const InverseDepth o = object();
  for (const Window& window : {Window{7, 7}, Window{3, 9}})
    for (const auto& [u, v] : {std::pair(30, 15), std::pair(3, 2), std::pair(58, 31)}) {
      Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
      Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
      double squares = 0.0, n = 0.0;
      const auto value = [&](int x, int y) {
        const bool inside = x >= 0 && y >= 0 && x < o.width && y < o.height;
        return inside ? static_cast<double>(o.values[static_cast<std::size_t>(y * o.width + x)]) : 0.0;
      };
      for (int dv = -window.v; dv <= window.v; ++dv)
        for (int du = -window.u; du <= window.u; ++du) {
          if (!(value(u + du, v + dv) > 0)) continue;
          const double w = value(u + du, v + dv) - value(u, v);
          Eigen::Matrix<double, 6, 1> t;
          t << 1, du, dv, du * du, du * dv, dv * dv;
          normal += t * t.transpose();
          right += w * t;
          squares += w * w;
          ++n;
        }
      const perception::QuadraticSums is = perception::quadratic_sums(o, u, v, window);
      CAPTURE(u, v, window.v);
      CHECK(is.normal == normal);
      CHECK((is.right - right).norm() < 1e-9 * right.norm());
      CHECK(is.squares == Approx(squares).epsilon(1e-12));
      CHECK(is.n == n);
      CHECK(n > 20);
    }
}
