#include "control/test_lift/test_lifts.hpp"

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

void TestLifts::feel(const hal::Wrench& measured, const hal::Vec3& palm) {
  now_.measured.force += measured.force;
  now_.measured.torque += measured.torque;
  now_.palm += palm;
  ++cycles_;
}

hal::Result<TestLift> TestLifts::end() {
  const auto moved = eye_->moved();
  if (!moved) return hal::failure(hal::ErrorCode::NotFound, "test_lift", "the camera did not see the object");
  if (cycles_ == 0)
    return hal::failure(hal::ErrorCode::NotFound, "test_lift", "no external wrench was measured");
  MeasuredLift lift = now_;
  lift.measured.force /= cycles_;
  lift.measured.torque /= cycles_;
  lift.palm /= cycles_;
  lift.X_WTnow_WTref = *moved;
  lift.drift_rad_s = eye_->drift_rad_s();
  measured_.push_back(lift);
  auto known = analyse_test_lift(object_, measured_, config_);
  if (known)
    known_ = *known;
  else
    measured_.pop_back();  // it would spoil what the next ones tell
  return known;
}

void TestLifts::move(const hal::Pose& X) {
  const auto turned = [&](const hal::Wrench& w) {
    return hal::Wrench{X.linear() * w.force, X.linear() * w.torque};
  };
  for (MeasuredLift& t : measured_) {
    t.measured = turned(t.measured);
    t.palm = X * t.palm;
    t.partner = X * t.partner;
    t.grasp = X * t.grasp;
    t.X_WTnow_WTref = X * t.X_WTnow_WTref * X.inverse();
  }
  object_.cog = X * object_.cog;
  object_.cog_covariance = X.linear() * object_.cog_covariance * X.linear().transpose();
  for (hal::Vec3& f : object_.feet) f = X * f;
  if (!known_) return;
  known_->cog = X * known_->cog;
  for (CogBelief::Case& c : known_->belief.cases)
    c.cog = (X * hal::Vec3(c.cog.x(), c.cog.y(), 0.0)).head<2>();
}

}  // namespace colift::control
