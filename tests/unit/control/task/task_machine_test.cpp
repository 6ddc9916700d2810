#include "control/task/machine/task_machine.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cctype>
#include <queue>
#include <set>
#include <vector>

using namespace colift::control;

namespace {

std::vector<Task> all_tasks() {
  std::vector<Task> tasks;
  for (int t = 0; t < kTasks; ++t) tasks.push_back(static_cast<Task>(t));
  return tasks;
}

std::vector<Event> all_events() {
  std::vector<Event> events;
  for (int e = 0; e < kEvents; ++e) events.push_back(static_cast<Event>(e));
  return events;
}

/// The object may hang in the air.
bool in_the_air(Task t) {
  return t == Task::TestLift || t == Task::Lift || t == Task::Hold || t == Task::Lower || t == Task::Pause;
}

bool is_stop(Task t) {
  return t == Task::Refused || t == Task::Aborted || t == Task::Stopped;
}

/// States that can be reached from `start` by edges that `allowed` lets through, the start among them.
template <class Allowed>
std::set<Task> reachable(Task start, Allowed allowed) {
  std::set<Task> seen{start};
  std::queue<Task> open({start});
  for (; !open.empty(); open.pop())
    for (const Event event : all_events()) {
      const auto rule = next(open.front(), event);
      if (rule && allowed(*rule) && seen.insert(rule->to).second) open.push(rule->to);
    }
  return seen;
}

std::set<Task> reachable(Task start) {
  return reachable(start, [](const Rule&) { return true; });
}

}  // namespace

TEST_CASE("every state and event has at most one rule, and next() finds exactly that one", "[task]") {
  std::size_t found = 0;
  for (const Task task : all_tasks())
    for (const Event event : all_events()) {
      int in_table = 0;
      for (const Rule& rule : rules()) in_table += rule.from == task && rule.on == event;
      const auto rule = next(task, event);
      CHECK(in_table == (rule ? 1 : 0));
      if (!rule) continue;
      ++found;
      CHECK(rule->from == task);
      CHECK(rule->on == event);
    }
  CHECK(found == rules().size());
}

TEST_CASE("every rule says why, and leads somewhere else", "[task]") {
  for (const Rule& rule : rules()) {
    CAPTURE(word(rule.from), word(rule.on));
    CHECK(rule.reason.size() > 10);
    CHECK(std::islower(static_cast<unsigned char>(rule.reason.front())));
    CHECK(rule.reason.back() != '.');
    CHECK(rule.to != rule.from);
  }
}

TEST_CASE("states and events have words of their own", "[task]") {
  std::set<std::string_view> tasks, events;
  for (const Task task : all_tasks()) {
    CHECK_FALSE(word(task).empty());
    CHECK_FALSE(waits_for(task).empty());
    CHECK(word(task).find_first_not_of("abcdefghijklmnopqrstuvwxyz-") == std::string_view::npos);
    tasks.insert(word(task));
  }
  for (const Event event : all_events()) {
    CHECK_FALSE(word(event).empty());
    events.insert(word(event));
  }
  CHECK(tasks.size() == std::size_t{kTasks});
  CHECK(events.size() == std::size_t{kEvents});
}

TEST_CASE("every event means something somewhere", "[task]") {
  for (const Event event : all_events()) {
    bool used = false;
    for (const Task task : all_tasks()) used = used || next(task, event);
    CAPTURE(word(event));
    CHECK(used);
  }
}

TEST_CASE("from every state an interruption stops the job in one step", "[task]") {
  for (const Task task : all_tasks()) {
    if (is_end(task)) continue;
    CAPTURE(word(task));
    const auto rule = next(task, Event::Interrupted);
    REQUIRE(rule);
    CHECK(is_stop(rule->to));
    // with a hand at the object or an arm under way only standing still is safe
    if (is_loaded(task) || is_moving(task)) CHECK(rule->to == Task::Stopped);
  }
}

TEST_CASE("a lost arm or hand stops the job from every state", "[task]") {
  for (const Task task : all_tasks())
    for (const Event event : {Event::ArmLost, Event::HandLost}) {
      const auto rule = next(task, event);
      CAPTURE(word(task), word(event));
      CHECK(rule.has_value() == !is_end(task));
      if (rule) CHECK(rule->to == Task::Stopped);
    }
}

TEST_CASE("nothing leads out of an end state, so nothing moves after a stop", "[task]") {
  for (const Task task : all_tasks())
    for (const Event event : all_events())
      if (is_end(task)) CHECK_FALSE(next(task, event));
  CHECK(reachable(Task::Stopped) == std::set<Task>{Task::Stopped});
}

