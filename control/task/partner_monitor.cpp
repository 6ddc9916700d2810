#include "control/task/partner_monitor.hpp"

namespace colift::control {

using perception::PartnerEvent;

template <class Look>
std::optional<PartnerEvent> PartnerMonitor::look(const Look& look_at) {
  const DeviceReadings& r = c_.readings;
  // what comes late and steadily is slow, not silent: the arm's speed answers for that
  if (!r.frame) return c_.session.no_frame(c_.now - r.frame_latency);
  auto sight = look_at(c_.session, *r.frame, c_.posture());
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

std::optional<PartnerEvent> PartnerMonitor::update() {
  return look([](PerceptionSession& session, const hal::DepthFrame& frame, const RobotPosture& robot) {
    return session.observe_partner(frame, robot);
  });
}

std::optional<PartnerEvent> PartnerMonitor::await_grasp() {
  return look([](PerceptionSession& session, const hal::DepthFrame& frame, const RobotPosture& robot) {
    return session.await_grasp(frame, robot);
  });
}

std::optional<TaskEvent> PartnerMonitor::let_go() {
  const auto event = update();
  if (!event || event->kind != PartnerEvent::Kind::LetGo) return std::nullopt;
  return TaskEvent{Event::PartnerLetGo, event->reason};
}

}  // namespace colift::control
