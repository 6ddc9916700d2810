#pragma once

#include <optional>
#include <span>
#include <vector>

#include "hal/types/geometry.hpp"

namespace colift::perception {

using hal::Vec3;

/// A visible point of a hand that is near the object.
struct HandPoint {
  Eigen::Vector3f point;      ///< In W (m).
  Eigen::Vector3f on_object;  ///< Place of the object nearest to it, in W (m).
  float area_m2 = 0.0F;
};

/// What is known of the object for placing a hand on it: its visible surface and its outline as points in W
/// (m).
struct GraspedObject {
  std::span<const Eigen::Vector3f> surface;       ///< About one point for each 15 mm of surface.
  std::span<const Eigen::Vector3f> outline;       ///< Points beside which the camera sees something farther.
  Eigen::Vector3f eye = Eigen::Vector3f::Zero();  ///< Camera.
};

/// What the object is like where a hand holds it.
enum class HeldPart {
  Bar,     ///< Round; the hand wraps it.
  Corner,  ///< Two faces meet in an edge under the hand.
  Rim,     ///< The end of a face, with nothing visible beyond it.
  Plate,   ///< The same, and the face is that of a thin plate.
  Face,    ///< A face without an end near the hand, or nothing that a shape could be read from.
};

/// Standard deviations of a contact (m).
struct ContactNoise {
  double along_m = 0.005;  ///< Along the edge or bar ...
  double cross_m = 0.005;  ///< ... and across it.
  double depth_m = 0.002;  ///< Part of the sensor's noise that averaging leaves.
};

/// Where a hand holds the object, with its uncertainty (W, m, m^2).
struct ContactEstimate {
  Vec3 position = Vec3::Zero();  ///< In W (m).
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  HeldPart part = HeldPart::Face;
};

/// Place on the object that the hand holds: an edge or a round bar fixes it across, the hand's width along.
/// See docs/decisions/0003. `hand` must not be empty.
[[nodiscard]] ContactEstimate estimate_contact(std::span<const HandPoint> hand, const GraspedObject& object,
                                               const ContactNoise& noise);

}  // namespace colift::perception
