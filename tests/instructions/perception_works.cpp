// The frame of a table and of the person who takes hold of it, up to the decision.
#include <array>
#include <cstdlib>
#include <memory>
#include <optional>

#include "control/session/decide.hpp"
#include "control/session/pipeline.hpp"
#include "counted_work.hpp"
#include "perception/bodies/body_finder.hpp"
#include "perception/ground/ground.hpp"
#include "perception/map/world_map.hpp"
#include "perception/motion/object_motion.hpp"
#include "perception/self_filter.hpp"
#include "perception/surfaces/find_surfaces.hpp"
#include "perception/target/target.hpp"
#include "sim_hal/synthetic/kinect/kinect_noise.hpp"
#include "sim_hal/synthetic/scenes.hpp"

namespace colift::counted {
namespace {

constexpr std::uint64_t kSeed = 1;

/// Everything that a work may take as given. Ends the program where the scene is not understood: then there
/// is nothing to count.
struct Room {
  control::Config config;
  planner::HandModel hand;
  hal::SteadyClock clock;
  std::shared_ptr<const planner::HandCollision> tables =
      std::make_shared<const planner::HandCollision>(hand, config.candidates.collision);
  sim_hal::SyntheticScene scene = sim_hal::make_scene(sim_hal::ObjectKind::Table, kSeed);
  sim_hal::PartnerPose partner = sim_hal::make_partner(scene, kSeed, false);
  hal::DepthFrame empty = shoot(scene.world, kSeed);
  hal::DepthFrame held = shoot(sim_hal::with_partner(scene.world, partner), kSeed + 100);
  std::vector<hal::DepthFrame> reference_frames;
  perception::OrganisedCloud cloud = perception::deproject(empty, scene.X_WC);
  std::optional<control::SceneAnalysis> analysis;
  std::optional<perception::ReferenceImage> reference;

  Room() {
    auto seen = control::analyse_scene(input(), control::Method::Fast, config, hand, clock, tables);
    if (!seen || !seen->scene.target) std::abort();
    analysis = std::move(*seen);
    for (std::uint64_t i = 0; i < 10; ++i) reference_frames.push_back(shoot(scene.world, kSeed + i));
    auto built =
        perception::build_reference(reference_frames, scene.X_WC, config.noise, config.partner.reference);
    if (!built) std::abort();
    reference = std::move(*built);
  }

  [[nodiscard]] hal::DepthFrame shoot(const sim_hal::World& world, std::uint64_t seed) const {
    return sim_hal::measure(sim_hal::cast_rays(world, scene.intrinsics, scene.X_WC), {}, seed);
  }
  [[nodiscard]] control::SceneAnalysisInput input() const {
    control::SceneAnalysisInput in;
    in.frame = empty;
    in.X_WC = scene.X_WC;
    in.base_frame_known = true;
    return in;
  }
};

using RoomPtr = std::shared_ptr<Room>;

Work in_room(std::string name, std::string what, std::function<std::function<void()>(const RoomPtr&)> make) {
  return {std::move(name), std::move(what),
          [make = std::move(make)] { return make(std::make_shared<Room>()); }};
}

}  // namespace

std::vector<Work> perception_works() {
  using namespace perception;
  std::vector<Work> works;
  works.push_back(in_room("frame_to_target", "points, ground and target of one frame", [](const RoomPtr& r) {
    return [r] {
      const OrganisedCloud cloud = deproject(r->empty, r->scene.X_WC);
      const auto blocks = fit_block_planes(cloud, r->config.noise);
      const auto ground = find_ground(cloud, blocks, hal::Vec3::UnitZ(), r->config.noise, r->config.ground);
      (void)find_target(cloud, blocks, *ground.ground, r->config.noise, r->config.target);
    };
  }));
  works.push_back(in_room("surfaces", "faces of the target", [](const RoomPtr& r) {
    return [r] {
      const Scene& scene = r->analysis->scene;
      (void)find_surfaces(r->cloud, *scene.target, *scene.ground, r->config.noise, r->config.surfaces);
    };
  }));
  works.push_back(in_room("candidates", "grasp candidates of the object, judged", [](const RoomPtr& r) {
    return [r] {
      (void)planner::CandidateFinder(r->analysis->scene, &r->analysis->cloud, r->hand, r->config.candidates,
                                     r->tables)
          .find();
    };
  }));
  works.push_back(in_room("first_decide", "two frames to a decision", [](const RoomPtr& r) {
    return [r] {
      const auto seen =
          control::analyse_scene(r->input(), control::Method::Fast, r->config, r->hand, r->clock, r->tables);
      (void)control::decide(*seen, {std::nullopt, r->held}, r->config, r->clock);
    };
  }));
  works.push_back(in_room("decide_again", "a decision for a partner who is known", [](const RoomPtr& r) {
    auto outcome = control::decide(*r->analysis, {std::nullopt, r->held}, r->config, r->clock);
    if (!outcome || !outcome->partner) std::abort();
    return [r, partner = *outcome->partner] {
      (void)control::decide_for(*r->analysis, partner, r->config, r->clock);
    };
  }));
  works.push_back(in_room("partner_in_frame", "the partner in one frame of a run", [](const RoomPtr& r) {
    auto pipeline = control::make_pipeline(control::Method::Fast);
    auto hidden = std::make_shared<std::vector<char>>(r->cloud.size(), 0);
    auto sight = (*pipeline)->observe_partner({*r->reference, *r->analysis, *hidden}, r->config);
    if (!sight) std::abort();
    std::shared_ptr<control::PartnerSight> finder = std::move(*sight);
    std::vector<Eigen::Vector3f> points;
    (void)finder->find(r->held, points);  // the memory that is kept from frame to frame
    return [r, hidden, finder, points]() mutable { (void)finder->find(r->held, points); };
  }));
  works.push_back(in_room("reference", "ten frames of the scene averaged", [](const RoomPtr& r) {
    return [r] {
      (void)build_reference(r->reference_frames, r->scene.X_WC, r->config.noise, r->config.partner.reference);
    };
  }));
  works.push_back(in_room("follower", "what the object's motion is tracked by", [](const RoomPtr& r) {
    return [r] {
      (void)ObjectFollower::make(*r->reference, *r->analysis->scene.target, r->config.noise,
                                 r->config.object_motion);
    };
  }));
  works.push_back(in_room("object_motion", "the object's motion in one frame", [](const RoomPtr& r) {
    auto made = ObjectFollower::make(*r->reference, *r->analysis->scene.target, r->config.noise,
                                     r->config.object_motion);
    if (!made) std::abort();
    auto follower = std::make_shared<ObjectFollower>(std::move(*made));
    return [r, follower] { (void)follower->update(r->held); };
  }));
  works.push_back(in_room("bodies", "foreign bodies in one frame", [](const RoomPtr& r) {
    const std::vector<char> hidden(r->cloud.size(), 0);
    auto finder = std::make_shared<BodyFinder>(*r->reference, r->analysis->scene.target->points, hidden,
                                               r->config.noise, r->config.bodies);
    return [r, finder] { (void)finder->find(r->held, {}); };
  }));
  works.push_back(in_room("map_of_frame", "one frame entered into the collision map", [](const RoomPtr& r) {
    return [r] {
      WorldMap map(r->config.map);
      map.insert(r->analysis->cloud, r->analysis->scene.target->pixels);
      (void)map.grid();
    };
  }));
  return works;
}

}  // namespace colift::counted
