#include "tools/bring_up/hand/hal_hand_task.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/types/units.hpp"

namespace colift::tools {
namespace {

using How = HandTaskEnd::How;

constexpr double kFirstState_s = 1.0;
constexpr double kMove_s = 12.0;  // the driver gives up before
constexpr double kStart_s = 0.3;  // until a motion that was asked for shows
constexpr double kFault_s = 1.0;  // of states that do not come
constexpr double kStop_s = 0.3;
// A grip whose strongest finger measures less than this part of the asked torque is none: a motor that has
// faded with heat stops on an object as a strong one does. A choice, with room for the strain gauges'
// unverified scale.
constexpr double kGripPart = 0.4;

/// The torque at the finger that has most of it; NaN without strain gauges. A broken-away finger's gauge says
/// nothing about its inner link, which does the pressing; then the answer is NaN too.
double strongest_nm(const hal::HandState& state, const hal::HandReport& report) {
  double most = std::nan("");
  for (std::size_t f = 0; f < hal::kFingers; ++f) {
    if (report.broken_away[f]) return std::nan("");
    most = std::fmax(most, state.torque_nm[f]);
  }
  return most;
}

bool is_weak(double strongest, double asked) {
  return strongest < kGripPart * asked;  // false with NaN: unknown
}

class Runner {
 public:
  Runner(hal::Hand& hand, const HandTask& task, const hal::Clock& clock, const HandTaskHooks& hooks)
      : hand_(hand), task_(task), clock_(clock), hooks_(hooks) {}

  HandTaskEnd run() {
    show_progress("opens the bus and looks for the pucks");
    if (auto opened = hand_.configure(); !opened) return refused(opened.error());
    if (!first_state()) return end(How::Refused, error_);
    end_.before = end_.after = *state_;
    if (task_.kind == HandTask::Kind::Watch) return watch();
    if (auto active = hand_.activate(); !active) return refused(active.error());
    HandTaskEnd done = move();
    hand_.deactivate();
    const hal::HandReport report = hooks_.report();
    done.motors = hal::motors_at_rest(report);
    done.modes = report.mode_at_rest;
    return done;
  }

 private:
  [[nodiscard]] double now() const { return hal::seconds(clock_.now()); }
  void show_progress(std::string_view doing) const {
    if (hooks_.progress) hooks_.progress(doing, state_);
  }
  HandTaskEnd end(How how, std::string reason) {
    end_.how = how;
    end_.reason = std::move(reason);
    if (state_) end_.after = *state_;
    return end_;
  }

  HandTaskEnd refused(const hal::Error& error) {
    end_.code = error.code;
    return end(How::Refused, error.text());
  }

  /// One turn of the hand. False when nothing good has come for a while.
  bool turn(std::string_view doing) {
    hooks_.pause();
    if (auto state = hand_.state()) {
      state_ = *state;
      bad_since_.reset();
      ++end_.states;
    } else {
      ++end_.bad_states;
      error_ = state.error().text();
      end_.code = state.error().code;
      if (!bad_since_) bad_since_ = now();
    }
    show_progress(doing);
    return !bad_since_ || now() - *bad_since_ < kFault_s;
  }

  bool first_state() {
    const double since = now();
    while (!state_ && now() - since < kFirstState_s) (void)turn("waits for a first state");
    return state_.has_value();
  }

  HandTaskEnd watch() {
    const double since = now();
    while (!hooks_.interrupted() && now() - since < task_.for_s)
      if (!turn("watches") && std::isfinite(task_.for_s)) return end(How::Failed, error_);
    if (bad_since_) return end(How::Failed, error_);
    const bool cut = hooks_.interrupted() && std::isfinite(task_.for_s);
    return end(cut ? How::Interrupted : How::Done, cut ? "asked to end" : "");
  }

  hal::Result<> start() {
    switch (task_.kind) {
      case HandTask::Kind::Open:
        return hand_.release();
      case HandTask::Kind::Preshape:
        return hand_.preshape(task_.spread_rad);
      case HandTask::Kind::Close:
      case HandTask::Kind::Grip:
        return hand_.close(task_.torque_nm);
      case HandTask::Kind::Watch:
        break;
    }
    return {};
  }

