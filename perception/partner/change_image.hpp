#pragma once

#include <cstdint>
#include <vector>

#include "perception/change_limit.hpp"
#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/reference_image.hpp"

namespace colift::perception {

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
