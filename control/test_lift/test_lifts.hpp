#pragma once

#include <optional>
#include <span>
#include <vector>

#include "control/test_lift/test_lift_observer.hpp"

namespace colift::control {

/// The test lifts of one job: each is watched while it goes on, and understood together with those before it.
///
///   lifts.begin(object, partner, grasp, share);
///   lifts.rising(motion)                            each frame, until it says Enough or the height is
///   reached lifts.at_top(at, motion), lifts.feel(wrench, palm)  each frame, each cycle, for hold_s
///   lifts.end()
class TestLifts {
 public:
  explicit TestLifts(const TestLiftConfig& config) : config_(config) {}

  /// `partner`: where he holds it; `grasp`: where the load hangs in the hand (W); `share_predicted` of the
  /// robot there.
  void begin(const CarriedObject& object, const hal::Vec3& partner, const hal::Vec3& grasp,
             double share_predicted);
  Raise rising(const perception::ObjectMotion& motion) { return eye_->rising(motion); }
  void at_top(hal::Timestamp at, const perception::ObjectMotion& motion) { eye_->at_top(at, motion); }
  /// What the hand feels of the object, about the palm's origin, and where that is (W).
  void feel(const hal::Wrench& measured, const hal::Vec3& palm);
  /// Errors: NotFound (object not seen or not felt at the top; and analyse_test_lift()'s).
  [[nodiscard]] hal::Result<TestLift> end();

  /// The object was put down elsewhere, and what was felt goes with it: `X_Wnow_Wthen` moves a point of it
  /// from where it stood.
  void move(const hal::Pose& X_Wnow_Wthen);

  [[nodiscard]] std::span<const MeasuredLift> measured() const { return measured_; }
  [[nodiscard]] const CarriedObject& object() const { return object_; }
  /// What the last one that was understood says.
  [[nodiscard]] const std::optional<TestLift>& known() const { return known_; }
  [[nodiscard]] Raise said() const { return eye_ ? eye_->said() : Raise::On; }

 private:
  TestLiftConfig config_;
  CarriedObject object_;
  std::vector<MeasuredLift> measured_;
  std::optional<TestLiftObserver> eye_;
  MeasuredLift now_;
  int cycles_ = 0;
  std::optional<TestLift> known_;
};

}  // namespace colift::control
