#include "hal/drivers/kinect/device_clock.hpp"

#include <algorithm>
#include <cmath>

#include "hal/drivers/kinect/kinect_facts.hpp"

namespace colift::hal::kinect {
namespace {

constexpr double kWrap = 4294967296.0;

Duration of_ticks(std::int64_t ticks) {
  return Duration(ticks * 50 / 3);  // 60 MHz: 16 2/3 ns
}

}  // namespace

DeviceClock::Times DeviceClock::note(std::uint32_t ticks, Timestamp arrived) {
  if (!last_ticks_) {
    ticks_ = 0;
  } else {
    // the counter alone knows the time but for whole wraps; the host knows those
    const auto step = static_cast<std::int32_t>(ticks - *last_ticks_);
    const double passed = seconds(arrived - arrived_) * kTicksPerSecond;
    const double wraps = std::max(0.0, std::round((passed - static_cast<double>(step)) / kWrap));
    ticks_ += step + static_cast<std::int64_t>(wraps * kWrap);
  }
  last_ticks_ = ticks;
  arrived_ = arrived;
  return delay_.note(of_ticks(ticks_), arrived);
}

}  // namespace colift::hal::kinect
