#pragma once

#include <functional>
#include <optional>

#include "hal/config/range.hpp"
#include "perception/noise_model.hpp"
#include "perception/scene.hpp"
#include "perception/target/regions/silhouette.hpp"

namespace colift::perception {

/// What a head on shoulders looks like. Lengths: between small women and large men with hair and clothes
/// (head breadth and height, shoulder breadth: DIN 33402-2, 5th and 95th percentile, widened for noise).
struct PersonShapeConfig {
  double min_head_width_m = 0.11;
  double max_head_width_m = 0.30;
  double max_head_growth = 1.6;
  double min_head_arch_m = 0.015;
  double min_head_rise_m = 0.14;
  double max_head_rise_m = 0.40;
  double min_shoulder_width_m = 0.26;
  double min_shoulder_ratio = 1.3;
  double shoulder_reach_m = 0.35;
  double torso_length_m = 0.30;
  double min_torso_fill = 0.55;
  double min_torso_thickness_m = 0.058;
  double max_torso_depth_m = 0.38;
  double min_curvature_m = 0.010;
  double min_curvature_sigma = 1.6;
  double max_curvature_m = 0.075;
  double min_top_height_m = 0.7;

  template <class Visitor>
  void visit(Visitor& v) {
    v("min_head_width_m", min_head_width_m, hal::kPositive, "Min width of a head (m).");
    v("max_head_width_m", max_head_width_m, hal::kPositive, "Max width of a head (m).");
    v("max_head_growth", max_head_growth, hal::kPositive,
      "Max ratio of a head's width above the shoulders to that near its top.");
    v("min_head_arch_m", min_head_arch_m, hal::kNotNegative,
      "Min difference in height of the contour near a head's top (m): a board that is seen from its edge is "
      "level. The heads in recording 04: 28 to 51 mm.");
    v("min_head_rise_m", min_head_rise_m, hal::kPositive, "Min height of a head over the shoulders (m).");
    v("max_head_rise_m", max_head_rise_m, hal::kPositive, "Max height of a head over the shoulders (m).");
    v("min_shoulder_width_m", min_shoulder_width_m, hal::kPositive,
      "Min width of the shoulders, also of a person seen from the side (m).");
    v("min_shoulder_ratio", min_shoulder_ratio, hal::kPositive,
      "Min ratio of the shoulders' width to the head's.");
    v("shoulder_reach_m", shoulder_reach_m, hal::kPositive,
      "Max distance of a shoulder's end from the middle of the head, across the view (m).");
    v("torso_length_m", torso_length_m, hal::kPositive,
      "Length of the torso below the shoulders that has to be there (m).");
    v("min_torso_fill", min_torso_fill, hal::kFraction, "Min fraction of that torso that is seen.");
    v("min_torso_thickness_m", min_torso_thickness_m, hal::kNotNegative,
      "Min median thickness of that torso's parts across the view (m): the rails of a stepladder are "
      "thinner.");
    v("max_torso_depth_m", max_torso_depth_m, hal::kPositive,
      "Max difference in distance between torso and head (m).");
    v("min_curvature_m", min_curvature_m, hal::kNotNegative,
      "Min root mean square distance of the torso's points from a plane (m): fronts of furniture are flat.");
    v("min_curvature_sigma", min_curvature_sigma, hal::kNotNegative,
      "The same, in standard deviations of the depth noise.");
    v("max_curvature_m", max_curvature_m, hal::kPositive,
      "Max root mean square distance of the torso's points from a plane (m): a seat and its back rest are "
      "two planes.");
    v("min_top_height_m", min_top_height_m, hal::kNotNegative,
      "Min height of the head over the ground (m); a person who crouches or sits on the ground reaches it.");
  }
};

/// A head on shoulders that was found in an object.
struct HeadAndShoulders {
  Vec3 head = Vec3::Zero();  ///< Top of the head in W (m).
  double head_width_m = 0.0, rise_m = 0.0, shoulder_width_m = 0.0, curvature_m = 0.0;
};

/// A peak of the object's upper contour that is as wide and high as a head, over a curved torso at its own
/// distance. At any posture in which the head is up; nothing when the view cuts the head. `thickness`: how
/// thick the object's parts are within a window (m).
[[nodiscard]] std::optional<HeadAndShoulders> find_person(
    const Silhouette& silhouette, const NoiseModel& noise,
    const std::function<double(const Silhouette::Window&)>& thickness, const PersonShapeConfig& config = {});

}  // namespace colift::perception
