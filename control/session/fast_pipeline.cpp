// CoLift's own method: everything on the image grid.

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "control/session/pipeline.hpp"
#include "perception/ground/block_planes.hpp"
#include "perception/shape/shape_completion.hpp"
#include "perception/surfaces/find_surfaces.hpp"
#include "perception/surfaces/pipe/lying_pipe.hpp"
#include "perception/target/target.hpp"

namespace colift::control {
namespace {

using namespace perception;

class FastSight final : public PartnerSight {
 public:
  FastSight(PartnerFinder finder, const hal::Pose& X_WC) : finder_(std::move(finder)), X_WC_(X_WC) {}

  hal::Result<PartnerObservation> find(const hal::DepthFrame& frame,
                                       std::vector<Eigen::Vector3f>& points) override {
    deproject(frame, X_WC_, cloud_);
    auto observation = finder_.find(cloud_);
    if (!observation) return observation;
    points.clear();
    for (const std::uint32_t p : observation->pixels)
      points.emplace_back(cloud_.x[p], cloud_.y[p], cloud_.z[p]);
    return observation;
  }

 private:
  PartnerFinder finder_;
  hal::Pose X_WC_;
  OrganisedCloud cloud_;  // of the last frame
};

TargetConfig on_table(TargetConfig config) {
  const OnTableConfig& table = config.on_table;
  config.max_height_m = table.max_height_m;
  config.max_cut = table.max_cut;
  config.max_floating_m = table.max_floating_m;
  config.min_on_ground = table.min_on_ground;
  config.min_confidence = table.min_confidence;
  config.top_cut_weight = table.top_cut_weight;
  return config;
}

bool may_be_person(const RejectedObject& o) {
  return o.kind == RejectedObject::Kind::Person;
}

// The first table top with an object on it becomes the ground. What was refused on the floor stays refused.
void look_on_tables(SceneAnalysis& out, const std::vector<BlockPlane>& blocks, const GroundResult& ground,
                    const Config& c, const SceneAnalysisInput& input, TargetResult& found) {
  const TargetConfig config = on_table(c.target);
  for (const Plane& plane : ground.tables) {
    const Ground table = refine_table(plane, out.cloud, c.noise, c.ground);
    TargetResult on = find_target(out.cloud, blocks, table, c.noise, config, input.at_W);
    if (!on.target) continue;
    on.reason = fmt::format("on a table {:.2f} m above the floor: {}",
                            ground.ground->plane.height(table.plane.foot(on.target->obb.center)), on.reason);
    on.target->reason = on.reason;
    on.rejected.insert(on.rejected.end(), found.rejected.begin(), found.rejected.end());
    found = std::move(on);
    out.scene.ground = table;
    return;
  }
}

class FastPipeline final : public Pipeline {
 public:
  void analyse(const SceneAnalysisInput& input, const Config& c, Stopwatch& watch,
               SceneAnalysis& out) const override {
    out.cloud = deproject(input.frame, input.X_WC);
    std::optional<hal::Vec3> up;
    if (input.base_frame_known)
      up = hal::Vec3::UnitZ();
    else if (input.frame.up_C)
      up = input.X_WC.linear() * *input.frame.up_C;

    const std::vector<BlockPlane> blocks = fit_block_planes(out.cloud, c.noise, c.ground.blocks);
    GroundResult ground = find_ground(out.cloud, blocks, up, c.noise, c.ground);
    out.ms.ground = watch.lap();
    out.scene.ground = ground.ground;
    out.scene.reason = ground.reason;
    if (!ground.ground) return;

    TargetResult found;
    if (c.support != "table")
      found = find_target(out.cloud, blocks, *ground.ground, c.noise, c.target, input.at_W);
    else
      found.reason = "no target: there is no table with an object on it";
    // beside a person: what stands on his chair or lies on his lap is no object on a table
    const bool nobody = std::none_of(found.rejected.begin(), found.rejected.end(), may_be_person);
    if (!found.target && c.support != "floor" && (nobody || c.support == "table"))
      look_on_tables(out, blocks, ground, c, input, found);
    out.ms.target = watch.lap();
    out.scene.reason = found.reason;
    out.rejected = std::move(found.rejected);
    if (!found.target) return;

    Target& target = *found.target;
    out.scene.surfaces = find_surfaces(out.cloud, target, *out.scene.ground, c.noise, c.surfaces);
    if (auto pipe =
            find_lying_pipe(out.cloud, target, out.scene.surfaces, *out.scene.ground, c.noise, c.surfaces)) {
      // the rest of it stays where it is
      target.pixels = std::move(pipe->pixels);
      measure_target(target, out.cloud, *out.scene.ground, c.target.box);
      out.scene.surfaces = {pipe->cylinder};
    }
    const CompletedShape shape =
        complete_shape(out.cloud, target, out.scene.surfaces, *out.scene.ground, c.noise, c.completion);
    target.cog = shape.cog;
    target.cog_covariance = shape.covariance;
    target.shape = shape.box;
    out.scene.target = std::move(target);
    out.ms.surfaces = watch.lap();
  }

  [[nodiscard]] bool judges_surroundings() const override { return true; }

  [[nodiscard]] std::vector<std::uint32_t> target_pixels(const SceneAnalysis& analysis,
                                                         const Config& /*config*/) const override {
    return analysis.scene.target->pixels;
  }

  [[nodiscard]] hal::Result<PartnerObservation> find_partner(const SceneAnalysis& analysis,
                                                             const hal::DepthFrame& frame,
                                                             const Config& c) const override {
    const auto reference =
        build_reference(std::array{analysis.frame}, analysis.cloud.X_WC, c.noise, c.partner.reference);
    if (!reference) return tl::unexpected(reference.error());
    auto finder =
        PartnerFinder::make(*reference, *analysis.scene.target, *analysis.scene.ground, c.noise, c.partner);
    if (!finder) return tl::unexpected(finder.error());
    return finder->find(deproject(frame, analysis.cloud.X_WC));
  }

  [[nodiscard]] hal::Result<std::unique_ptr<PartnerSight>> observe_partner(const ReferenceView& reference,
                                                                           const Config& c) const override {
    const Scene& scene = reference.analysis.scene;
    auto finder = PartnerFinder::make(reference.image, *scene.target, *scene.ground, c.noise, c.partner);
    if (!finder) return tl::unexpected(finder.error());
    return std::make_unique<FastSight>(std::move(*finder), reference.analysis.cloud.X_WC);
  }

  [[nodiscard]] int frames_per_sight(const Config&) const override { return 1; }
};

}  // namespace

std::unique_ptr<const Pipeline> fast_pipeline() {
  return std::make_unique<FastPipeline>();
}

}  // namespace colift::control
