#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "perception/organised_cloud.hpp"
#include "perception/thesis/thesis_config.hpp"

namespace colift::perception {

/// Triangles over a target's points, vertices in W (m).
struct ThesisMesh {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// Triangulates the target (thesis section 5.3.1, which does not say how): the image is the grid,
/// neighbouring pixels of the target are joined where their points are at most mesh_edge_m apart. Missing
/// pixels up to mesh_gap_px wide are spanned. `pixels` ascending, those of the target. Same input: same bits.
[[nodiscard]] ThesisMesh triangulate(const OrganisedCloud& frame, std::span<const std::uint32_t> pixels,
                                     const ThesisConfig& config);

/// The mesh as an obstacle: points on its triangles, vertices among them, so dense that none of a triangle's
/// points is farther than `spacing_m` from one of them. W (m).
[[nodiscard]] std::vector<hal::Vec3> points_on(const ThesisMesh& mesh, double spacing_m);

}  // namespace colift::perception
