#pragma once

#include "hal/config/range.hpp"
#include "hal/depth_camera.hpp"
#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"

namespace colift::perception {

/// What counts as a hand that is still at its grasp. SI units.
struct PresenceConfig {
  double radius_m = 0.05;
  double margin_m = 0.01;
  double sigmas = 2.0;
  int edge_px = 2;
  double min_area_m2 = 0.0004;
  double gone_fraction = 0.12;
  double back_fraction = 0.2;
  int frames = 1;

  template <class Visitor>
  void visit(Visitor& v) {
    v("radius_m", radius_m, hal::Range{0.02, 0.3},
      "Around his contact, within which a hand is looked for (m).");
    v("margin_m", margin_m, hal::Range{0, 0.1},
      "Min distance of a hand's pixel in front of the object or what is behind it (m) ...");
    v("sigmas", sigmas, hal::Range{0, 20}, "... plus this many standard deviations of the depth noise.");
    v("edge_px", edge_px, hal::Range{0, 8}, "Raggedness of the object's edges (px).");
    v("min_area_m2", min_area_m2, hal::Range{0, 0.1},
      "A hand that shows less is not observed there: nothing is said about it (m^2).");
    v("gone_fraction", gone_fraction, hal::kFraction,
      "The hand has left when less than this fraction of it is seen ...");
    v("frames", frames, hal::Range{1, 30}, "... in so many frames in a row.");
    v("back_fraction", back_fraction, hal::kFraction, "It is back when more than this fraction is seen.");
  }
};

/// Visible area of what is at the partner's contact and is not the object (m^2): pixels within
/// PresenceConfig::radius_m of it that lie in front of the reference image, after the frame was taken back by
/// the object's motion. As if every pixel faced the camera. NaN when the place is out of view.
///
/// \param reference  Image of the scene without the partner, with its points in W.
/// \param frame      Of the same camera, without the robot's pixels.
/// \param X_Wnow_Wref  Takes a point of the object from the reference to where it is now.
/// \param contact_W  His contact on the object as the reference shows it.
[[nodiscard]] double area_at_grasp(const OrganisedCloud& reference, const hal::DepthFrame& frame,
                                   const hal::Pose& X_Wnow_Wref, const hal::Vec3& contact_W,
                                   const NoiseModel& noise, const PresenceConfig& config);

}  // namespace colift::perception
