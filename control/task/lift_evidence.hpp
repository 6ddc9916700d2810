#pragma once

#include <array>
#include <optional>
#include <string>

#include "control/task/let_go_monitor.hpp"
#include "control/task/object_monitor.hpp"
#include "control/task/task_context.hpp"

namespace colift::control {

/// What sensors say about whether object and partner did what was asked: `lifted` is said only when nothing
/// speaks against it and nothing that has to be known is missing.
class LiftEvidence {
 public:
  LiftEvidence(TaskContext& context, const ObjectMonitor& object, const LetGoMonitor& partner)
      : c_(context), config_(context.config.task.evidence), object_(object), partner_(partner) {}

  void start_lift();
  /// Once per cycle of lift, hold and lower, after ObjectMonitor::update(); counts near the top.
  void update();
  /// The object stands, the hand is still closed.
  void standing();
  /// What speaks against `lifted`, or what is not known; empty: lifted.
  [[nodiscard]] std::string against() const;

 private:
  TaskContext& c_;
  const EvidenceConfig& config_;
  const ObjectMonitor& object_;
  const LetGoMonitor& partner_;
  /// Both ends of the object, in a mean over some frames.
  struct Ends {
    double robot_m = 0.0, partner_m = 0.0;
  };
  static constexpr int kMean = 10;  // frames: a third of a second
  std::array<Ends, kMean> last_{};
  Ends best_;            ///< That mean in which the lower end was highest.
  int seen_ = 0;         ///< Frames that showed the object at the top.
  double load_n_ = 0.0;  ///< Sum over cycles.
  int cycles_ = 0;
  bool stands_ = false;
  std::optional<bool> hand_at_end_;
};

}  // namespace colift::control
