#include "perception/thesis/thesis_mesh.hpp"

#include <algorithm>
#include <cmath>

namespace colift::perception {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

/// The image with the number of the vertex at each pixel of the target.
struct VertexImage {
  const OrganisedCloud& frame;
  std::vector<std::uint32_t> at;

  [[nodiscard]] std::size_t pixel(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(frame.width()) +
           static_cast<std::size_t>(x);
  }
  [[nodiscard]] std::uint32_t operator()(int x, int y) const { return at[pixel(x, y)]; }
  /// Whether pixels of a block are missing, and none of it shows anything else: without missing ones smaller
  /// blocks cover it, and past something else there is an opening.
  [[nodiscard]] bool is_gap(int x, int y, int side) const {
    bool missing = false;
    for (int v = y; v <= y + side; ++v)
      for (int u = x; u <= x + side; ++u) {
        if ((*this)(u, v) != kNone) continue;
        if (frame.seen(pixel(u, v))) return false;
        missing = true;
      }
    return missing;
  }
};

}  // namespace

ThesisMesh triangulate(const OrganisedCloud& frame, std::span<const std::uint32_t> pixels,
                       const ThesisConfig& config) {
  ThesisMesh mesh;
  VertexImage image{frame, std::vector<std::uint32_t>(frame.size(), kNone)};
  int left = frame.width(), right = -1, top = frame.height(), bottom = -1;
  for (const std::uint32_t p : pixels) {
    if (p >= frame.size() || !frame.seen(p)) continue;
    const int x = static_cast<int>(p) % frame.width(), y = static_cast<int>(p) / frame.width();
    left = std::min(left, x), right = std::max(right, x);
    top = std::min(top, y), bottom = std::max(bottom, y);
    image.at[p] = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(frame.point(p).cast<float>());
  }
  const auto edge = static_cast<float>(config.mesh_edge_m);
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (a == kNone || b == kNone || c == kNone) return;
    const auto &p = mesh.vertices[a], &q = mesh.vertices[b], &r = mesh.vertices[c];
    if ((p - q).norm() <= edge && (q - r).norm() <= edge && (r - p).norm() <= edge)
      mesh.triangles.push_back({a, b, c});
  };
  for (int side = 1; side <= config.mesh_gap_px + 1; side *= 2) {
    for (int y = top; y + side <= bottom; ++y)
      for (int x = left; x + side <= right; ++x) {
        if (side > 1 && !image.is_gap(x, y, side)) continue;
        const auto a = image(x, y), b = image(x + side, y), c = image(x, y + side),
                   d = image(x + side, y + side);
        // of a block with one corner missing the other three are still a triangle
        if (a != kNone && d != kNone) {
          add(a, b, d);
          add(a, d, c);
        } else {
          add(a, b, c);
          add(b, d, c);
        }
      }
  }
  return mesh;
}

std::vector<hal::Vec3> points_on(const ThesisMesh& mesh, double spacing_m) {
  std::vector<hal::Vec3> out;
  out.reserve(mesh.vertices.size());
  for (const auto& p : mesh.vertices) out.emplace_back(p.cast<double>());
  for (const auto& t : mesh.triangles) {
    const hal::Vec3 a = mesh.vertices[t[0]].cast<double>(), ab = mesh.vertices[t[1]].cast<double>() - a,
                    ac = mesh.vertices[t[2]].cast<double>() - a;
    const double longest = std::max({ab.norm(), ac.norm(), (ac - ab).norm()});
    const int steps = static_cast<int>(std::ceil(longest / spacing_m));
    for (int i = 0; i <= steps && steps > 1; ++i)
      for (int k = 0; i + k <= steps; ++k) {
        if ((i == 0 && k == 0) || i == steps || k == steps) continue;  // the vertices are there
        out.push_back(a + ab * (static_cast<double>(i) / steps) + ac * (static_cast<double>(k) / steps));
      }
  }
  return out;
}

}  // namespace colift::perception
