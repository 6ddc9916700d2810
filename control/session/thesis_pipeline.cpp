// The thesis's method, on point clouds and PCL (chapter 5).

#include <cmath>

#include "control/session/pipeline.hpp"
#include "perception/thesis/thesis_mesh.hpp"
#include "perception/thesis/thesis_partner.hpp"
#include "perception/thesis/thesis_target.hpp"

namespace colift::control {
namespace {

using namespace perception;

// What the robot hid from the reference and uncovers later is new to a difference of clouds, though nothing
// has changed there. Where the projector's light did not come past it there is no depth beside it in the row.
std::vector<std::uint32_t> find_never_seen(const OrganisedCloud& cloud, const std::vector<char>& robot_hid) {
  std::vector<std::uint32_t> never_seen;
  const auto width = static_cast<std::size_t>(cloud.width());
  if (width == 0 || robot_hid.size() != cloud.depth_m.size()) return never_seen;
  for (std::size_t row = 0; row < robot_hid.size(); row += width) {
    for (std::size_t i = row; i < row + width;) {
      std::size_t end = i;
      bool by_robot = false;
      const auto dark = [&](std::size_t p) { return robot_hid[p] != 0 || !(cloud.depth_m[p] > 0.0f); };
      for (; end < row + width && dark(end); ++end) by_robot = by_robot || robot_hid[end] != 0;
      for (; by_robot && i < end; ++i) never_seen.push_back(static_cast<std::uint32_t>(i));
      i = end + 1;
    }
  }
  return never_seen;
}

class ThesisSight final : public PartnerSight {
 public:
  ThesisSight(const ReferenceView& reference, const ThesisConfig& config)
      : near_(config),
        X_WC_(reference.analysis.cloud.X_WC),
        object_(reference.analysis.scene.target->points.begin(),
                reference.analysis.scene.target->points.end()),
        never_seen_(find_never_seen(reference.analysis.cloud, reference.robot_hid)) {
    const Target& target = *reference.analysis.scene.target;
    const hal::Vec3 beside = hal::Vec3::Constant(config.partner_margin_m);
    near_.crop_min_m = config.crop_min_m.cwiseMax(target.aabb.min() - beside);
    near_.crop_max_m = config.crop_max_m.cwiseMin(target.aabb.max() + beside);
    before_.emplace(reference.analysis.cloud, object_, reference.analysis.scene.ground, near_);
  }

  hal::Result<PartnerObservation> find(const hal::DepthFrame& whole,
                                       std::vector<Eigen::Vector3f>& points) override {
    PartnerObservation observation;
    hal::DepthFrame frame = whole;
    for (const std::uint32_t p : never_seen_)
      if (p < frame.depth_m.size()) frame.depth_m[p] = NAN;
    const auto now = thesis_cloud(deproject(frame, X_WC_), near_);
    const auto changed = before_->changed(now, near_);
    observation.grasp = thesis_grasp(changed, object_, near_, &observation.reason);
    observation.kind = observation.grasp ? PartnerKind::Grasp : PartnerKind::None;
    points.clear();
    if (observation.grasp) points = thesis_person(changed, *observation.grasp, near_);
    return observation;
  }

 private:
  ThesisConfig near_;  ///< Passes what lies around the object only.
  hal::Pose X_WC_;
  std::vector<Eigen::Vector3f> object_;
  std::vector<std::uint32_t> never_seen_;  ///< Pixels that showed the robot or lay in its shadow then.
  std::optional<ReferenceCloud> before_;
};

class ThesisPipeline final : public Pipeline {
 public:
  void analyse(const SceneAnalysisInput& input, const Config& c, Stopwatch& watch,
               SceneAnalysis& out) const override {
    out.cloud = deproject(input.frame, input.X_WC);
    out.scene = thesis_scene(out.cloud, c.thesis);
    out.ms.target = watch.lap();
  }

  [[nodiscard]] bool judges_surroundings() const override { return false; }

  [[nodiscard]] std::vector<std::uint32_t> target_pixels(const SceneAnalysis& analysis,
                                                         const Config& c) const override {
    return thesis_pixels(analysis.cloud, *analysis.scene.target, c.thesis);
  }

  [[nodiscard]] hal::Result<PartnerObservation> find_partner(const SceneAnalysis& analysis,
                                                             const hal::DepthFrame& frame,
                                                             const Config& c) const override {
    const auto& object = analysis.scene.target->points;
    const ReferenceCloud before(analysis.cloud, object, analysis.scene.ground, c.thesis);
    const auto now = thesis_cloud(deproject(frame, analysis.cloud.X_WC), c.thesis);
    PartnerObservation observation;
    observation.grasp = thesis_grasp(before.changed(now, c.thesis), object, c.thesis, &observation.reason);
    return observation;
  }

  [[nodiscard]] hal::Result<std::unique_ptr<PartnerSight>> observe_partner(const ReferenceView& reference,
                                                                           const Config& c) const override {
    return std::make_unique<ThesisSight>(reference, c.thesis);
  }

  [[nodiscard]] std::vector<hal::Vec3> target_obstacle(const SceneAnalysis& analysis,
                                                       const Config& c) const override {
    if (c.thesis.mesh_edge_m <= 0.0) return {};
    return points_on(triangulate(analysis.cloud, target_pixels(analysis, c), c.thesis), 0.5 * c.map.cell_m);
  }

  [[nodiscard]] int frames_per_sight(const Config& c) const override { return c.thesis.frames_per_sight; }
};

}  // namespace

std::unique_ptr<const Pipeline> thesis_pipeline() {
  return std::make_unique<ThesisPipeline>();
}

}  // namespace colift::control
