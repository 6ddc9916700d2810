#include "tests/support/forked_lifts.hpp"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <set>
#include <stdexcept>

namespace colift::tests {
namespace {

std::string everything_told(const SimulatedLift& lift) {
  std::string all;
  for (const auto& s : lift.record.states)
    all += fmt::format("{:.2f} {}: {}\n", hal::seconds(s.at), control::word(s.state), s.reason);
  for (const auto& f : lift.record.faults)
    all += fmt::format("{:.2f} {}: {}\n", hal::seconds(f.at), f.device, f.what);
  if (lift.wire) {
    for (const auto& b : lift.wire->broken_rules) all += "broken: " + b.reason + "\n";
    for (const auto& m : lift.wire->mode_changes) all += "mode: " + m.reason + "\n";
  }
  for (std::size_t r = 0; lift.pucks && r < sim_hal::kHandRules; ++r)
    if (lift.pucks->broken[r] > 0)
      all += fmt::format("broken: {}: {}\n", sim_hal::kHandRuleNames[r], lift.pucks->first[r]);
  return all;
}

double time_in(control::Task state, const std::vector<control::StateChange>& states) {
  for (std::size_t i = 0; i + 1 < states.size(); ++i)
    if (states[i].state == state) return hal::seconds(states[i + 1].at - states[i].at);
  return 0.0;
}

void put(int pipe, const void* bytes, std::size_t size) {
  for (const char* at = static_cast<const char*>(bytes); size > 0;) {
    const ssize_t n = ::write(pipe, at, size);
    if (n <= 0) ::_exit(3);
    at += n;
    size -= static_cast<std::size_t>(n);
  }
}

bool get(int pipe, void* bytes, std::size_t size) {
  for (char* at = static_cast<char*>(bytes); size > 0;) {
    const ssize_t n = ::read(pipe, at, size);
    if (n <= 0) return false;
    at += n;
    size -= static_cast<std::size_t>(n);
  }
  return true;
}

void put(int pipe, const std::string& text) {
  const std::uint64_t size = text.size();
  put(pipe, &size, sizeof size);
  put(pipe, text.data(), size);
}

bool get(int pipe, std::string& text) {
  std::uint64_t size = 0;
  if (!get(pipe, &size, sizeof size) || size > (1U << 24)) return false;
  text.resize(size);
  return get(pipe, text.data(), size);
}

/// The part of ForkedEnd that is no text.
struct Numbers {
  control::RunRecord::Result outcome;
  control::Task end;
  bool hand_keeps_grip, hit_something, touches_object;
  unsigned divergences, broken_rules;
  double in_state_s, most_open_while_loaded_rad;
  unsigned long visited;
};

void send(int pipe, control::Task in, const SimulatedLift& lift) {
  Numbers n{};
  n.outcome = lift.record.outcome;
  n.end = lift.record.states.back().state;
  n.hand_keeps_grip = lift.record.hand_keeps_grip;
  n.hit_something = lift.hit_something;
  n.divergences = static_cast<unsigned>(lift.at_end.divergences);
  n.touches_object = lift.at_end.robot_touches_object;
  if (lift.wire) n.broken_rules = static_cast<unsigned>(lift.wire->broken_rules_in_all);
  for (std::size_t r = 0; lift.pucks && r < sim_hal::kHandRules; ++r)
    n.broken_rules += static_cast<unsigned>(lift.pucks->broken[r]);
  n.most_open_while_loaded_rad = lift.most_open_while_loaded_rad;
  std::bitset<control::kTasks> visited;
  for (const auto& s : lift.record.states) visited.set(static_cast<std::size_t>(s.state));
  n.visited = visited.to_ulong();
  n.in_state_s = time_in(in, lift.record.states);
  put(pipe, &n, sizeof n);
  put(pipe, lift.record.reason);
  put(pipe, everything_told(lift));
}

ForkedEnd receive(int pipe, pid_t child) {
  ForkedEnd e;
  Numbers n{};
  e.ran = get(pipe, &n, sizeof n) && get(pipe, e.reason) && get(pipe, e.told);
  e.outcome = n.outcome;
  e.end = n.end;
  e.hand_keeps_grip = n.hand_keeps_grip;
  e.hit_something = n.hit_something;
  e.divergences = n.divergences;
  e.broken_rules = n.broken_rules;
  e.in_state_s = n.in_state_s;
  e.touches_object = n.touches_object;
  e.most_open_while_loaded_rad = n.most_open_while_loaded_rad;
  e.visited = std::bitset<control::kTasks>(n.visited);
  ::close(pipe);
  int status = 0;
  ::waitpid(child, &status, 0);
  if (WIFSIGNALED(status)) e.crash = fmt::format("signal {}", WTERMSIG(status));
  if (WIFEXITED(status) && WEXITSTATUS(status) != 0) e.crash = fmt::format("exit {}", WEXITSTATUS(status));
  return e;
}

}  // namespace

std::vector<ForkedEnd> lift_forked(const sim_hal::Scenario& scenario, const control::Config& config,
                                   const OverWire& over, const std::vector<ForkedFault>& faults) {
  std::vector<ForkedEnd> ends(faults.size());
  std::set<control::Task> entered;
  int pipe_up = -1;  // of a branch, to who branched it off
  const ForkedFault* branch = nullptr;
  OverWire wire = over;
  wire.entered = [&](control::Task state) -> std::optional<WireFault> {
    if (branch && branch->each_time && branch->in == state) return branch->fault;
    if (branch || !entered.insert(state).second) return std::nullopt;
    for (std::size_t i = 0; i < faults.size(); ++i) {
      if (faults[i].in != state) continue;
      int ends_of_pipe[2];
      if (::pipe(ends_of_pipe) != 0) throw std::runtime_error("no pipe");
      const pid_t child = ::fork();
      if (child < 0) throw std::runtime_error("no process");
      if (child == 0) {
        ::close(ends_of_pipe[0]);
        pipe_up = ends_of_pipe[1];
        branch = &faults[i];
        return branch->fault;
      }
      ::close(ends_of_pipe[1]);
      ends[i] = receive(ends_of_pipe[0], child);
    }
    return std::nullopt;
  };
  try {
    const SimulatedLift lift = simulate(scenario, control::Method::Fast, 1, config, wire);
    if (!branch) return ends;
    send(pipe_up, branch->in, lift);
  } catch (const std::exception&) {
    if (!branch) throw;
    ::_exit(2);
  }
  // no destructor, no test of the parent runs here
  ::_exit(0);
}

}  // namespace colift::tests
