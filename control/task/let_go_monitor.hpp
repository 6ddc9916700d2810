#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>

#include "control/task/object_monitor.hpp"
#include "control/task/task_context.hpp"
#include "perception/partner/hand_motion.hpp"

namespace colift::control {

/// Whether the load in the hand (N) says that the partner bears his part again: it is what it was before (N),
/// up to a fraction of that. With his end in the air it may be less, he bears the more then; with his end on
/// the ground less may as well be what the ground bears.
[[nodiscard]] bool is_borne_again(double load_n, double before_n, double max_deviation, bool end_is_up);

/// Whether the partner still holds the object, from first finger contact to the end of lowering: his hand in
/// the picture at his contact, which moves with the object; his end, which has to stay with the palm; the
/// load, which grows when he lets go. Any one of them says so. A sudden sideways force is a pull. Early in a
/// lift the load alone does not: an object whose far end is on the floor weighs no more than one that is
/// carried.
class LetGoMonitor {
 public:
  LetGoMonitor(TaskContext& context, const ObjectMonitor& object)
      : c_(context), object_(object), config_(context.config.task.let_go) {}

  /// The hand begins to close: learns how much of his hand is seen at his contact.
  void start();
  /// Once per cycle, after ObjectMonitor::update().
  void update();
  /// The event when he has let go.
  [[nodiscard]] std::optional<TaskEvent> let_go() const;
  /// The sideways force on the hand is steady: nobody pulls at the object.
  [[nodiscard]] bool is_steady() const;
  /// He holds a raised object again: his hand is seen and his end is up. Where his hand cannot be seen: the
  /// load is what it was; with his end in the air it may be less, he bears the more then; an
  /// end that the ground may bear has to be held by a hand that is seen.
  [[nodiscard]] bool holds_again(bool ground_may_bear) const;
  /// In the last frame his hand was at his contact, no farther from its mean than usual.
  [[nodiscard]] bool hand_stays() const;
  /// His end is seen in the air beside the palm: he carries, whatever hides his hand.
  [[nodiscard]] bool his_end_is_up() const;
  /// The robot sets the object down alone, as a person confirmed: from now on nobody lets go.
  void stop() { stopped_ = true; }
  /// He was asked to hold again: what was found before does not count.
  void ask_again();

  /// His hand is seen at his contact; unset where it cannot be seen.
  [[nodiscard]] std::optional<bool> hand_seen() const;
  /// Where he held, as the object lies now (W).
  [[nodiscard]] hal::Vec3 place() const;

 private:
  void update_hand();
  void update_load();
  void update_pull(double dt_s);
  /// How far his end has just sunk more than the palm (m); 0 while it does not sink, or is not seen.
  [[nodiscard]] double fall_m() const;
  /// The same up to one of the last frames.
  [[nodiscard]] double fallen_m(std::size_t frame) const;
  /// How far his contact went sideways by the object's turn (m, W), and where that is followed.
  [[nodiscard]] Eigen::Vector2d turned_aside() const;
  void follow_turn();
  [[nodiscard]] bool in_the_air() const;
  /// Of his end below the palm (m), since the hand closed; NaN while not seen.
  [[nodiscard]] double lag_m() const;

  TaskContext& c_;
  const ObjectMonitor& object_;
  const LetGoConfig& config_;
  bool was_in_the_air_ = false;
  hal::Vec3 contact_W_ = hal::Vec3::Zero();
  hal::Pose X_ = hal::Pose::Identity();  ///< Last known motion of the object.
  double rise_m_ = 0.0;                  ///< Of his end, as last seen.
  /// How far his contact went sideways, all in all; by the object's turn as last seen (m, W).
  Eigen::Vector2d aside_m_ = Eigen::Vector2d::Zero(), turned_m_ = Eigen::Vector2d::Zero();
  std::size_t camera_ = 0;  ///< That saw his hand so far.
  double usual_m2_ = 0.0, area_m2_ = NAN;
  perception::HandMotion hand_motion_{c_.config.presence};
  bool hand_leaves_ = false, stopped_ = false;
  int frames_ = 0, frames_gone_ = 0, frames_low_ = 0;
  /// His end in the last frames: when, how high, how far below the palm.
  struct End {
    hal::Timestamp at{0};
    double rise_m = NAN, lag_m = NAN;
  };
  std::array<End, 8> ends_{};  ///< Newest first.
  double fall_m_ = 0.0;
  double mean_load_n_ = 0.0, load_before_n_ = 0.0;
  double gain_n_ = 0.0;
  std::optional<Eigen::Vector2d> mean_sideways_n_;  ///< Of the hand; W.
  double pull_n_ = 0.0;                             ///< Off that mean.
  int cycles_pulled_ = 0;                           ///< In a row.
  hal::Timestamp updated_at_{0};
};

}  // namespace colift::control
