#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

namespace colift::perception {

/// A point of a face in the face's own coordinates (m).
struct FacePoint {
  float s, t;
  bool sure = true;  ///< The camera saw what lies beside it, so a side here is known to end.
};

/// Rectangle in the face's own coordinates (m), as ranges along u and v.
struct FaceFrame {
  Eigen::Vector2d u;  ///< Unit.
  double low_u, high_u, low_v, high_v;

  [[nodiscard]] Eigen::Vector2d v() const { return {-u.y(), u.x()}; }
  [[nodiscard]] double width() const { return high_u - low_u; }
  [[nodiscard]] double height() const { return high_v - low_v; }
};

/// By how much (m) a pixel's step in the image moves on the face.
struct PixelStep {
  Eigen::Vector2d along_row = Eigen::Vector2d::Zero(), along_column = Eigen::Vector2d::Zero();

  [[nodiscard]] double longest() const { return std::max(along_row.norm(), along_column.norm()); }
};

/// The rectangle of least area around points; of several that are about as small, the one along whose sides
/// most of them lie. `pixel_m`: distance of neighbouring points.
[[nodiscard]] FaceFrame bounding_frame(const std::vector<FacePoint>& points, double pixel_m);

/// The same rectangle turned and drawn in to where its sides are: a side is the median of what lies outermost
/// along it, since edges in depth images are ragged.
[[nodiscard]] FaceFrame trimmed(const FaceFrame& outer, const std::vector<FacePoint>& points,
                                const PixelStep& step);

}  // namespace colift::perception
