#include "control/test_lift/test_lift_observer.hpp"

#include <utility>

namespace colift::control {
CarriedObject carried_object(const perception::Target& target) {
  CarriedObject object;
  object.cog = target.cog;
  object.cog_covariance = target.cog_covariance;
  const hal::OrientedBox& box = target.shape;
  for (const auto& [u, v] : {std::pair{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}})
    object.feet.push_back(box.center + box.axes * box.size.cwiseProduct(hal::Vec3(u, v, -0.5)));
  return object;
}

TestLiftObserver::TestLiftObserver(CarriedObject object, const hal::Vec3& partner, const hal::Vec3& grasp,
                                   const TestLiftConfig& config)
    : object_(std::move(object)), partner_(partner), grasp_(grasp), config_(config) {}

Raise TestLiftObserver::rising(const perception::ObjectMotion& motion) {
  const Raise how = raise_on(hanging(object_, partner_, grasp_, motion.X_WTnow_WTref), config_);
  in_a_row_ = how == seen_ ? in_a_row_ + 1 : 1;
  seen_ = how;
  if (in_a_row_ >= config_.agreeing_frames) said_ = how;
  return said_;
}

void TestLiftObserver::at_top(hal::Timestamp at, const perception::ObjectMotion& motion) {
  // small turns add up like vectors
  const Eigen::AngleAxisd turn(motion.X_WTnow_WTref.linear());
  turn_ += turn.angle() * turn.axis();
  shift_ += motion.X_WTnow_WTref * object_.cog - object_.cog;
  turns_rad_.push_back(hanging(object_, partner_, grasp_, motion.X_WTnow_WTref).turn_rad);
  times_s_.push_back(hal::seconds(at));
}

double TestLiftObserver::drift_rad_s() const {
  double t = 0.0, y = 0.0, tt = 0.0, ty = 0.0;
  const auto n = static_cast<double>(turns_rad_.size());
  for (std::size_t i = 0; i < turns_rad_.size(); ++i) t += times_s_[i] / n, y += turns_rad_[i] / n;
  for (std::size_t i = 0; i < turns_rad_.size(); ++i) {
    tt += (times_s_[i] - t) * (times_s_[i] - t);
    ty += (times_s_[i] - t) * (turns_rad_[i] - y);
  }
  return tt > 0.0 ? ty / tt : 0.0;
}

std::optional<hal::Pose> TestLiftObserver::moved() const {
  if (turns_rad_.empty()) return std::nullopt;
  const auto n = static_cast<double>(turns_rad_.size());
  const hal::Vec3 turn = turn_ / n;
  hal::Pose X = hal::Pose::Identity();
  if (turn.norm() > 1e-12) X.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  X.translation() = object_.cog + shift_ / n - X.linear() * object_.cog;
  return X;
}

}  // namespace colift::control
