#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/analyse/words.hpp"
#include "tools/run/run_progress.hpp"
#include "tools/run/run_text.hpp"

namespace colift::tools {
namespace {

constexpr std::size_t kHeading = 10;

std::string partner_text(const RunView& view) {
  const auto& decision = view.record.decision;
  if (!decision) return "no partner's grasp was observed";
  if (!decision->partner) return decision->partner_reason;
  std::string text = fmt::format("grasps the object at {}", place_text(decision->partner->position));
  if (const auto error = partner_error_m(view))
    text += fmt::format(", error {} against the truth", metres_text(*error));
  return text;
}

std::string decision_text(const RunView& view) {
  const control::Outcome& o = *view.record.decision;
  if (!o.decision.chosen) return o.decision.reason;
  const planner::GraspCandidate& c = o.candidates[*o.decision.chosen];
  const auto possible = std::count_if(o.candidates.begin(), o.candidates.end(), [](const auto& other) {
    return other.verdict == planner::Verdict::Ok || other.verdict == planner::Verdict::Chosen;
  });
  return fmt::format("number {} at {}, of {} candidates, {} of them possible; {}", c.id,
                     place_text(c.position), o.candidates.size(), possible, o.decision.reason);
}

std::string lift_text(const RunView& view, const std::optional<TrueLift>& truth) {
  const control::LiftSummary& l = *view.record.lift;
  const auto really = [&](const std::string& text) {
    return truth ? fmt::format(" (truth {})", text) : std::string();
  };
  return fmt::format("{} high{}, tilted {}{}, slipped {}{} in the hand", metres_text(l.height_m),
                     really(truth ? metres_text(truth->height_m) : ""), degrees_text(l.tilt_rad),
                     really(truth ? degrees_text(truth->tilt_rad) : ""), metres_text(l.slip_m),
                     really(truth ? metres_text(truth->slip_m) : ""));
}

std::string share_text(const RunView& view, const std::optional<TrueLift>& truth) {
  const control::LiftSummary& l = *view.record.lift;
  std::string text = fmt::format("the robot carried {}{}", percent_text(l.share_robot), share_95_text(l));
  if (truth) text += fmt::format(" (truth {})", percent_text(truth->share_robot));
  if (!l.load_steady) text += " while the load still changed";
  text += fmt::format("; predicted {}", percent_text(l.share_predicted));
  if (view.setting.share) {
    const double off = std::abs(l.share_robot - *view.setting.share);
    text += fmt::format(", wanted {}", percent_text(*view.setting.share));
    if (std::isfinite(off)) text += fmt::format(": {:.0f} % off what was asked", 100 * off);
  }
  return text;
}

std::string mass_text(const RunView& view) {
  std::string text = mass_95_text(*view.record.lift);
  if (view.truth) text += fmt::format(" (truth {:.2f} kg)", view.truth->mass_kg);
  return text;
}

std::string timing_text(const RunView& view) {
  const control::RunTiming& t = view.record.timing;
  std::string text;
  if (t.grasp_to_decision_s)
    text += fmt::format("decided {:.2f} s after the grasp was certain ({:.1f} ms of computing), ",
                        *t.grasp_to_decision_s, t.decision_compute_ms);
  if (view.record.plan) text += fmt::format("planned in {:.1f} ms, ", t.plan_ms);
  text += view.setting.simulated ? fmt::format("{:.1f} s of simulated time in {:.1f} s", t.sim_s, t.wall_s)
                                 : fmt::format("{:.1f} s in all", t.wall_s);
  return text;
}

std::string link_text(const ArmLink& link) {
  std::string text = fmt::format(
      "{} of {} datagrams answered, half of them within {} us, 99.9 % within {} us, the slowest in {} us",
      link.answered, link.cycles, link.answer_us.p50, link.answer_us.p999, link.answer_us.worst);
  if (!link.controller) return text;
  const ArmLink::Controller& c = *link.controller;
  return text + fmt::format(
                    "; the emulated controller missed {} of {} answers, {} of them while it took commands, "
                    "and began {} "
                    "cycles late itself",
                    c.missed, c.sent, c.missed_in_command, c.late);
}

}  // namespace

std::string run_summary(const RunView& view, int columns) {
  const auto width = static_cast<std::size_t>(std::max(20, columns));
  const control::RunRecord& record = view.record;
  const auto line = [&](const char* heading, const std::string& text) {
    return entry(heading, one_line(text, false), kHeading, width);
  };
  std::string out;
  out += line(word(record.outcome), record.reason) + "\n";
  if (record.analysis && record.analysis->scene.target)
    out += line("object", record.analysis->scene.target->reason);
  out += line("partner", partner_text(view));
  // a refusal's reason is said already
  if (record.decision && record.reason.find(record.decision->decision.reason) == std::string::npos)
    out += line("grasp", decision_text(view));
  if (record.decision && !record.decision->share.text.empty()) {
    const control::ShareContract& share = record.decision->share;
    // where one was wanted, the reason of grasp or refusal has it
    if (!share.wanted) out += line("share", share.text);
    out += line("limit", share.partner_text);
    if (share.certificate) {
      out += line("bounds", share.certificate->text);
      if (!share.certificate->breaches.empty()) out += line("beyond", share.certificate->breach_text);
    }
  }
  for (const control::AskRecord& a : record.asked) out += line("asked", a.reason);
  for (const control::TestLiftRecord& t : record.test_lifts)
    out +=
        line("tested", fmt::format("number {}, {} high: {}", t.candidate, metres_text(t.height_m), t.reason));
  if (record.lift) {
    const auto truth = true_lift(view);
    out += line("lift", lift_text(view, truth));
    out += line("load", share_text(view, truth));
    out += line("mass", mass_text(view));
  }
  out += line("time", timing_text(view));
  if (view.arm_link != nullptr) out += line("wire", link_text(*view.arm_link));
  bool first = true;
  for (const control::DeviceNote& f : record.faults) {
    out += line(first ? "faults" : "", fmt::format("{:.2f} s {}: {}", hal::seconds(f.at), f.device, f.what));
    first = false;
  }
  if (view.truth && view.truth->verdict)
    for (const std::string& breach : view.truth->verdict->breaches) out += line("judge", breach);
  if (record.hand_keeps_grip)
    out += line("attention", "the hand still holds the object: take its weight before the hand is opened");
  return out;
}

}  // namespace colift::tools