  [[nodiscard]] bool closes() const {
    return task_.kind == HandTask::Kind::Close || task_.kind == HandTask::Kind::Grip;
  }

  HandTaskEnd move() {
    const bool loaded = state_->held || hooks_.report().loaded;
    if (loaded && task_.kind != HandTask::Kind::Watch && !closes() && !task_.although_loaded)
      return end(How::BadRequest,
                 "the hand may hold something, which would fall: support it, and say --yes if it shall open");
    if (loaded && task_.kind == HandTask::Kind::Preshape)
      if (auto released = hand_.release(); !released) return refused(released.error());
    if (auto done = settle("opens", task_.kind == HandTask::Kind::Preshape && loaded); done) return *done;
    if (hooks_.interrupted()) return end(How::Interrupted, "asked to end");
    if (auto started = start(); !started) {
      const bool range = started.error().code == hal::ErrorCode::LimitExceeded;
      return range ? end(How::BadRequest, started.error().text()) : refused(started.error());
    }
    end_.moved = true;
    if (auto done = settle(closes() ? "closes" : "moves", true); done) return *done;
    if (closes()) return judge_grip();
    const std::string why = hooks_.report().why.str();
    return why.empty() ? end(How::Done, "") : end(How::Failed, why);
  }

  /// Waits for the end of a motion; an end of the task when there is one before.
  std::optional<HandTaskEnd> settle(std::string_view doing, bool moving) {
    if (!moving) return std::nullopt;
    const double since = now();
    for (;;) {
      if (!turn(doing)) {
        stop();
        return end(How::Failed, error_);
      }
      if (hooks_.interrupted()) {
        stop();
        return end(How::Interrupted, "asked to end; the fingers stay where they are");
      }
      const double t = now() - since;
      if (t > kMove_s) {
        stop();
        return end(How::Failed, fmt::format("the motion has not ended within {:.0f} s", kMove_s));
      }
      if (t > kStart_s && !state_->moving && !bad_since_) {
        end_.took_s = t;
        return std::nullopt;
      }
    }
  }

  void stop() {
    hand_.stop();
    const double since = now();
    while (now() - since < kStop_s) (void)turn("stops");
  }

  /// Why what stopped the fingers is not gripped as was asked.
  std::optional<std::string> weak_grip() {
    const hal::HandReport report = hooks_.report();
    const double strongest = strongest_nm(*state_, report);
    if (!is_weak(strongest, task_.torque_nm)) return std::nullopt;
    end_.weak = true;
    double hottest = std::nan("");
    for (const double c : report.temperature_c) hottest = std::fmax(hottest, c);
    return fmt::format(
        "the fingers stopped on something, but the strongest measures {:.2f} of the {:.2f} N m that were "
        "asked: not a grip to lift with; {}",
        strongest, task_.torque_nm,
        std::isnan(hottest)
            ? std::string("no temperature is known")
            : fmt::format("the hottest puck or motor has {:.0f} C, and heat takes torque", hottest));
  }

  HandTaskEnd judge_grip() {
    if (!state_->held) {
      const std::string why = hooks_.report().why.str();
      return end(How::NoGrip, why.empty() ? "the fingers met nothing" : why);
    }
    if (const auto weak = weak_grip()) return end(How::NoGrip, *weak);
    if (task_.kind != HandTask::Kind::Grip) return end(How::Done, "");
    const double since = now();
    while (now() - since < task_.for_s && !hooks_.interrupted()) {
      if (!turn("holds")) return end(How::Failed, error_);
      const hal::HandReport report = hooks_.report();
      if (report.slipped || !state_->held)
        return end(How::NoGrip, fmt::format("the grip slipped after {:.1f} s{}{}", now() - since,
                                            report.why.empty() ? "" : ": ", report.why.str()));
      if (const auto weak = weak_grip()) return end(How::NoGrip, *weak);
      double force = 0.0;
      for (const double f : state_->tip_force_n) force += f;
      if (!(end_.min_force_n <= force)) end_.min_force_n = force;
    }
    return end(hooks_.interrupted() ? How::Interrupted : How::Done,
               hooks_.interrupted() ? "asked to end; what is held stays held" : "");
  }

