#include "control/task/partner_monitor.hpp"

namespace colift::control {

using perception::PartnerEvent;

std::optional<PartnerEvent> PartnerMonitor::update() {
  const DeviceReadings& r = c_.readings;
  // what comes late and steadily is slow, not silent: the arm's speed answers for that
  if (!r.frame) return c_.session.no_frame(c_.now - r.frame_latency);
  auto sight = c_.session.observe_partner(*r.frame, c_.posture());
  if (!sight) {
    c_.partner_note = sight.error().detail;
    return std::nullopt;
  }
  c_.partner_note = sight->event ? sight->event->reason : sight->partner.reason;
  compute_ms_ = sight->compute_ms;
  scene_changed_ = sight->partner.kind == perception::PartnerKind::ObjectMoved;
  hidden_edge_ = sight->partner.hidden_edge;
  if (sight->is_new && sight->partner.kind == perception::PartnerKind::Grasp && sight->partner.grasp)
    c_.tracked.partner_W = sight->partner.grasp->position;
  return sight->event;
}

std::optional<TaskEvent> PartnerMonitor::let_go() {
  const auto event = update();
  if (!event || event->kind != PartnerEvent::Kind::LetGo) return std::nullopt;
  return TaskEvent{Event::PartnerLetGo, event->reason};
}

}  // namespace colift::control
