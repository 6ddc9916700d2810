#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"
#include "perception/thesis/pcl_cloud.hpp"
#include "perception/thesis/thesis_config.hpp"

namespace colift::perception {

/// The points that a frame is compared by: depth limits, pass-through and voxel grid, nothing removed.
[[nodiscard]] PclCloud thesis_cloud(const OrganisedCloud& frame, const ThesisConfig& config);

/// Points of `current` that are farther than partner_difference_m from every point of `reference`
/// (PCL's SegmentDifferences).
[[nodiscard]] PclCloud changed_points(const PclCloud& reference, const PclCloud& current,
                                      const ThesisConfig& config);

/// What a frame is compared with, and which of its points are: by partner_reference either the whole scene as
/// it was, or the object's cloud alone (thesis section 5.3.3). Then the ground, which the thesis's chain
/// takes out of every frame, is taken out here by its plane; what else stood there before is new in every
/// frame, and a partner's grasp where it is near enough to the object.
class ReferenceCloud {
 public:
  ReferenceCloud(const OrganisedCloud& before, std::span<const Eigen::Vector3f> object,
                 const std::optional<Ground>& ground, const ThesisConfig& config);

  /// The changed points of a frame's thesis_cloud().
  [[nodiscard]] PclCloud changed(const PclCloud& current, const ThesisConfig& config) const;

 private:
  PclCloud before_;
  std::optional<hal::Plane> ground_;  ///< Points on or below it are left out.
};

/// Where the partner holds the object (thesis section 5.3.3): the mean of the partner_points changed points
/// that are nearest to the object. `changed` are those of a frame against the cloud before the partner came,
/// `object` the target's points in that cloud; all in W. Its covariance is the scatter of those points, since
/// the palm is somewhere among them.
///
/// Nothing if fewer points changed, or if those lie farther than partner_reach_m from the object on average:
/// then somebody is in view and nobody holds the object. `because`, if given, is told which, with the
/// numbers.
[[nodiscard]] std::optional<PartnerGrasp> thesis_grasp(const PclCloud& changed,
                                                       std::span<const Eigen::Vector3f> object,
                                                       const ThesisConfig& config,
                                                       std::string* reason = nullptr);

/// The changed points that hang together with those of a grasp: the person's hand, arm and body, without the
/// ragged pixels that come and go at edges elsewhere. The thesis has no use for them; a planner that keeps
/// clear of the person has. W (m).
[[nodiscard]] std::vector<Eigen::Vector3f> thesis_person(const PclCloud& changed, const PartnerGrasp& grasp,
                                                         const ThesisConfig& config = {});

/// Grasp from both clouds.
[[nodiscard]] std::optional<PartnerGrasp> thesis_partner(const PclCloud& reference, const PclCloud& current,
                                                         std::span<const Eigen::Vector3f> object,
                                                         const ThesisConfig& config,
                                                         std::string* reason = nullptr);

}  // namespace colift::perception