TEST_CASE("every state can be reached, and from every state there is a way to an end", "[task]") {
  const std::set<Task> met = reachable(Task::Observe);
  CHECK(met.size() == std::size_t{kTasks});
  for (const Task task : all_tasks()) {
    const std::set<Task> ahead = reachable(task);
    CAPTURE(word(task));
    CHECK(std::any_of(ahead.begin(), ahead.end(), [](Task t) { return is_end(t); }));
    // the goal is never out of reach before the job has ended
    // ... but for an arm that somebody pushed: a person decides what comes then
    if (!is_end(task)) CHECK(ahead.count(Task::Done) == (task == Task::Yield ? 0 : 1));
  }
}

TEST_CASE("a wait without end is not possible: time out leads on from every state", "[task]") {
  for (const Task task : all_tasks()) {
    if (is_end(task)) continue;
    CAPTURE(word(task));
    const auto rule = next(task, Event::TimeOut);
    REQUIRE(rule);
    // to an end, to the ground, or to an open hand at an object on the ground
    CHECK((is_end(rule->to) || rule->to == Task::Lower || rule->to == Task::Release));
    // time outs alone, however many, come to an end without the goal having been claimed
    Task now = task;
    for (int i = 0; i < kTasks && !is_end(now); ++i) now = next(now, Event::TimeOut)->to;
    CHECK(is_stop(now));
  }
}

TEST_CASE("a loaded hand opens on release alone", "[task]") {
  for (const Rule& rule : rules()) {
    CAPTURE(word(rule.from), word(rule.on), word(rule.to));
    // a state that closes the hand leads on with it closed: to another loaded one, or to a stop that keeps it
    if (is_loaded(rule.from) && rule.from != Task::Release)
      CHECK((is_loaded(rule.to) || rule.to == Task::Stopped));
    // in the air, only the word of the ground opens the hand
    if (in_the_air(rule.from) && rule.to == Task::Release) CHECK(rule.on == Event::OnGround);
  }
  // without passing through Release, no state with an empty hand follows from a loaded one
  for (const Task task : all_tasks()) {
    if (!is_loaded(task) || task == Task::Release) continue;
    for (const Task later : reachable(task, [](const Rule& r) { return r.from != Task::Release; }))
      CHECK((is_loaded(later) || later == Task::Stopped));
  }
}

TEST_CASE("one silent finger opens the others only while nothing is held yet", "[task]") {
  for (const Task task : all_tasks()) {
    CAPTURE(word(task));
    const auto rule = next(task, Event::FingerLost);
    CHECK(rule.has_value() == (task == Task::Close));
    if (rule) CHECK(rule->to == Task::Release);
  }
}

TEST_CASE("at the end of the arm's reach a lift holds: nothing lowers or opens by itself", "[task]") {
  for (const Task task : {Task::TestLift, Task::Lift, Task::Hold, Task::Lower}) {
    REQUIRE(next(task, Event::EndOfReach));
    CHECK(next(task, Event::EndOfReach)->to == Task::Stopped);
  }
}

TEST_CASE("nobody lifts before the grip was verified and the partner was ready", "[task]") {
  const auto is_ready = [](Event e) { return e == Event::PartnerReady || e == Event::TestDue; };
  for (const Event skipped : {Event::HandHeld, Event::GripGood, Event::PartnerReady, Event::Arrived}) {
    CAPTURE(word(skipped));
    const auto without = reachable(
        Task::Observe, [&](const Rule& r) { return is_ready(skipped) ? !is_ready(r.on) : r.on != skipped; });
    CHECK(without.count(Task::Lift) == 0);
    CHECK(without.count(Task::TestLift) == 0);
  }
}

TEST_CASE("nothing moves before a partner holds the object, a grasp is chosen and a way is planned",
          "[task]") {
  for (const Event skipped :
       {Event::SceneKnown, Event::PartnerGrasped, Event::GraspChosen, Event::PlanReady}) {
    CAPTURE(word(skipped));
    for (const Task task : reachable(Task::Observe, [&](const Rule& r) { return r.on != skipped; }))
      CHECK_FALSE(is_moving(task));
  }
}

TEST_CASE("unexpected force stops the arm in every state, which yields and then waits for a person",
          "[task]") {
  for (const Task task : all_tasks()) {
    CAPTURE(word(task));
    if (is_end(task) || task == Task::Yield) continue;
    REQUIRE(next(task, Event::Blocked));
    CHECK(next(task, Event::Blocked)->to == Task::Yield);
  }
  // nothing moves after it, nothing opens
  CHECK(reachable(Task::Yield) == std::set<Task>{Task::Yield, Task::Stopped});
}

