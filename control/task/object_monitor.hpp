#pragma once

#include <array>
#include <cmath>
#include <optional>

#include "control/task/task_context.hpp"
#include "perception/motion/object_motion.hpp"

namespace colift::control {

/// The object in the hand: follows it frame by frame, writes the curve of the lift, and says when a limit of
/// tilt, slip or load is broken.
class ObjectMonitor {
 public:
  explicit ObjectMonitor(TaskContext& context) : c_(context) {}

  /// The hand is where it grips: heights and slip count from here.
  void set_grip();
  /// The lift is about to begin: the partner's end counts from here.
  void start_lift();
  /// Once in a cycle: the motion in a new frame.
  void update();
  /// The object was put down elsewhere, and the scene was taken anew.
  void forget_motion() { motion_.reset(); }

  /// The event that ends a lift: the grip is lost, or tilt, slip or load is beyond its limit.
  [[nodiscard]] std::optional<TaskEvent> beyond_limits() const;
  /// The event when the palm cannot go on straight: a joint is near its limit.
  [[nodiscard]] std::optional<TaskEvent> end_of_reach() const;

  /// Against the scene; unset while too little of it is seen.
  [[nodiscard]] const std::optional<perception::ObjectMotion>& motion() const { return motion_; }
  /// JobPolicies::carry wants the hold to end.
  [[nodiscard]] bool to_be_lowered() const { return order_.lower; }
  /// How far the partner's end has risen, when it was last seen; and how far it has come down since its
  /// highest place in this lift, or since that was forgotten (m).
  [[nodiscard]] double partner_rise_m() const { return partner_rise_m_; }
  [[nodiscard]] double partner_fall_m() const { return partner_top_m_ - partner_rise_m_; }
  void forget_partner_top() { partner_top_m_ = partner_rise_m_; }
  /// What his end has to move to be moving: less is the noise of its place, as measured from frame to frame
  /// (m).
  [[nodiscard]] double end_noise_m() const;
  /// His end is farther up than the hand by more than LiftMotionConfig::leader_rise_m, and stays so.
  [[nodiscard]] bool partner_lifts_first() const;
  /// Both ends are seen where they stood, up to CarryConfig::standing_tolerance_m; without a picture the
  /// palm's height above its grasp decides.
  [[nodiscard]] bool seen_down() const;
  /// It stands on an edge or on two of its feet, as far as that is seen: tilted as it hung in the air, by no
  /// more than CarryConfig::max_askew_deg, its lowest corner where it stood, and the partner's end about
  /// there.
  [[nodiscard]] bool seen_askew() const;
  /// It is seen to stand: both ends, or, where an arm that goes down was stopped, an edge of it.
  [[nodiscard]] bool seen_standing() const;
  /// Angle of the object's up axis, and its slip in the hand along the lift; NaN until first seen.
  [[nodiscard]] double tilt_rad() const { return tilt_rad_; }
  [[nodiscard]] double slip_m() const { return slip_m_; }
  [[nodiscard]] const hal::Pose& X_WH_grip() const { return X_WH_grip_; }
  /// How far the object has moved from where the scene was seen, on which everything was decided: the
  /// farthest corner of its box (m). 0 while it is not seen.
  [[nodiscard]] double displacement_m() const;

 private:
  TaskContext& c_;
  [[nodiscard]] double partner_load_n() const;
  void update_noise(double lag_m);
  /// From when the hand has a good grip until the object is set down.
  [[nodiscard]] std::optional<perception::HeldPoint> held_point() const;

  hal::Pose X_WH_grip_ = hal::Pose::Identity();
  hal::Vec3 pivot_ref_W_ =
      hal::Vec3::Zero();  ///< Where the load acts on the hand, in the scene as it was seen.
  std::optional<perception::ObjectMotion> motion_;
  CarryOrder order_;  ///< Of the last frame.
  double partner_rise_m_ = 0.0, partner_top_m_ = 0.0, tilt_rad_ = NAN, slip_m_ = NAN;
  std::array<double, 5> lags_m_{NAN, NAN, NAN, NAN, NAN};  ///< His end below the palm, newest first.
  double jump_m_ = 0.0;                                    ///< Largest of its jumps, fading.
  double hanging_tilt_rad_ = NAN;                          ///< Before it was lowered.
  int frames_slipping_ = 0, frames_tilting_ = 0, frames_first_ = 0;  ///< In a row.
  hal::Timestamp partner_bears_at_{0};                               ///< His load was last within its limit.
};

}  // namespace colift::control
