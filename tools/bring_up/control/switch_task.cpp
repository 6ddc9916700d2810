#include "tools/bring_up/control/switch_task.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "hal/types/units.hpp"

namespace colift::tools {
namespace {

class Switch {
 public:
  Switch(hal::Arm& guarded, const hal::Clock& clock, const std::atomic<bool>& interrupted,
         const std::function<std::string()>& why)
      : arm_(guarded), clock_(clock), interrupted_(interrupted), why_(why) {}

  /// Empty, or why it ended before its time.
  std::string hold(SwitchStep& step, hal::Timestamp asked, double for_s,
                   const std::function<void(bool)>& asking) {
    std::optional<hal::Timestamp> began, held_up;
    std::string held_why;
    hal::ImpedanceCommand command;
    bool anew = true;
    int bad = 0;
    while (!interrupted_) {
      const auto state = arm_.wait_cycle();
      if (!state) {
        const bool gone =
            state.error().code == hal::ErrorCode::LinkLost || state.error().code == hal::ErrorCode::NotReady;
        if (gone || ++bad > kMostBadCycles) return why(state.error().text());
        continue;
      }
      bad = 0;
      const hal::Timestamp now = clock_.now();
      if (!start_rad_) start_rad_ = state->q_rad;
      step.moved_rad = std::max(step.moved_rad, (state->q_rad - *start_rad_).cwiseAbs().maxCoeff());
      if (!state->may_command) {
        anew = true;
        if (!held_up) {
          held_up = now;
          held_why = why("the arm's controller accepts no commands any more");
        }
        if (hal::seconds(now - *held_up) > kHeldUp_s) return held_why;
        continue;
      }
      held_up.reset();
      if (anew) command.q_rad = state->q_rad;
      if (const auto sent = arm_.command(command); !sent) {
        if (sent.error().code == hal::ErrorCode::LimitExceeded) return sent.error().text();
        continue;
      }
      anew = false;
      if (!began) {
        began = now;
        step.reached = true;
        step.took_s = hal::seconds(now - asked);
        asking(false);
      }
      step.held_s = hal::seconds(now - *began);
      if (step.held_s >= for_s) return {};
    }
    return {};
  }

 private:
  static constexpr int kMostBadCycles = 500;  // in a row: a link that brings nothing usable
  static constexpr double kHeldUp_s = 1.0;    // commands may be held up that long: packets lost, quality

  [[nodiscard]] std::string why(const std::string& otherwise) const {
    std::string text = why_ ? why_() : "";
    return text.empty() ? otherwise : text;
  }

  hal::Arm& arm_;
  const hal::Clock& clock_;
  const std::atomic<bool>& interrupted_;
  const std::function<std::string()>& why_;
  std::optional<hal::JointVector> start_rad_;
};

}  // namespace

SwitchEnd run_switch(hal::Arm& guarded, ControlArm& arm, const std::vector<std::string>& controls,
                     double each_s, const hal::Clock& clock, const std::atomic<bool>& interrupted,
                     const std::function<void(bool)>& asking, const std::function<std::string()>& why) {
  SwitchEnd end;
  if (auto opened = guarded.configure(); !opened) {
    end.reason = opened.error().text();
    return end;
  }
  Switch holds(guarded, clock, interrupted, why);
  for (const std::string& control : controls) {
    if (interrupted) break;
    SwitchStep step{control};
    const hal::Timestamp asked = clock.now();
    asking(true);
    arm.use(control);
    if (auto active = guarded.activate(); !active) {
      if (!interrupted) end.reason = fmt::format("{}: {}", control, active.error().text());
    } else {
      end.reason = holds.hold(step, asked, each_s, asking);
      if (!end.reason.empty()) end.reason = fmt::format("{}: {}", control, end.reason);
    }
    end.steps.push_back(step);
    guarded.deactivate();
    if (!end.reason.empty()) break;
  }
  end.interrupted = interrupted && end.reason.empty();
  return end;
}

std::string describe(const SwitchEnd& end) {
  std::string text;
  for (const SwitchStep& s : end.steps)
    text += s.reached ? fmt::format(
                            "{}: command mode after {:.2f} s, commanded for {:.1f} s, joints within "
                            "{:.3f} deg of where they stood at the beginning\n",
                            s.control, s.took_s, s.held_s, hal::rad_to_deg(s.moved_rad))
                      : fmt::format("{}: not reached\n", s.control);
  return text;
}

}  // namespace colift::tools
