#include "perception/thesis/thesis_mesh.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

using namespace colift;
using namespace colift::perception;

namespace {

/// A board parallel to the image plane, 2 m before a camera, the world's axes those of the camera.
struct Board {
  OrganisedCloud frame;
  std::vector<std::uint32_t> pixels;  ///< Of the board: all that lie at 2 m.

  explicit Board(int side_px = 40) {
    hal::DepthFrame depth;
    depth.intrinsics.width = depth.intrinsics.height = side_px;
    depth.intrinsics.fx = depth.intrinsics.fy = 500.0;
    depth.intrinsics.cx = depth.intrinsics.cy = 0.5 * side_px;
    depth.depth_m.assign(static_cast<std::size_t>(side_px * side_px), 2.0f);
    frame = deproject(depth, hal::Pose::Identity());
    take();
  }
  void take() {
    pixels.clear();
    for (std::uint32_t i = 0; i < frame.size(); ++i)
      if (frame.depth_m[i] == 2.0f) pixels.push_back(i);
  }
  /// A square of pixels shows something at this depth, or nothing (NaN).
  void put(int x0, int y0, int side, float depth_m) {
    for (int y = y0; y < y0 + side; ++y)
      for (int x = x0; x < x0 + side; ++x)
        frame.depth_m[static_cast<std::size_t>(y * frame.width() + x)] = depth_m;
    take();
  }
};

double area(const ThesisMesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3f a = mesh.vertices[t[0]];
    sum += 0.5 * static_cast<double>((mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).norm());
  }
  return sum;
}

double nearest(const std::vector<hal::Vec3>& points, const hal::Vec3& p) {
  double best = std::numeric_limits<double>::infinity();
  for (const auto& q : points) best = std::min(best, (q - p).norm());
  return best;
}

constexpr float kMissing = std::numeric_limits<float>::quiet_NaN();
constexpr double kPixel_m = 2.0 / 500.0;

}  // namespace

TEST_CASE("the triangles cover a board once", "[thesis][mesh]") {
  const Board board;
  const ThesisMesh mesh = triangulate(board.frame, board.pixels, {});
  CHECK(mesh.vertices.size() == 1600);
  CHECK(area(mesh) == Approx(std::pow(39 * kPixel_m, 2)).epsilon(1e-3));
  ThesisConfig fine;
  fine.mesh_edge_m = 0.5 * kPixel_m;
  CHECK(triangulate(board.frame, board.pixels, fine).triangles.empty());
}

TEST_CASE("pixels that the camera lost are no hole in the obstacle, an opening is one", "[thesis][mesh]") {
  Board lost, open;
  lost.put(17, 17, 6, kMissing);
  open.put(17, 17, 6, 3.0f);  // the wall behind is seen through it
  const hal::Vec3 middle{0, 0, 2};
  const auto points = [](const Board& b) { return points_on(triangulate(b.frame, b.pixels, {}), 0.004); };
  CHECK(nearest(points(lost), middle) < 0.004);
  CHECK(nearest(points(open), middle) > 0.010);
  ThesisConfig own_pixels_only;
  own_pixels_only.mesh_gap_px = 0;
  CHECK(nearest(points_on(triangulate(lost.frame, lost.pixels, own_pixels_only), 0.004), middle) > 0.010);
}

TEST_CASE("a triangle's points leave no gap wider than the spacing", "[thesis][mesh]") {
  const ThesisMesh mesh{{{0, 0, 0}, {0.05f, 0, 0}, {0, 0.05f, 0}}, {{0, 1, 2}}};
  const auto points = points_on(mesh, 0.01);
  for (int i = 0; i <= 10; ++i)
    for (int k = 0; i + k <= 10; ++k) CHECK(nearest(points, {0.005 * i, 0.005 * k, 0}) < 0.01);
  CHECK(points_on({}, 0.01).empty());
}
