#pragma once

#include <vector>

#include "hal/config/range.hpp"
#include "perception/noise_model.hpp"
#include "perception/reference_image.hpp"

namespace colift::perception {

/// When a pixel counts as changed, and which changed pixels belong together.
struct ChangeConfig {
  double sigmas = 2.0;      ///< Nearer than the reference by this many sigma ...
  double steps = 0.25;      ///< ... plus this many quantisation steps ...
  double margin_m = 0.002;  ///< ... plus this much: drift and radial distortion of the sensor.
  int edge_px = 2;  ///< Raggedness of edges: a pixel is compared with the nearest depth within this distance.
  double jump_m = 0.03;  ///< Neighbours farther apart in depth than this (plus noise) are different bodies.
  double edge_step_m = 0.04;  ///< A depth step within the raggedness of edges that no sloping surface makes.
  double shadow_step_m =
      0.08;  ///< Two sides of a hole that differ by more are an object and what is behind it.

  template <class Visitor>
  void visit(Visitor& v) {
    v("sigmas", sigmas, hal::Range{0.0, 20.0},
      "Min difference of a changed pixel from the reference, in standard deviations of the depth noise.");
    v("steps", steps, hal::Range{0.0, 10.0}, "The same, in quantisation steps.");
    v("margin_m", margin_m, hal::Range{0.0, 0.1},
      "The same, constant part: drift and distortion of the sensor (m).");
    v("edge_px", edge_px, hal::Range{0.0, 5.0}, "Max shift of depth edges between frames (px).");
    v("jump_m", jump_m, hal::Range{0.005, 0.5},
      "Min depth step between neighbours that separates two bodies (m).");
    v("edge_step_m", edge_step_m, hal::Range{0.0, 1.0},
      "Min depth step within edge_px that is an edge and not a sloping surface (m).");
    v("shadow_step_m", shadow_step_m, hal::Range{0.0, 2.0},
      "Min depth step between the sides of a hole without depth that is the shadow of an edge (m).");
  }
};

/// By how much a depth must differ from another one to count as changed: what noise, quantisation and drift
/// explain (ChangeConfig::sigmas, steps, margin_m).
struct ChangeMargin {
  float constant_m = 0.0F, per_m = 0.0F;  ///< Both in metres of depth difference; the second times depth².

  ChangeMargin(const NoiseModel& noise, const ChangeConfig& config);
  [[nodiscard]] float of_squared(float depth_squared) const { return constant_m + per_m * depth_squared; }
  [[nodiscard]] float operator()(float depth_m) const { return of_squared(depth_m * depth_m); }
};

/// A rectangle of pixels: begin included, end not.
struct PixelWindow {
  int u_begin = 0, v_begin = 0, u_end = 0, v_end = 0;
  [[nodiscard]] bool empty() const { return u_begin >= u_end || v_begin >= v_end; }
};

/// The depth of each pixel below which a later frame shows something that stands before the scene of the
/// reference (m); NaN outside of the window. Noise, quantisation and ragged edges are allowed for; where the
/// reference has a hole, its sides stand for it. Indexed as the image.
[[nodiscard]] std::vector<float> change_limits(const ReferenceImage& reference, const NoiseModel& noise,
                                               const ChangeConfig& config, const PixelWindow& window);

}  // namespace colift::perception
