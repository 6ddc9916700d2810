#pragma once

#include <cstdint>
#include <span>

#include "hal/config/range.hpp"
#include "hal/depth_camera.hpp"
#include "perception/organised_cloud.hpp"

namespace colift::perception {

/// How the image of an object that was put down elsewhere is made.
struct MovedObjectConfig {
  int rim_px = 2;
  double max_depth_step_m = 0.03;

  template <class Visitor>
  void visit(Visitor& v) {
    v("rim_px", rim_px, hal::Range{0, 20},
      "Width around the object's old outline in which depths of two bodies mix and are left out (px).");
    v("max_depth_step_m", max_depth_step_m, hal::Range{0, 0.5},
      "Max depth difference of the pixels around a hole that is filled (m).");
  }
};

/// The image that the camera would see if the object stood a little elsewhere: its pixels are taken out and
/// put where they would be, nearer things hiding farther ones. What it hid before was never seen and stays
/// NaN, as do the pixels around its old outline, in which depths of two bodies mix. `object`: its pixels in
/// the image; `X` takes a point of it from where it stood to where it stands (W). Meant for motions of a few
/// centimetres: sides that come into view are not known.
[[nodiscard]] hal::DepthFrame move_object(const OrganisedCloud& cloud, std::span<const std::uint32_t> object,
                                          const hal::Pose& X_Wnow_Wthen,
                                          const MovedObjectConfig& config = {});

}  // namespace colift::perception
