#pragma once

#include <cstdint>
#include <vector>

#include "hal/config/range.hpp"
#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"
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

/// A rectangle of pixels: begin included, end not.
struct PixelWindow {
  int u_begin = 0, v_begin = 0, u_end = 0, v_end = 0;
  [[nodiscard]] bool empty() const { return u_begin >= u_end || v_begin >= v_end; }
};

/// Changed pixels [u_begin, u_end) of row v that are one body.
struct ChangedRun {
  std::int32_t v = 0, u_begin = 0, u_end = 0;
  std::int32_t component = 0;
};

/// One connected body that stands before the reference image.
struct ChangedComponent {
  double area_m2 = 0.0;  ///< As if every pixel faced the camera: a lower bound of the true area.
  std::int32_t pixels = 0;
  /// Area of all components that hang together in the image, whatever their depths: fingers on the object and
  /// the arm behind its edge are two bodies to the camera, but one person (m^2).
  double blob_m2 = 0.0;
  PixelWindow box;  ///< Smallest window that holds it.
};

/// Finds what stands before the reference image, inside a window. Keeps its buffers from frame to frame, so
/// one object belongs to one thread.
class ChangeImage {
 public:
  ChangeImage(const ReferenceImage& reference, const NoiseModel& noise, const ChangeConfig& config,
              const PixelWindow& window);

  /// Compares a frame of the reference's size. Specks and slivers up to two pixels wide are gone from the
  /// answer, and so is the outermost pixel of every body, where depths of two bodies mix. Pixels without
  /// depth neither add nor take.
  void compare(const OrganisedCloud& current);

  [[nodiscard]] const std::vector<ChangedRun>& runs() const { return runs_; }
  [[nodiscard]] const std::vector<ChangedComponent>& components() const { return components_; }
  [[nodiscard]] const PixelWindow& window() const { return window_; }

  /// A depth below this is a change (m); NaN where nothing can be one. Indexed as the image.
  [[nodiscard]] float limit(std::size_t pixel) const { return limit_m_[pixel]; }

 private:
  void mark(const float* depth_m);
  void thin();
  void find_runs(const float* depth_m);
  void number_components();

  int width_;
  double pixel_area_;  ///< 1 / (fx fy).
  NoiseModel noise_;
  ChangeConfig config_;
  PixelWindow window_;
  std::size_t words_;  ///< 64-bit words for each row of a mask.
  std::vector<float> limit_m_;
  std::vector<std::uint64_t> mask_, unseen_, thinned_;
  std::vector<ChangedRun> runs_;
  std::vector<double> run_area_;
  std::vector<ChangedComponent> components_;
  std::vector<std::int32_t> parent_, blob_parent_;  ///< Union-find over runs.
  std::vector<double> blob_area_;
};

}  // namespace colift::perception
