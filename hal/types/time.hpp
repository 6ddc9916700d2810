#pragma once

#include <chrono>

namespace colift::hal {

/// Nanoseconds since an origin of the clock's choosing: boot on the robot, zero in simulation.
/// A time of measurement travels with the data; a time of arrival is never used in its place.
using Timestamp = std::chrono::nanoseconds;
using Duration = std::chrono::nanoseconds;

[[nodiscard]] constexpr double seconds(Duration d) {
  return std::chrono::duration<double>(d).count();
}

/// The nearest nanosecond to a time that is not negative (s).
[[nodiscard]] constexpr Duration duration_of(double s) {
  return Duration(static_cast<Duration::rep>(s * 1e9 + 0.5));
}

/// Where time comes from. Code under test is handed one of these and never reads a wall clock.
class Clock {
 public:
  virtual ~Clock() = default;

  /// Monotonic: never runs backwards. Any thread.
  [[nodiscard]] virtual Timestamp now() const = 0;
};

/// The machine's monotonic clock.
class SteadyClock final : public Clock {
 public:
  [[nodiscard]] Timestamp now() const override { return std::chrono::steady_clock::now().time_since_epoch(); }
};

/// Time that is advanced by its owner only: tests and lock-step simulation.
class ManualClock final : public Clock {
 public:
  [[nodiscard]] Timestamp now() const override { return now_; }
  void advance(Duration by) { now_ += by; }

 private:
  Timestamp now_{0};
};

}  // namespace colift::hal