  hal::Hand& hand_;
  const HandTask& task_;
  const hal::Clock& clock_;
  const HandTaskHooks& hooks_;
  std::optional<hal::HandState> state_;
  std::optional<double> bad_since_;
  std::string error_ = "no state came";
  HandTaskEnd end_;
};

}  // namespace

HandTaskEnd run_hand_task(hal::Hand& hand, const HandTask& task, const hal::Clock& clock,
                          const HandTaskHooks& hooks) {
  return Runner(hand, task, clock, hooks).run();
}

std::string hand_summary(const HandTask& task, const HandTaskEnd& e) {
  std::string t;
  if (e.moved) {
    t += fmt::format(
        "took {:.1f} s: fingers from {:.0f}, {:.0f}, {:.0f} to {:.0f}, {:.0f}, {:.0f} deg, spread from "
        "{:.0f} to {:.0f} deg\n",
        e.took_s, hal::rad_to_deg(e.before.finger_rad[0]), hal::rad_to_deg(e.before.finger_rad[1]),
        hal::rad_to_deg(e.before.finger_rad[2]), hal::rad_to_deg(e.after.finger_rad[0]),
        hal::rad_to_deg(e.after.finger_rad[1]), hal::rad_to_deg(e.after.finger_rad[2]),
        hal::rad_to_deg(e.before.spread_rad), hal::rad_to_deg(e.after.spread_rad));
    if (task.kind == HandTask::Kind::Close || task.kind == HandTask::Kind::Grip)
      t += fmt::format("{}; strain {:.2f}, {:.2f}, {:.2f} N m, pads {:.1f}, {:.1f}, {:.1f} N\n",
                       e.weak         ? "it touches something, too weakly for a grip"
                       : e.after.held ? "it holds something"
                                      : "it holds nothing",
                       e.after.torque_nm[0], e.after.torque_nm[1], e.after.torque_nm[2],
                       e.after.tip_force_n[0], e.after.tip_force_n[1], e.after.tip_force_n[2]);
    if (!e.motors.empty()) t += e.motors + "\n";
    if (e.after.held) t += "the worm gears hold; \"colift hal hand open --yes\" lets go\n";
  }
  if (e.how == How::Interrupted) t += fmt::format("interrupted: {}\n", e.reason);
  return t;
}

std::string hand_advice(hal::ErrorCode code, const std::string& bus) {
  switch (code) {
    case hal::ErrorCode::NotReady:
      return "free the hand and its surroundings, then: colift hal hand init (the fingers open to their "
             "stops); if it holds something: colift hal hand emergency-open --yes";
    case hal::ErrorCode::BadConfig:
      return fmt::format(
          "the bus is \"{}\": expected socketcan:can0 or socketcand:HOST:29536/can0 in barrett: {{can: ...}} "
          "of the file behind --robot, and an interface that \"colift doctor\" finds",
          bus);
    case hal::ErrorCode::DeviceFault:
      return "if it holds something: colift hal hand emergency-open --yes; then switch its supply off and "
             "on, and: colift hal hand init";
    default:
      if (bus.starts_with("socketcand:"))
        return fmt::format(
            "does a gateway run there (socketcand -v -i can0 -l INTERFACE -e 1FFFFFFF; without a hand: "
            "colift emulate hand --bus {})? behind it: supply on (48 V)? CAN termination on at the hand's "
            "supply (the usual cause)? bit rate 1 Mbit/s? candump -e can0 on the gateway shows what the bus "
            "says",
            bus);
      return "supply on (48 V)? CAN termination on at the hand's supply (the usual cause), 120 ohm at the "
             "other end? bit "
             "rate 1 Mbit/s? then: colift doctor, and candump -e can0 shows what the bus says";
  }
}

}  // namespace colift::tools
