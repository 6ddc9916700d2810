#include "control/recovery/recovery_machine.hpp"

#include <catch2/catch.hpp>
#include <queue>
#include <set>
#include <vector>

using namespace colift::control;

namespace {

std::vector<RecoveryStep> all_steps() {
  std::vector<RecoveryStep> steps;
  for (int i = 0; i < kRecoverySteps; ++i) steps.push_back(static_cast<RecoveryStep>(i));
  return steps;
}

std::vector<RecoveryEvent> all_events() {
  std::vector<RecoveryEvent> events;
  for (int i = 0; i < kRecoveryEvents; ++i) events.push_back(static_cast<RecoveryEvent>(i));
  return events;
}

}  // namespace

TEST_CASE("every pair of step and event has at most one rule, and it leads on", "[recovery]") {
  std::size_t found = 0;
  for (const RecoveryStep step : all_steps())
    for (const RecoveryEvent event : all_events()) {
      CAPTURE(word(step), word(event));
      int in_table = 0;
      for (const RecoveryRule& rule : recovery_rules()) in_table += rule.from == step && rule.on == event;
      const auto rule = next(step, event);
      CHECK(in_table == (rule ? 1 : 0));
      if (!rule) continue;
      ++found;
      // forward only, but for a step that is tried once more: so a recovery ends
      if (event == RecoveryEvent::Obstructed)
        CHECK(rule->to == step);
      else
        CHECK(static_cast<int>(rule->to) > static_cast<int>(step));
      CHECK(rule->reason.size() > 10);
    }
  CHECK(found == recovery_rules().size());
}

TEST_CASE("the hand is opened after evidence of support or a person's word, and on nothing else",
          "[recovery]") {
  for (const RecoveryRule& rule : recovery_rules()) {
    CAPTURE(word(rule.from), word(rule.on));
    if (rule.from == rule.to) continue;  // once more
    if (rule.to == RecoveryStep::Release)
      CHECK((rule.on == RecoveryEvent::Supported || rule.on == RecoveryEvent::PersonHolds));
    // away from a hand that may hold something the arm moves only once it was opened
    if (rule.from == RecoveryStep::Lower)
      CHECK((rule.to == RecoveryStep::TakeOver || rule.to == RecoveryStep::Release ||
             rule.to == RecoveryStep::Held));
    if (rule.from == RecoveryStep::TakeOver)
      CHECK((rule.to == RecoveryStep::Release || rule.to == RecoveryStep::Held));
    if (rule.to == RecoveryStep::DrawBack)
      CHECK((rule.on == RecoveryEvent::HandOpen || rule.on == RecoveryEvent::HandOpened));
  }
}

TEST_CASE("in every step an interruption, a lost device and a timeout hold the arm", "[recovery]") {
  for (const RecoveryStep step : all_steps()) {
    if (is_end(step)) continue;
    for (const RecoveryEvent event :
         {RecoveryEvent::Interrupted, RecoveryEvent::DeviceLost, RecoveryEvent::TimeOut}) {
      CAPTURE(word(step), word(event));
      REQUIRE(next(step, event));
      CHECK(next(step, event)->to == RecoveryStep::Held);
    }
    // whatever moves is asked for, and may be declined
    if (step != RecoveryStep::Assess) {
      REQUIRE(next(step, RecoveryEvent::Declined));
      CHECK(next(step, RecoveryEvent::Declined)->to == RecoveryStep::Held);
    }
  }
}

TEST_CASE("nothing leads out of the ends, and from every step both can be reached", "[recovery]") {
  for (const RecoveryStep start : all_steps()) {
    std::set<RecoveryStep> met{start};
    std::queue<RecoveryStep> open({start});
    for (; !open.empty(); open.pop())
      for (const RecoveryEvent event : all_events())
        if (const auto rule = next(open.front(), event); rule && met.insert(rule->to).second)
          open.push(rule->to);
    CAPTURE(word(start));
    if (is_end(start)) {
      CHECK(met.size() == 1);
    } else {
      CHECK(met.count(RecoveryStep::Done) == 1);
      CHECK(met.count(RecoveryStep::Held) == 1);
    }
  }
}
