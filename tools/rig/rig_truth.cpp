#include "tools/rig/rig_truth.hpp"

namespace colift::tools {
namespace {

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

}  // namespace

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
  truth.ask_partner = [world](const hal::Vec3& place_W) { world->ask_partner(place_W); };
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

}  // namespace colift::tools
