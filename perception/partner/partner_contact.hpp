#pragma once

#include <optional>
#include <span>
#include <vector>

#include "hal/config/range.hpp"
#include "hal/types/geometry.hpp"
#include "perception/partner/local_shape.hpp"

namespace colift::perception {

using hal::Vec3;

/// Sizes of a hand and of what it holds. Breadth, length and thickness of the palm and half a board's
/// thickness are those of the synthetic hand and objects (docs/decisions/0003).
struct ContactConfig {
  double hand_breadth_m = 0.082;
  double finger_radius_m = 0.010;
  double half_palm_m = 0.035;
  double palm_thickness_m = 0.028;
  double half_board_m = 0.012;
  double max_board_m = 0.05;
  double neighbourhood_m = 0.16;
  double end_margin_m = 0.012;
  double clear_advantage_m = 0.02;
  double around_bar_sigma_rad = 0.25;
  double frontal_angle_rad = 0.3;
  double max_finger_height_m = 0.035;
  double face_tolerance_m = 0.012;
  double max_finger_offset_m = 0.012;
  double max_edge_sine = 0.3;
  double min_finger_fraction = 0.1;
  double inside_tolerance_m = 0.005;
  double misplaced_cost_m = 0.25;
  double max_end_distance_m = 0.10;
  double end_width_m = 0.03;
  LocalShapeConfig shape;

  template <class Visitor>
  void visit(Visitor& v) {
    const hal::Range hand{0.001, 0.2}, length{0.0, 1.0};
    v("hand_breadth_m", hand_breadth_m, hal::Range{0.01, 0.2}, "Breadth of a palm with four fingers (m).");
    v("finger_radius_m", finger_radius_m, hand,
      "Radius of a finger: its middle lies so far behind the skin that is seen (m).");
    v("half_palm_m", half_palm_m, hand, "Half the length of a palm around a round bar (m).");
    v("palm_thickness_m", palm_thickness_m, hand, "Thickness of a palm on a round bar (m).");
    v("half_board_m", half_board_m, length, "Half the thickness of a board whose side is not seen (m).");
    v("max_board_m", max_board_m, length, "Max distance between a face and an edge that ends it (m).");
    v("neighbourhood_m", neighbourhood_m, hal::Range{0.02, 1.0},
      "Radius around a hand within which the object's shape is analysed (m).");
    v("end_margin_m", end_margin_m, length,
      "Min distance of a hand's middle from the visible end of an edge; visible ends come out about 15 mm "
      "short (m).");
    v("clear_advantage_m", clear_advantage_m, length,
      "Min advantage of the best edge over the second one without which the contact counts as uncertain "
      "(m).");
    v("around_bar_sigma_rad", around_bar_sigma_rad, hal::Range{0.0, 3.2},
      "Standard deviation of the palm's angle around a round bar (rad).");
    v("frontal_angle_rad", frontal_angle_rad, hal::Range{0.01, 3.2},
      "Max angle around a round bar, from the camera's side, at which the whole palm is seen (rad).");
    v("max_finger_height_m", max_finger_height_m, length,
      "Max height of skin over the face that it lies on (m).");
    v("face_tolerance_m", face_tolerance_m, length,
      "Max distance of the object's patches from their face (m).");
    v("max_finger_offset_m", max_finger_offset_m, length,
      "Max distance of skin on a face, measured along the face, from the nearest patch of the object (m).");
    v("max_edge_sine", max_edge_sine, hal::kFraction,
      "Max sine of the angle between a face and an edge that ends it.");
    v("min_finger_fraction", min_finger_fraction, hal::kFraction,
      "Min fraction of a hand's skin on one face for the fingers to lie on it.");
    v("inside_tolerance_m", inside_tolerance_m, length,
      "Max distance on the inner side of an edge at which skin still counts as beyond the edge (m).");
    v("misplaced_cost_m", misplaced_cost_m, length,
      "Cost of an edge that none of the hand's skin fits, as a distance (m).");
    v("max_end_distance_m", max_end_distance_m, length,
      "Max distance from the hand within which the end of a face is searched (m).");
    v("end_width_m", end_width_m, length,
      "Half the width of the strip that counts as the end of a face (m).");
    v("shape", shape, "How faces, edges and round bars are fitted near the hand.");
  }
};

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
                                               const ContactNoise& noise, const ContactConfig& config = {});

}  // namespace colift::perception
