#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "hal/types/geometry.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"

namespace colift::perception {

/// Where a body stands between the camera and the edge of the object: a hand there cannot be observed.
struct HiddenEdge {
  double fraction = 0.0;  ///< Of the object's visible edge, 0 to 1.
  bool to_right = false;  ///< The shorter way out of the view is to the right in the image, else to the left.
  hal::Vec3 aside_W =
      hal::Vec3::Zero();  ///< That way, horizontal, length 1; zero: the camera looks along it.
  /// Where a hand of that body most likely is, if it holds the object: on the hidden edge nearest to the
  /// body. No evidence that there is one. `points`: of the edge, weighted by how near they are.
  PartnerGrasp grasp;
};

/// Unset where no part of the edge is hidden.
///
/// \param edge    Points of the object's outline as the camera sees it (W, m).
/// \param current A frame with the body, of the camera that saw the edge.
/// \param body    The body's pixels, ascending.
/// \param gap_m   Min distance of the body from the edge, towards the camera; what is nearer touches it.
[[nodiscard]] std::optional<HiddenEdge> find_hidden_edge(std::span<const Eigen::Vector3f> edge,
                                                         const OrganisedCloud& current,
                                                         std::span<const std::uint32_t> body, double gap_m);

}  // namespace colift::perception
