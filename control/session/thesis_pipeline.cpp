// The thesis's method, on point clouds and PCL (chapter 5).

#include <cmath>

#include "control/session/pipeline.hpp"
#include "perception/thesis/thesis_partner.hpp"
#include "perception/thesis/thesis_target.hpp"

namespace colift::control {
namespace {

using namespace perception;

// The chain takes some 0.3 s a frame with voxels of 5 mm: at 30 frames a second it gets every tenth.
constexpr int kFramesPerSight = 10;
constexpr double kBeside_m = 0.3;  // of the object's box: farther away nobody is looked for

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
        X_WC_(reference.look.cloud.X_WC),
        object_(reference.look.scene.target->points.begin(), reference.look.scene.target->points.end()),
        never_seen_(find_never_seen(reference.look.cloud, reference.robot_hid)) {
    const Target& target = *reference.look.scene.target;
    const hal::Vec3 beside = hal::Vec3::Constant(kBeside_m);
    near_.crop_min_m = config.crop_min_m.cwiseMax(target.aabb.min() - beside);
    near_.crop_max_m = config.crop_max_m.cwiseMin(target.aabb.max() + beside);
    before_ = thesis_cloud(reference.look.cloud, near_);
  }

  hal::Result<PartnerSighting> find(hal::DepthFrame& frame, std::vector<Eigen::Vector3f>& points) override {
    PartnerSighting sighting;
    for (const std::uint32_t p : never_seen_)
      if (p < frame.depth_m.size()) frame.depth_m[p] = NAN;
    const auto now = thesis_cloud(deproject(frame, X_WC_), near_);
    const auto changed = changed_points(before_, now, near_);
    sighting.grasp = thesis_grasp(changed, object_, near_, &sighting.because);
    sighting.kind = sighting.grasp ? PartnerKind::Grasp : PartnerKind::None;
    points.clear();
    if (sighting.grasp) points = thesis_person(changed, *sighting.grasp, near_);
    return sighting;
  }

 private:
  ThesisConfig near_;  ///< Passes what lies around the object only.
  hal::Pose X_WC_;
  std::vector<Eigen::Vector3f> object_;
  std::vector<std::uint32_t> never_seen_;  ///< Pixels that showed the robot or lay in its shadow then.
  PclCloud before_;
};

class ThesisPipeline final : public Pipeline {
 public:
  void analyse(const LookInput& input, const Config& c, Stopwatch& watch, Look& out) const override {
    out.cloud = deproject(input.frame, input.X_WC);
    out.scene = thesis_scene(out.cloud, c.thesis);
    out.ms.target = watch.lap();
  }

  [[nodiscard]] bool judges_surroundings() const override { return false; }

  [[nodiscard]] std::vector<std::uint32_t> target_pixels(const Look& look, const Config& c) const override {
    return thesis_pixels(look.cloud, *look.scene.target, c.thesis);
  }

  [[nodiscard]] hal::Result<PartnerSighting> find_partner(const Look& look, const hal::DepthFrame& frame,
                                                          const Config& c) const override {
    const auto before = thesis_cloud(look.cloud, c.thesis);
    const auto now = thesis_cloud(deproject(frame, look.cloud.X_WC), c.thesis);
    PartnerSighting sighting;
    sighting.grasp = thesis_partner(before, now, look.scene.target->points, c.thesis, &sighting.because);
    return sighting;
  }

  [[nodiscard]] hal::Result<std::unique_ptr<PartnerSight>> watch_partner(const ReferenceView& reference,
                                                                         const Config& c) const override {
    return std::make_unique<ThesisSight>(reference, c.thesis);
  }

  [[nodiscard]] int frames_per_sight() const override { return kFramesPerSight; }
};

}  // namespace

std::unique_ptr<const Pipeline> thesis_pipeline() {
  return std::make_unique<ThesisPipeline>();
}

}  // namespace colift::control
