// When did this machine's processors stand still? A thread on each, with the highest priority that the kernel
// gives (SCHED_FIFO 99), wakes up five times in a millisecond; what it finds itself late by, no program of a
// lower priority could have had. What cyclictest sums up, with its times: so that a missed answer can be laid
// beside it.
//
//   standstill [SECONDS]      until SIGINT or SIGTERM without; one JSON document at the end
//
// Exit code 3 when the kernel does not grant the priority: then it would measure what others do, not the
// machine.

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>
#include <sys/prctl.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

namespace {

constexpr double kEvery_s = 0.0002, kWorthTelling_s = 0.0003;
constexpr std::size_t kMostSpans = 200000;

std::atomic<bool> stop{false};

double now_s() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void sleep_until(double at_s) {
  timespec t{};
  t.tv_sec = static_cast<time_t>(at_s);
  t.tv_nsec = static_cast<long>(1e9 * (at_s - static_cast<double>(t.tv_sec)));
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr);
}

struct Span {
  double from_s, to_s;
};

/// One processor's witness.
struct Observer {
  int cpu = 0;
  bool granted = false;
  double worst_s = 0.0;
  std::vector<Span> stood;
};

void watch(Observer& observer, double until_s) {
  cpu_set_t own;
  CPU_ZERO(&own);
  CPU_SET(observer.cpu, &own);
  sched_param highest{};
  highest.sched_priority = sched_get_priority_max(SCHED_FIFO);
  observer.granted = pthread_setaffinity_np(pthread_self(), sizeof own, &own) == 0 &&
                     pthread_setschedparam(pthread_self(), SCHED_FIFO, &highest) == 0;
  if (!observer.granted) return;
  observer.stood.reserve(kMostSpans);
  double due_s = now_s() + kEvery_s;
  while (!stop && due_s < until_s) {
    sleep_until(due_s);
    const double woke_s = now_s();
    observer.worst_s = std::max(observer.worst_s, woke_s - due_s);
    if (woke_s - due_s > kWorthTelling_s && observer.stood.size() < kMostSpans)
      observer.stood.push_back({due_s, woke_s});
    due_s = std::max(due_s + kEvery_s, woke_s);
  }
}

}  // namespace

int main(int argc, char** argv) {
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);  // with that priority nobody's orphan
  const double for_s = argc > 1 ? std::atof(argv[1]) : 1e9;
  std::signal(SIGINT, [](int) { stop = true; });
  std::signal(SIGTERM, [](int) { stop = true; });
  cpu_set_t all;
  CPU_ZERO(&all);
  sched_getaffinity(0, sizeof all, &all);
  std::vector<Observer> observers;
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu)
    if (CPU_ISSET(cpu, &all)) observers.emplace_back().cpu = cpu;
  std::vector<std::thread> threads;
  const double until_s = now_s() + for_s;
  threads.reserve(observers.size());
  for (Observer& observer : observers) threads.emplace_back([&] { watch(observer, until_s); });
  for (std::thread& thread : threads) thread.join();

  nlohmann::json document = {{"schema", "colift.standstill/1"}, {"cpus", nlohmann::json::array()}};
  bool granted = true;
  for (const Observer& observer : observers) {
    granted = granted && observer.granted;
    auto spans = nlohmann::json::array();
    for (const Span& span : observer.stood) spans.push_back({span.from_s, span.to_s});
    document["cpus"].push_back(
        {{"cpu", observer.cpu}, {"worst_s", observer.worst_s}, {"stood_monotonic_s", spans}});
  }
  if (!granted) {
    fmt::print(stderr, "standstill: the kernel does not grant SCHED_FIFO 99 (ulimit -r, or root)\n");
    return 3;
  }
  fmt::print("{}\n", document.dump());
}
