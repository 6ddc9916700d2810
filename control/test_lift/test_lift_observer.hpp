#pragma once

#include <optional>
#include <vector>

#include "control/test_lift/test_lift.hpp"
#include "hal/types/time.hpp"
#include "perception/motion/object_motion.hpp"
#include "perception/scene.hpp"

namespace colift::control {

/// The object as the scene was seen, its feet at the corners of its shape's base.
[[nodiscard]] CarriedObject carried_object(const perception::Target& target);

/// What the camera tells of one test lift, frame by frame: while the object rises, how to go on; at the top,
/// how it hangs in the mean and how fast it still turns. One lift, one thread.
class TestLiftObserver {
 public:
  /// `partner`: where he holds it; `grasp`: where the load hangs in the hand (W).
  TestLiftObserver(CarriedObject object, const hal::Vec3& partner, const hal::Vec3& grasp,
                   const TestLiftConfig& config);

  /// A frame while it rises. Several have to agree before the answer changes: the object swings while the
  /// partner comes after.
  Raise rising(const perception::ObjectMotion& motion);
  /// A frame at the top.
  void at_top(hal::Timestamp at, const perception::ObjectMotion& motion);

  /// The answer to the last frames (rising()).
  [[nodiscard]] Raise said() const { return said_; }
  /// Slope of the turn over the time at the top (rad/s), by least squares.
  [[nodiscard]] double drift_rad_s() const;
  /// Mean motion at the top; none when the object was not seen there.
  [[nodiscard]] std::optional<hal::Pose> moved() const;

 private:
  CarriedObject object_;
  hal::Vec3 partner_, grasp_;
  TestLiftConfig config_;
  Raise seen_ = Raise::On, said_ = Raise::On;
  int in_a_row_ = 0;
  std::vector<double> turns_rad_, times_s_;
  hal::Vec3 turn_ = hal::Vec3::Zero(), shift_ = hal::Vec3::Zero();  ///< Sums over the top.
};

}  // namespace colift::control
