#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hal/config/range.hpp"
#include "hal/depth_camera.hpp"
#include "perception/bodies/block_grid.hpp"
#include "perception/bodies/limit_renewal.hpp"
#include "perception/change_limit.hpp"
#include "perception/noise_model.hpp"
#include "perception/object_grid.hpp"
#include "perception/reference_image.hpp"

namespace colift::perception {

/// What counts as a foreign body. SI units.
struct BodyConfig {
  ChangeConfig change{.sigmas = 4.0, .steps = 1.0, .margin_m = 0.015, .edge_px = 3};
  double robot_padding_m = 0.03;
  double min_body_m2 = 0.004;
  double min_part_m2 = 0.001;
  int min_block_px = 5;
  double max_unknown_fraction = 0.6;
  double jump_m = 0.10;
  double join_m = 0.12;
  double object_margin_m = 0.02;
  double moved_object_margin_m = 0.04;
  double max_foot_m2 = 0.02;
  double hidden_m = 0.25;
  int max_points = 300;

  template <class Visitor>
  void visit(Visitor& v) {
    v("change", change, "Which pixels stand before the known scene.");
    v("robot_padding_m", robot_padding_m, hal::Range{0, 0.2},
      "Padding of the links within which a pixel is the robot's own (m).");
    v("min_body_m2", min_body_m2, hal::Range{0, 1},
      "Min visible area of a body: a hand with its wrist shows more (m^2).");
    v("min_part_m2", min_part_m2, hal::Range{0, 1}, "Min visible area of a connected part of a body (m^2).");
    v("min_block_px", min_block_px, hal::Range{1, 16},
      "Min number of foreign pixels in a block of 4 x 4 that belongs to a body.");
    v("max_unknown_fraction", max_unknown_fraction, hal::kFraction,
      "A part with more of its area where the robot hid the scene in the reference is no body.");
    v("jump_m", jump_m, hal::Range{0.01, 1}, "Min depth step between two connected parts (m).");
    v("join_m", join_m, hal::Range{0, 1}, "Parts of one body are at most this far apart (m).");
    v("object_margin_m", object_margin_m, hal::Range{0, 0.2},
      "What is this near to the object's known surface is the object (m).");
    v("moved_object_margin_m", moved_object_margin_m, hal::Range{0, 0.2},
      "The same while the object is carried: sides come into view that were not seen before (m).");
    v("max_foot_m2", max_foot_m2, hal::Range{0, 1},
      "Max visible area of a flat foot of the object that counted as ground: what rises with the object from "
      "where the ground was seen under it (m^2). 0: there is none.");
    v("hidden_m", hidden_m, hal::Range{0, 2},
      "Depth of the space behind a body's visible side that counts as the body: nobody observes it (m).");
    v("max_points", max_points, hal::Range{20, 5000}, "Max number of points that stand for one body.");
  }
};

/// A visible point of a body and the unobserved space behind it, along the camera's ray.
struct BodyPoint {
  Eigen::Vector3f p_W = Eigen::Vector3f::Zero();
  Eigen::Vector3f away = Eigen::Vector3f::Zero();  ///< Unit vector away from the camera.
  float hidden_m = 0.0F;
};

/// Something in one frame that is neither robot nor object nor known scene.
struct Body {
  std::size_t first = 0, count = 0;  ///< Its points in BodyFinder::points().
  double area_m2 = 0.0;              ///< As if every pixel faced the camera: a lower bound.
  hal::Aabb box;                     ///< Of its visible points, W.
  hal::Vec3 center = hal::Vec3::Zero();
  bool whole = true;     ///< Not cut off by the image's left, right or upper border.
  bool top_seen = true;  ///< Not cut off by its upper border.
};

/// Finds foreign bodies in frames of a camera at rest. A pixel is foreign when it is nearer than the
/// reference by more than the noise explains, and neither the robot's nor the object's; where something was
/// carried off the reference is what stands behind it (LimitRenewal). Blocks of 4 x 4
/// pixels that hold enough of them are connected over the image and, across gaps, in space; so bodies with
/// half of their pixels missing stay whole. Keeps its buffers: does not allocate once bodies of that size
/// were seen. One finder, one thread.
class BodyFinder {
 public:
  /// `object`: visible points of the target in the reference (W); may be empty. `robot_hid`: by pixel, not 0
  /// where the robot hid what is behind it in the reference; may be empty. What appears there alone, when the
  /// arm has left, is unknown scene and no body.
  BodyFinder(const ReferenceImage& reference, std::span<const Eigen::Vector3f> object,
             std::span<const char> robot_hid, const NoiseModel& noise, const BodyConfig& config);

  /// `frame`: the robot's pixels are NaN; `robot`: which those are, ascending; `X_WTnow_WTref`: how the
  /// object has moved since the reference. Largest body first. A frame of another size shows no body. Valid
  /// until the next call.
  const std::vector<Body>& find(const hal::DepthFrame& frame, std::span<const std::uint32_t> robot,
                                const hal::Pose& X_WTnow_WTref = hal::Pose::Identity());

  [[nodiscard]] const std::vector<BodyPoint>& points() const { return points_; }
  [[nodiscard]] std::span<const BodyPoint> points(const Body& body) const {
    return std::span(points_).subspan(body.first, body.count);
  }

 private:
  struct Part {
    double area_m2 = 0.0, unknown_m2 = 0.0;  // of it, where the reference knows nothing
    double risen_m2 = 0.0;                   // of it, ground that has moved with the object
    hal::Aabb box;
    std::size_t first = 0, count = 0;  // of its blocks in order_
    int body = -1;
  };
  void mark(const std::vector<float>& depth_m);
  void leave_out_robot(std::span<const std::uint32_t> robot);
  void place_blocks(const hal::Pose& X_WTnow_WTref);
  /// The reference shows a surface at this point, right under the object: its foot, which counted as ground.
  [[nodiscard]] bool was_ground_under_object(const Eigen::Vector3f& p_W) const;
  void connect();
  void grow_part(std::size_t seed);
  void join_parts();
  void make_body(int number);
  /// By block, not 0 where the reference shows the object, or beside that.
  [[nodiscard]] std::vector<std::uint8_t> object_blocks() const;

  BodyConfig config_;
  NoiseModel noise_;
  hal::CameraIntrinsics intrinsics_;
  Eigen::Isometry3f X_CW_;
  Eigen::Vector3f eye_;
  double pixel_area_ = 0.0;
  ObjectGrid object_;
  bool has_object_ = false;
  Eigen::AlignedBox3f under_object_;       // in the reference, W; empty without an object
  std::vector<float> limit_m_, behind_m_;  // by pixel; by block
  BlockGrid grid_;
  std::vector<Eigen::Vector3f> ray_;  // of each block, W, z along the optical axis is 1

  // by block
  std::vector<float> row_sum_, row_count_, depth_, count_;
  std::vector<std::uint8_t> robot_, foreign_, unknown_, risen_;
  std::vector<Eigen::Vector3f> point_;
  std::optional<LimitRenewal> renewal_;
  std::vector<std::uint32_t> order_, stack_;
  std::vector<Part> parts_;
  std::vector<Body> bodies_;
  std::vector<BodyPoint> points_;
};

}  // namespace colift::perception
