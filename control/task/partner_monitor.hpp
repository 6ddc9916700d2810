#pragma once

#include <optional>

#include "control/task/task_context.hpp"

namespace colift::control {

/// The partner during one job: looks for him in every new frame.
class PartnerMonitor {
 public:
  explicit PartnerMonitor(TaskContext& context) : c_(context) {}

  /// Once in a cycle: what he did, if anything. Without a frame time alone may tell that he let go.
  std::optional<perception::PartnerEvent> update();
  /// update() where nobody holds the object yet and nothing moves it: somebody whose body hides his hand
  /// holds it, too, once he has raised it a little.
  std::optional<perception::PartnerEvent> await_grasp();
  /// update() where the hand is at the object: the event when he let go, nothing else matters there.
  [[nodiscard]] std::optional<TaskEvent> let_go();

  /// The edge of the object that a body hides, in the last frame; unset when a hand is seen, or nothing
  /// hidden.
  [[nodiscard]] const std::optional<perception::HiddenEdge>& hidden_edge() const { return hidden_edge_; }

  /// Object or scene are not where they were seen, by the last frame.
  [[nodiscard]] bool scene_changed() const { return scene_changed_; }

  /// Computing time of the last frame that was analysed (ms).
  [[nodiscard]] double compute_ms() const { return compute_ms_; }

 private:
  template <class Look>
  std::optional<perception::PartnerEvent> look(const Look& look_at);

  TaskContext& c_;
  double compute_ms_ = 0.0;
  bool scene_changed_ = false;
  std::optional<perception::HiddenEdge> hidden_edge_;
};

}  // namespace colift::control
