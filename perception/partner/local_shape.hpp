#pragma once

#include <optional>
#include <span>
#include <vector>

#include "hal/config/range.hpp"
#include "hal/types/geometry.hpp"

namespace colift::perception {

/// What counts as a face, an edge or a round bar near a hand.
struct LocalShapeConfig {
  double face_tolerance_m = 0.010;
  double line_tolerance_m = 0.010;
  double max_bar_residual_m = 0.007;
  double min_bar_radius_m = 0.010;
  double max_bar_radius_m = 0.10;
  double min_rim_length_m = 0.05;

  template <class Visitor>
  void visit(Visitor& v) {
    v("face_tolerance_m", face_tolerance_m, hal::Range{0.001, 0.1},
      "Max distance of a point from its face (m).");
    v("line_tolerance_m", line_tolerance_m, hal::Range{0.001, 0.1},
      "Max distance of a point of the outline from its straight edge (m).");
    v("max_bar_residual_m", max_bar_residual_m, hal::Range{0.0, 0.1},
      "Max root mean square distance of a round bar's points from its circle (m).");
    v("min_bar_radius_m", min_bar_radius_m, hal::Range{0.001, 1.0}, "Min radius of a round bar (m).");
    v("max_bar_radius_m", max_bar_radius_m, hal::Range{0.001, 1.0}, "Max radius of a round bar (m).");
    v("min_rim_length_m", min_rim_length_m, hal::Range{0.0, 1.0},
      "Min length of a straight edge of the outline (m).");
  }
};

/// A straight edge of an object: point + t direction with t from begin to end (m).
struct EdgeLine {
  Eigen::Vector3f point = Eigen::Vector3f::Zero();
  Eigen::Vector3f direction = Eigen::Vector3f::UnitX();
  float begin = 0.0F, end = 0.0F;
  bool corner = false;  ///< Two faces are seen to meet here; else a face just ends.
};

/// Axis and radius of a round bar (m).
struct RoundBar {
  Eigen::Vector3f point = Eigen::Vector3f::Zero(), direction = Eigen::Vector3f::UnitX();
  float radius = 0.0F;
};

/// A flat part: normal towards the camera.
struct LocalFace {
  Eigen::Vector3f point = Eigen::Vector3f::Zero(), normal = Eigen::Vector3f::UnitZ();
  int points = 0;
};

/// What an object looks like within a radius of a place: its faces, straight edges, or the round bar that it
/// is. Read from a surface thinned to some hundred points, so that it can be asked for every frame (some 10
/// us).
class LocalShape {
 public:
  LocalShape(std::span<const Eigen::Vector3f> surface, std::span<const Eigen::Vector3f> outline,
             const Eigen::Vector3f& eye, const Eigen::Vector3f& place, float radius_m,
             const LocalShapeConfig& config = {});

  [[nodiscard]] const std::vector<LocalFace>& faces() const { return faces_; }
  [[nodiscard]] const std::vector<EdgeLine>& edges() const { return edges_; }
  [[nodiscard]] const std::optional<RoundBar>& round_bar() const { return bar_; }

 private:
  void find_faces();
  void find_corners();
  void find_rims();
  void find_bar(const std::vector<Eigen::Vector3f>& surface);

  LocalShapeConfig config_;
  Eigen::Vector3f eye_;
  float radius_;
  std::vector<Eigen::Vector3f> surface_, outline_;  ///< Within the radius, about the place.
  Eigen::Vector3f place_;
  std::vector<std::int8_t> face_of_;
  std::vector<LocalFace> faces_;
  std::vector<EdgeLine> edges_;
  std::optional<RoundBar> bar_;
};

}  // namespace colift::perception
