#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "perception/surfaces/face_frame.hpp"
#include "perception/surfaces/plane_growing.hpp"

namespace colift::perception {

/// What the camera saw at a place of a face. Unknown: nothing, or something nearer.
enum class CoverCell : std::uint8_t { Covered, Empty, Unknown };

struct CoverGrid {
  int columns = 0, rows = 0;
  std::vector<CoverCell> cells;

  [[nodiscard]] CoverCell at(int c, int r) const { return cells[static_cast<std::size_t>(r * columns + c)]; }
};

/// Cells of a rectangle by what is there.
struct Fill {
  double covered = 0, empty = 0, unknown = 0;

  [[nodiscard]] double ratio() const { return covered > 0 ? covered / (covered + empty) : 0.0; }
  [[nodiscard]] double known() const { return covered / (covered + empty + unknown); }
};
[[nodiscard]] Fill fill_of(const CoverGrid& grid);

/// A line that cuts a rectangle in two: across u at `at` (m), or across v.
struct Cut {
  bool along_u = true;
  double at = 0;
  double cost = std::numeric_limits<double>::infinity();
};
/// Where parts covered are told from empty places best.
[[nodiscard]] Cut best_cut(const CoverGrid& grid, const FaceFrame& frame);

/// Looks at places of one face in the image.
class FaceLook {
 public:
  /// `origin`, `e1`, `e2` (W): the face's own coordinates. `slant`: slant_of() the face.
  FaceLook(const OrganisedCloud& cloud, const ObjectImage& image, int label, double slant,
           double tolerance_sigma, const hal::Vec3& origin, const hal::Vec3& e1, const hal::Vec3& e2);

  /// Cells of about 1.2 pixels, 40 along a side at most.
  [[nodiscard]] CoverGrid grid_of(const FaceFrame& frame, double pixel_m) const;

 private:
  [[nodiscard]] CoverCell look(const hal::Vec3& pixel) const;

  const OrganisedCloud& cloud_;
  const ObjectImage& image_;
  int label_;
  double slant_, tolerance_sigma_;
  // homogeneous coordinates (U d, V d, d) in the object image of the face's origin and for a metre along s, t
  hal::Vec3 origin_, s_, t_;
};

}  // namespace colift::perception
