#include "control/test_lifts.hpp"

namespace colift::control {

void TestLifts::begin(const CarriedObject& object, const hal::Vec3& partner, const hal::Vec3& grasp,
                      double share_predicted) {
  object_ = object;
  now_ = {};
  now_.partner = partner;
  now_.grasp = grasp;
  now_.share_predicted = share_predicted;
  cycles_ = 0;
  eye_.emplace(object, partner, grasp, config_);
}

void TestLifts::feel(const hal::Wrench& felt, const hal::Vec3& palm) {
  now_.felt.force += felt.force;
  now_.felt.torque += felt.torque;
  now_.palm += palm;
  ++cycles_;
}

hal::Result<TestLift> TestLifts::end() {
  const auto moved = eye_->moved();
  if (!moved) return hal::failure(hal::ErrorCode::NotFound, "test_lift", "the camera did not see the object");
  if (cycles_ == 0) return hal::failure(hal::ErrorCode::NotFound, "test_lift", "the arm felt nothing");
  FeltLift lift = now_;
  lift.felt.force /= cycles_;
  lift.felt.torque /= cycles_;
  lift.palm /= cycles_;
  lift.X_WTnow_WTref = *moved;
  lift.drift_rad_s = eye_->drift_rad_s();
  felt_.push_back(lift);
  auto known = understand_test_lift(object_, felt_, config_);
  if (known) known_ = *known;
  return known;
}

}  // namespace colift::control
