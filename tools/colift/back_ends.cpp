#include "tools/colift/back_ends.hpp"

#include "hal/config/config_file.hpp"
#include "hal/guarded_arm.hpp"
#include "hal/guarded_hand.hpp"
#include "sim_hal/mujoco/sim_devices.hpp"
#include "sim_hal/mujoco/sim_world.hpp"
#include "sim_hal/scenario/scenario.hpp"

namespace colift::tools {
namespace {

/// Which devices a rig has: the file behind --robot.
struct RobotFile {
  std::string arm = "simulated", hand = "simulated", camera = "simulated";
  std::string model;
  double arm_period_ms = 5.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("arm", arm, hal::Choices{"simulated"}, "Back end of the arm.");
    v("hand", hand, hal::Choices{"simulated"}, "Back end of the hand.");
    v("camera", camera, hal::Choices{"simulated"}, "Back end of the camera.");
    v("model", model, "URDF of arm and hand; empty: the built-in LWR 4+ with BarrettHand.");
    v("arm_period_ms", arm_period_ms, hal::Range{1, 20},
      "Time between two commands of the simulated arm (ms).");
  }
};

picture::Solid to_solid(const sim_hal::Shape& shape) {
  using From = sim_hal::Shape::Kind;
  using To = picture::Solid::Kind;
  using picture::SolidRole;
  picture::Solid s;
  s.X_WS = shape.X_WS;
  s.size = shape.size;
  switch (shape.kind) {
    case From::Box:
      s.kind = To::Box;
      break;
    case From::Cylinder:
      s.kind = To::Cylinder;
      break;
    case From::Capsule:
      s.kind = To::Capsule;
      break;
    case From::Sphere:
      s.kind = To::Sphere;
      break;
    case From::HalfSpace:
      s.kind = To::Ground;
      break;
  }
  switch (shape.label) {
    case sim_hal::Label::Ground:
      s.role = SolidRole::Ground;
      break;
    case sim_hal::Label::Target:
      s.role = SolidRole::Target;
      break;
    case sim_hal::Label::Partner:
      s.role = SolidRole::Partner;
      break;
    case sim_hal::Label::Robot:
      s.role = SolidRole::Robot;
      break;
    case sim_hal::Label::Wall:
      s.role = SolidRole::Wall;
      break;
    case sim_hal::Label::Clutter:
    case sim_hal::Label::Nothing:
      s.role = SolidRole::Clutter;
      break;
  }
  return s;
}

RigTruth truth_of(const std::shared_ptr<sim_hal::SimWorld>& world,
                  const std::shared_ptr<const hal::RobotModel>& model) {
  RigTruth truth;
  const sim_hal::SimTruth at_start = world->truth();
  truth.mass_kg = at_start.mass_kg;
  truth.cog = at_start.cog_W;
  truth.sample = [world](hal::Timestamp began) {
    const sim_hal::SimTruth t = world->truth();
    return TruthSample{hal::seconds(t.at - began),
                       t.robot_force_W.z(),
                       t.partner_force_W.z(),
                       t.floor_force_W.z(),
                       t.tilt_rad,
                       t.height_m,
                       t.slip_m};
  };
  truth.partner = [world] { return world->truth().partner_W; };
  truth.scene = [world, model] {
    picture::SolidScene scene;
    for (const sim_hal::Shape& shape : world->shapes().shapes)
      if (shape.label != sim_hal::Label::Robot) scene.solids.push_back(to_solid(shape));
    // from the model: arm and hand have colours of their own
    const auto robot =
        picture::robot_solids(*model, world->arm_state().q_rad, hal::posture_of(world->hand_state()));
    scene.solids.insert(scene.solids.end(), robot.begin(), robot.end());
    return scene;
  };
  return truth;
}

hal::Result<sim_hal::Scenario> read_scenario(const std::optional<std::filesystem::path>& file) {
  if (file) return sim_hal::load_scenario(*file);
  return sim_hal::built_in_scenario();
}

}  // namespace

hal::Result<RunTask> read_task(const std::optional<std::filesystem::path>& scenario) {
  const auto read = read_scenario(scenario);
  if (!read) return tl::unexpected(read.error());
  return RunTask{read->name, read->task.height, read->task.hold_s};
}

hal::Result<Rig> open_rig(const std::optional<std::filesystem::path>& robot,
                          const std::optional<std::filesystem::path>& scenario, std::uint64_t seed,
                          const control::Config& config) {
  RobotFile file;
  if (robot) {
    auto read = hal::load_yaml<RobotFile>(*robot);
    if (!read) return tl::unexpected(read.error());
    file = std::move(*read);
  }
  Rig rig;
  rig.name = robot ? robot->filename().string() : "simulated rig";
  if (file.model.empty()) {
    rig.model = std::make_shared<hal::RobotModel>(hal::built_in_robot());
  } else {
    auto model = hal::load_robot(file.model);
    if (!model) return tl::unexpected(model.error());
    rig.model = std::make_shared<hal::RobotModel>(std::move(*model));
  }
  const auto read = read_scenario(scenario);
  if (!read) return tl::unexpected(read.error());
  sim_hal::SimConfig sim;
  sim.arm_period = std::chrono::microseconds(static_cast<long>(1e3 * file.arm_period_ms));
  auto world = sim_hal::SimWorld::make(*read, *rig.model, seed, sim);
  if (!world) return tl::unexpected(world.error());
  const std::shared_ptr<sim_hal::SimWorld> shared = std::move(*world);
  rig.world = shared;
  rig.robot.arm =
      std::make_unique<hal::GuardedArm>(sim_hal::make_sim_arm(*shared), *rig.model, config.guard_arm);
  rig.robot.hand = std::make_unique<hal::GuardedHand>(sim_hal::make_sim_hand(*shared), config.guard_hand);
  rig.robot.camera = sim_hal::make_sim_camera(*shared);
  rig.robot.clock = sim_hal::make_sim_clock(*shared);
  rig.X_WC = sim_hal::camera_pose(read->camera);
  rig.home_rad = shared->arm_state().q_rad;
  rig.truth = truth_of(shared, rig.model);
  return rig;
}

}  // namespace colift::tools
