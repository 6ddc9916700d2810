#include "perception/surfaces/face_frame.hpp"

#include "views.hpp"

using namespace colift;
using namespace colift::perception;

namespace {

/// Angle (rad) of a frame against the axes, 0 to 45 degrees.
double turn_of(const FaceFrame& f) {
  return std::asin(std::min(std::abs(f.u.x()), std::abs(f.u.y())));
}

/// The rim of a polygon, a point for every `step`, each strayed by up to half of it.
std::vector<FacePoint> rim_of(const std::vector<Eigen::Vector2d>& corners, double step, unsigned seed) {
  std::vector<FacePoint> points;
  const auto stray = [&] {
    seed = seed * 1664525u + 1013904223u;
    return (static_cast<double>(seed >> 8) / (1u << 24) - 0.5) * step;
  };
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d a = corners[i], b = corners[(i + 1) % corners.size()];
    const int n = static_cast<int>((b - a).norm() / step);
    for (int k = 0; k < n; ++k) {
      const Eigen::Vector2d p = a + (b - a) * k / n + Eigen::Vector2d(stray(), stray());
      points.push_back({static_cast<float>(p.x()), static_cast<float>(p.y())});
    }
  }
  return points;
}

}  // namespace

TEST_CASE("a frame around an L runs along its arms and not along the hypotenuse", "[surfaces]") {
  // arms of 3 to 5 cm: the rim of a seat with a leg
  const std::vector<Eigen::Vector2d> corners{{0, 0},       {0.40, 0},    {0.40, 0.03},
                                             {0.04, 0.03}, {0.04, 0.38}, {0, 0.38}};
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const FaceFrame f = bounding_frame(rim_of(corners, 0.004, seed), 0.004);
    INFO("seed " << seed << ", u " << f.u.transpose());
    CHECK(turn_of(f) < 0.05);
    CHECK(f.width() * f.height() == Approx(0.40 * 0.38).epsilon(0.08));
  }
}

TEST_CASE("a frame around a turned rectangle is the rectangle", "[surfaces]") {
  for (const double angle : {0.0, 0.3, 0.7, 1.2}) {
    const Eigen::Rotation2Dd turned(angle);
    const std::vector<Eigen::Vector2d> corners{
        turned * Eigen::Vector2d(0, 0), turned * Eigen::Vector2d(0.5, 0), turned * Eigen::Vector2d(0.5, 0.2),
        turned * Eigen::Vector2d(0, 0.2)};
    const FaceFrame f = bounding_frame(rim_of(corners, 0.004, 7), 0.004);
    CHECK(std::max(f.width(), f.height()) == Approx(0.5).margin(0.01));
    CHECK(std::min(f.width(), f.height()) == Approx(0.2).margin(0.01));
  }
}

TEST_CASE("where a leg is flush with a seat's edge, both become upright or level rectangles", "[surfaces]") {
  using sim_hal::box;
  using sim_hal::Label;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    std::vector<sim_hal::Shape> shapes{box({0, 0, 0.405}, {0.42, 0.44, 0.03}, 0, Label::Target)};
    for (const double x : {-0.1925, 0.1925})
      for (const double y : {-0.2025, 0.2025})
        shapes.push_back(box({x, y, 0.195}, {0.035, 0.035, 0.39}, 0, Label::Target));
    const SurfaceView view(scene_of(shapes, {0.1, 1.7, 1.4}, {0, 0, 0.35}), seed, 15);
    for (const Rectangle& r : rectangles_of(view.surfaces())) {
      if (std::abs(r.normal.z()) > 0.3) continue;
      INFO("seed " << seed << ": " << r.size.transpose() << " along " << r.u.transpose());
      CHECK(std::min(std::abs(r.u.z()), std::abs(r.v.z())) < 0.17);
    }
  }
}
