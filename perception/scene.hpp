#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "hal/types/geometry.hpp"

namespace colift::perception {

using hal::Aabb;
using hal::OrientedBox;
using hal::Plane;
using hal::Pose;
using hal::Vec3;

// All values in frame W and SI units. W is the robot base when the camera's pose is known, else the cloud's
// own frame.

/// The plane that the target stands on: floor or table top. Normal towards the camera's side.
struct Ground {
  Plane plane;
  std::size_t inliers =
      0;  ///< Points that the plane explains (the fast method counts one pixel in nine, times nine).
  double rms_m = 0.0;  ///< Root mean square distance of the inliers.
};

/// A planar face of the object: size.x() along u, size.y() along v, normal outwards; u, v, normal
/// right-handed.
struct Rectangle {
  Vec3 center = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();
  Vec3 u = Vec3::UnitX();
  Vec3 v = Vec3::UnitY();
  Eigen::Vector2d size = Eigen::Vector2d::Zero();
  double fill = 0.0;  ///< Part of the rectangle that is covered by points, 0 to 1.
};

/// A visible part of a cylinder: center is the middle of the axis segment.
struct Cylinder {
  Vec3 center = Vec3::Zero();
  Vec3 axis = Vec3::UnitZ();
  double radius = 0.0;
  double length = 0.0;
};

using Surface = std::variant<Rectangle, Cylinder>;

/// The object to be carried, as far as the camera sees it.
struct Target {
  std::vector<std::uint32_t>
      pixels;  ///< Its pixels, ascending; empty for the thesis method (its points are no pixels).
  std::vector<Eigen::Vector3f> points;  ///< Its visible points.
  Aabb aabb;                            ///< Of the visible points, along the axes of W.
  OrientedBox obb;                      ///< Of the visible points; third axis is the ground's normal.
  Vec3 cog = Vec3::Zero();              ///< Estimated centre of gravity.
  Eigen::Matrix3d cog_covariance = Eigen::Matrix3d::Zero();
  OrientedBox shape;  ///< The box that the completed shape fills; equals obb where nothing was completed.
  double confidence = 1.0;          ///< 0 to 1: that this is one whole object that stands free.
  std::vector<std::string> doubts;  ///< What speaks against it, in a person's words, with numbers.
  std::string reason;               ///< Why this object was chosen, in a person's words, with numbers.
};

/// What one look at a frame found. No ground or no target is a finding, not an error: `because` says why.
struct Scene {
  std::optional<Ground> ground;
  std::optional<Target> target;
  std::vector<Surface> surfaces;
  std::string reason;
};

/// Where the partner holds the object.
struct PartnerGrasp {
  Vec3 position = Vec3::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  std::size_t points =
      0;  ///< Changed points that the estimate rests on; 0 when the position was given by a person.
  std::optional<Vec3> skin =
      std::nullopt;  ///< Middle of the hands' visible skin: where it stays, no hand has moved (m).
};

}  // namespace colift::perception
