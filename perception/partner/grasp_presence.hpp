#pragma once

#include <optional>

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
  double motion_radius_m = 0.08;
  double motion_floor_m = 0.0025;
  double motion_floor_fraction = 0.04;
  double motion_sigmas = 7.0;
  double motion_sigmas_twice = 5.5;
  double motion_gain = 0.1;
  double motion_variance_gain = 0.05;
  int motion_frames = 5;
  double motion_usual_sigmas = 4.0;
  double motion_max_growth = 2.2;

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
    v("motion_radius_m", motion_radius_m, hal::Range{0.02, 0.3},
      "Around his contact, within which the hand's motion against the object is observed (m).");
    v("motion_floor_m", motion_floor_m, hal::Range{0.0005, 0.05},
      "Min standard deviation of the hand's centroid; a larger one is learned while he holds (m).");
    v("motion_floor_fraction", motion_floor_fraction, hal::Range{0.005, 0.5},
      "Min standard deviation of its visible area, as a fraction of it.");
    v("motion_sigmas", motion_sigmas, hal::Range{1, 100},
      "It leaves when centroid and area deviate by so many standard deviations in one frame ...");
    v("motion_sigmas_twice", motion_sigmas_twice, hal::Range{1, 100}, "... or by so many in two in a row.");
    v("motion_gain", motion_gain, hal::Range{0.001, 1}, "Gain of a frame in the means of both.");
    v("motion_variance_gain", motion_variance_gain, hal::Range{0.001, 1}, "The same in their variances.");
    v("motion_frames", motion_frames, hal::Range{1, 100}, "Frames after which these count as known.");
    v("motion_usual_sigmas", motion_usual_sigmas, hal::Range{1, 100},
      "What deviates by more standard deviations teaches nothing about the noise.");
    v("motion_max_growth", motion_max_growth, hal::Range{1, 10},
      "With a larger multiple of the usual area something else came into view: a hand that opens shows more "
      "for some frames, then less.");
  }
};

/// What is at the partner's contact and is not the object, in one frame.
struct HandSighting {
  double area_m2 = 0.0;                      ///< Within PresenceConfig::radius_m of the contact.
  double motion_area_m2 = 0.0;               ///< Within motion_radius_m ...
  hal::Vec3 centroid_m = hal::Vec3::Zero();  ///< ... and its centroid, from the contact, in the reference.
};

/// Visible area and centroid of what is at the partner's contact and is not the object: pixels around it that
/// lie in front of the reference image, after the frame was taken back by the object's motion. Areas as if
/// every pixel faced the camera. Unset when the place is out of view.
///
/// \param reference  Image of the scene without the partner, with its points in W.
/// \param frame      Of the same camera, without the robot's pixels.
/// \param X_Wnow_Wref  Takes a point of the object from the reference to where it is now.
/// \param contact_W  His contact on the object as the reference shows it.
[[nodiscard]] std::optional<HandSighting> hand_at_contact(const OrganisedCloud& reference,
                                                          const hal::DepthFrame& frame,
                                                          const hal::Pose& X_Wnow_Wref,
                                                          const hal::Vec3& contact_W, const NoiseModel& noise,
                                                          const PresenceConfig& config);

}  // namespace colift::perception
