#include "control/monitor/heartbeat.hpp"

#include <algorithm>

namespace colift::control {

double BeatMonitor::update(std::uint64_t count, hal::Timestamp now) noexcept {
  if (!begun_ || count != count_)
    silent_ = hal::Duration(0);
  else
    silent_ += std::clamp(now - updated_at_, hal::Duration(0), kMaxStep);
  begun_ = true;
  count_ = count;
  updated_at_ = now;
  return silent_s();
}

}  // namespace colift::control
