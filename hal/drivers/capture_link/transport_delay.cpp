#include "hal/drivers/capture_link/transport_delay.hpp"

#include <algorithm>

namespace colift::hal::capture {
namespace {

constexpr Duration kWindow = std::chrono::seconds(5);

}  // namespace

TransportDelay::Times TransportDelay::note(Timestamp device, Timestamp arrived) {
  Times t;
  t.device = device;
  const Duration offset = arrived - device;
  if (!now_) {
    now_ = Min{offset, arrived};
  } else if (arrived - now_->since > kWindow) {
    before_ = now_;
    now_ = Min{offset, arrived};
  }
  now_->offset = std::min(now_->offset, offset);
  const Duration least = before_ ? std::min(now_->offset, before_->offset) : now_->offset;
  t.exposed = device + least;
  t.late = offset - least;
  return t;
}

}  // namespace colift::hal::capture
