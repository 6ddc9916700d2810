#include "control/monitor/separation_monitor.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "control/monitor/separation.hpp"

namespace colift::control {
namespace {

// Away from a thing that stands beside the arm, slowly: to stay beside it helps nobody. Nearer than this is a
// contact by all that is known of the distance.
constexpr double kLeave_m_s = 0.05, kTouches_m = 0.03;

}  // namespace

double SeparationMonitor::hold_distance_m(Nearby who) const {
  switch (who) {
    case Nearby::Person:
      return config_.hold_distance_m;
    case Nearby::Partner:
      return config_.partner_hold_distance_m;
    case Nearby::Thing:
      return config_.thing_hold_distance_m;
    case Nearby::PartnerHand:
      break;
  }
  return -std::numeric_limits<double>::infinity();
}

double SeparationMonitor::limit_m_s(const Neighbour& n, double latency_s, double robot_kg) const {
  const double latency = std::max(latency_s, config_.latency_s);
  if (n.who == Nearby::Person) return allowed_speed(n.distance_m, config_.person_speed_m_s, latency, config_);
  if (n.who == Nearby::Thing) {  // reaches for nothing, and has stayed where it is
    MonitorConfig still = config_;
    still.intrusion_m = 0.0;
    const double kept = allowed_speed(n.distance_m, 0.0, latency, still);
    return n.behind ? std::max(kept, kLeave_m_s) : kept;
  }
  const double speed = std::clamp(n.speed_m_s, config_.partner_speed_m_s, config_.person_speed_m_s);
  const double kept = allowed_speed(n.distance_m, speed, latency, config_);
  if (n.who != Nearby::PartnerHand) return kept;
  // whichever allows more: his hand may be touched with a speed that does not hurt
  const double softly =
      std::min(contact_speed(BodyRegion::Hand, robot_kg), contact_speed(BodyRegion::LowerArm, robot_kg));
  return std::max(kept, softly);
}

const SeparationState& SeparationMonitor::update(hal::Timestamp now, bool moves,
                                                 std::span<const Neighbour> near, double latency_s,
                                                 double robot_kg) {
  const double extra_m = state_.hold ? config_.hysteresis_m : 0.0;
  SeparationState next;
  bool too_near = false;
  for (const Neighbour& n : near) {
    const bool leaves = n.who == Nearby::Thing && n.behind && n.distance_m > kTouches_m;
    const bool holds = !leaves && n.distance_m < hold_distance_m(n.who) + extra_m;
    const double limit = holds ? 0.0 : limit_m_s(n, latency_s, robot_kg);
    too_near = too_near || holds || limit <= 0.0;
    if (next.limited && limit > next.speed_m_s) continue;
    if (next.limited && limit == next.speed_m_s && n.distance_m >= next.nearest.distance_m) continue;
    next.limited = true;
    next.speed_m_s = limit;
    next.nearest = n;
  }
  if (too_near) near_at_ = now;
  if (moves && !state_.hold) to_confirm_ = false;
  next.hold = too_near;
  // an arm that has not moved since its stop has stopped still, though its continuation was announced
  next.stopped = state_.hold ? state_.stopped : moves || to_confirm_;
  to_confirm_ = to_confirm_ || (next.hold && next.stopped && !config_.resume);
  if (state_.hold && !too_near) {
    const double free_s = hal::seconds(now - near_at_);
    // one frame in which nobody is seen is no free way: a confirmation waits for as much as a start does
    next.may_confirm = to_confirm_ && free_s >= config_.free_to_start_s;
    next.hold = to_confirm_ || free_s < (next.stopped ? config_.free_s : config_.free_to_start_s);
    if (next.hold && !next.limited) next.nearest = state_.nearest;
  }
  next.held_for = too_near ? next.nearest.who : state_.held_for;
  next.to_confirm = next.hold && to_confirm_;
  free_speed_m_s_ = next.speed_m_s;
  if (next.hold) next.speed_m_s = 0.0;
  state_ = next;
  return state_;
}

bool SeparationMonitor::confirm() {
  if (!state_.may_confirm) return false;
  state_.hold = state_.to_confirm = state_.may_confirm = false;
  state_.speed_m_s = free_speed_m_s_;
  return true;
}

std::string_view describe(Nearby who) {
  return who == Nearby::Person    ? "a person"
         : who == Nearby::Partner ? "the partner"
         : who == Nearby::Thing   ? "something at rest"
                                  : "the partner's hand";
}

std::string describe(const Neighbour& n) {
  return fmt::format("{} is {:.2f} m from {}", describe(n.who), std::max(0.0, n.distance_m),
                     n.to_path ? "the arm's path" : "the arm");
}

}  // namespace colift::control
