#include "tools/rig/rig_truth.hpp"

#include "sim_hal/judge/judge.hpp"

namespace colift::tools {

RigTruth truth_of(const std::shared_ptr<sim_hal::SimWorld>& world,
                  const std::shared_ptr<const hal::RobotModel>& model, bool in_step) {
  RigTruth truth;
  const auto judge = std::make_shared<sim_hal::Judge>(*model, in_step);
  world->observe([judge](const sim_hal::TickReport& report) { judge->tick(report); });
  truth.task_state = [world, judge](const std::string& name) {
    world->task_state(name);
    judge->task_state(name);
  };
  truth.judge = [judge](bool lifted) { return judge->verdict(lifted); };
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
  truth.ask_partner = [world](const std::optional<hal::Vec3>& grasp_W,
                              const std::optional<hal::Vec3>& aside_W) {
    world->ask_partner(grasp_W, aside_W);
  };
  truth.take_lower_confirmed = [world] { return world->take_lower_confirmed(); };
  truth.take_continue_confirmed = [world] { return world->take_continue_confirmed(); };
  truth.scene = [world, model] {
    picture::SolidScene scene;
    for (const sim_hal::Shape& shape : world->shapes().shapes)
      if (shape.label != sim_hal::Label::Robot) scene.solids.push_back(picture::solid_of(shape));
    // from the model: arm and hand have colours of their own
    const auto robot =
        picture::robot_solids(*model, world->arm_state().q_rad, hal::posture_of(world->hand_state()));
    scene.solids.insert(scene.solids.end(), robot.begin(), robot.end());
    return scene;
  };
  return truth;
}

}  // namespace colift::tools
