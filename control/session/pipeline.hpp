#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "control/config/config.hpp"
#include "control/session/scene_analysis.hpp"
#include "control/session/stopwatch.hpp"
#include "hal/types/result.hpp"
#include "perception/partner/partner_grasp.hpp"
#include "perception/reference_image.hpp"

namespace colift::control {

/// The scene before anybody came.
struct ReferenceView {
  const perception::ReferenceImage& image;
  const SceneAnalysis& analysis;       ///< With a target and a ground.
  const std::vector<char>& robot_hid;  ///< By pixel: the robot was there in one of its frames.
};

/// Finds the partner in one frame after the other.
class PartnerSight {
 public:
  virtual ~PartnerSight() = default;
  /// In a frame of the same fixed camera without the robot's own pixels.
  /// `points` becomes what is seen of him (W).
  [[nodiscard]] virtual hal::Result<perception::PartnerObservation> find(
      const hal::DepthFrame& frame, std::vector<Eigen::Vector3f>& points) = 0;
};

/// What each method does its own way; everything else is shared, and where it behaves differently the
/// configuration says so (set_method_defaults()). Stateless, any thread.
class Pipeline {
 public:
  virtual ~Pipeline() = default;

  /// Finds ground, target, its surfaces and its centre of gravity: fills cloud, scene, rejected objects and
  /// times of `out`.
  virtual void analyse(const SceneAnalysisInput& input, const Config& config, Stopwatch& watch,
                       SceneAnalysis& out) const = 0;

  /// Whether candidates are judged against the whole cloud (surroundings, edges, unseen space), or against
  /// the object's points alone.
  [[nodiscard]] virtual bool judges_surroundings() const = 0;

  /// The target's pixels, ascending.
  [[nodiscard]] virtual std::vector<std::uint32_t> target_pixels(const SceneAnalysis& analysis,
                                                                 const Config& config) const = 0;

  /// What of the target is an obstacle in the collision world beside its points (W). The scene has a target.
  [[nodiscard]] virtual std::vector<hal::Vec3> target_obstacle(const SceneAnalysis& /*analysis*/,
                                                               const Config& /*config*/) const {
    return {};
  }

  /// The partner in a second frame, of the same size. The look has a target.
  [[nodiscard]] virtual hal::Result<perception::PartnerObservation> find_partner(
      const SceneAnalysis& analysis, const hal::DepthFrame& frame, const Config& config) const = 0;

  /// The partner in a running camera. Keeps no reference to its arguments.
  [[nodiscard]] virtual hal::Result<std::unique_ptr<PartnerSight>> observe_partner(
      const ReferenceView& reference, const Config& config) const = 0;

  /// The partner is looked for in one of so many frames.
  [[nodiscard]] virtual int frames_per_sight(const Config& config) const = 0;
};

/// Errors: BadConfig for a method that this build does not have.
[[nodiscard]] hal::Result<std::unique_ptr<const Pipeline>> make_pipeline(Method method);

/// For make_pipeline(); the second one exists in a build with the thesis's method only.
[[nodiscard]] std::unique_ptr<const Pipeline> fast_pipeline();
[[nodiscard]] std::unique_ptr<const Pipeline> thesis_pipeline();

}  // namespace colift::control