TEST_CASE(
    "what is raised goes on from a pause only when the partner holds again, a person confirms, or it stands",
    "[task]") {
  CHECK(next(Task::Lower, Event::Obstructed)->to == Task::Pause);
  CHECK(next(Task::Pause, Event::PartnerBack)->to == Task::Lift);
  CHECK(next(Task::Pause, Event::HoldOver)->to == Task::Lower);
  CHECK(next(Task::Pause, Event::LowerConfirmed)->to == Task::Lower);
  CHECK(next(Task::Pause, Event::OnGround)->to == Task::Lower);  // both ends are seen on the ground
  for (const Event event : all_events()) {
    const auto rule = next(Task::Pause, event);
    CAPTURE(word(event));
    if (rule && event != Event::PartnerBack && event != Event::HoldOver && event != Event::LowerConfirmed &&
        event != Event::OnGround)
      CHECK((rule->to == Task::Stopped || rule->to == Task::Yield));
  }
}

TEST_CASE("an arm that nobody lets continue holds, whatever it was doing", "[task]") {
  for (const Task task : all_tasks())
    for (const Event event : {Event::StaysNear, Event::NotConfirmed}) {
      CAPTURE(word(task), word(event));
      const auto rule = next(task, event);
      // a release may set down what the hand still carries
      CHECK(rule.has_value() == (is_moving(task) || task == Task::Release));
      if (rule) CHECK(rule->to == Task::Stopped);
    }
}

TEST_CASE("a hand without evidence that the object stands stays closed", "[task]") {
  REQUIRE(next(Task::Release, Event::StillLoaded));
  CHECK(next(Task::Release, Event::StillLoaded)->to == Task::Stopped);
}

TEST_CASE("a partner who lets go is never left with an arm that goes on", "[task]") {
  CHECK(next(Task::Decide, Event::PartnerLetGo)->to == Task::AwaitPartner);
  CHECK(next(Task::Plan, Event::PartnerLetGo)->to == Task::AwaitPartner);
  CHECK(next(Task::Approach, Event::PartnerLetGo)->to == Task::BackOff);
  for (const Task task : {Task::Close, Task::Verify, Task::AwaitReady})
    CHECK(next(task, Event::PartnerLetGo)->to == Task::Release);  // the object still stands on the ground
  for (const Task task : {Task::TestLift, Task::Lift, Task::Hold, Task::Lower})
    CHECK(next(task, Event::PartnerLetGo)->to == Task::Pause);  // a person may be under it
}

TEST_CASE("an arm that cannot see does not approach", "[task]") {
  const auto rule = next(Task::Approach, Event::CameraLost);
  REQUIRE(rule);
  CHECK_FALSE(is_moving(rule->to));
  // and it does not go on where it was: sees again, goes back, decides anew
  const auto on = reachable(rule->to, [](const Rule& r) { return r.on != Event::PartnerGrasped; });
  CHECK(on.count(Task::Approach) == 0);
  CHECK(on.count(Task::AwaitPartner) == 1);
}

TEST_CASE("the whole job from first look to home is one chain of events", "[task]") {
  Task now = Task::Observe;
  for (const Event event :
       {Event::SceneKnown, Event::PartnerGrasped, Event::GraspChosen, Event::PlanReady, Event::Arrived,
        Event::HandHeld, Event::GripGood, Event::PartnerReady, Event::AtHeight, Event::HoldOver,
        Event::OnGround, Event::HandOpen, Event::BackHome}) {
    const auto rule = next(now, event);
    CAPTURE(word(now), word(event));
    REQUIRE(rule);
    now = rule->to;
  }
  CHECK(now == Task::Done);
}

TEST_CASE("an object that hangs askew is put down, released and gripped elsewhere, without being lifted",
          "[task]") {
  Task now = Task::AwaitReady;
  for (const Event event :
       {Event::TestDue, Event::HangsAskew, Event::OnGround, Event::HandOpen, Event::TryAgain,
        Event::PartnerGrasped, Event::PartnerAsked, Event::PartnerGrasped}) {
    const auto rule = next(now, event);
    CAPTURE(word(now), word(event));
    REQUIRE(rule);
    now = rule->to;
    CHECK(now != Task::Lift);
  }
  CHECK(now == Task::Decide);
}

TEST_CASE("the drawing shows every rule", "[task]") {
  const std::string drawing = graph();
  CHECK(drawing.rfind("digraph", 0) == 0);
  CHECK(std::count(drawing.begin(), drawing.end(), '{') == std::count(drawing.begin(), drawing.end(), '}'));
  CHECK(std::count(drawing.begin(), drawing.end(), '"') % 2 == 0);
  for (const Rule& rule : rules()) {
    const std::string arrow = fmt::format("\"{}\" -> \"{}\"", word(rule.from), word(rule.to));
    const std::size_t at = drawing.find(arrow);
    REQUIRE(at != std::string::npos);
    CHECK(drawing.find(arrow, at + 1) == std::string::npos);
    const std::string line = drawing.substr(at, drawing.find('\n', at) - at);
    CAPTURE(line, word(rule.on));
    CHECK(line.find(rule.reason) != std::string::npos);
  }
}
