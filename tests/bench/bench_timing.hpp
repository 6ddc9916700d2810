#pragma once

#include <malloc.h>

#include <algorithm>
#include <ctime>
#include <vector>

namespace colift::bench {

/// CPU time of this thread (ms): what others do on the machine counts less than on a wall clock.
inline double cpu_ms() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Median time of a call over `rounds` calls, after one that is not counted (ms).
template <class Work>
double time_ms(int rounds, Work work) {
  work();
  std::vector<double> times;
  for (int i = 0; i < rounds; ++i) {
    const double start = cpu_ms();
    work();
    times.push_back(cpu_ms() - start);
  }
  return median(std::move(times));
}

/// Lets the process keep freed memory, as one that sees frame after frame would. Without it both contenders
/// are charged for fresh pages from the system in every round.
inline void keep_memory() {
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  mallopt(M_TOP_PAD, 64 << 20);
}

}  // namespace colift::bench
