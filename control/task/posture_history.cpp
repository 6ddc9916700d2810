#include "control/task/posture_history.hpp"

#include <algorithm>

namespace colift::control {

RobotPosture PostureHistory::at(hal::Timestamp at, const RobotPosture& now) const {
  const std::size_t n = std::min(remembered_, past_.size());
  const Entry* after = nullptr;
  for (std::size_t i = 1; i <= n; ++i) {
    const Entry& p = past_[(remembered_ - i) % past_.size()];
    if (p.at > at) {
      after = &p;
      continue;
    }
    if (!after || after->at == p.at) return p.posture;
    const double part = hal::seconds(at - p.at) / hal::seconds(after->at - p.at);
    RobotPosture out = p.posture;  // fingers move little between two cycles
    out.q_rad += part * (after->posture.q_rad - p.posture.q_rad);
    return out;
  }
  return after ? after->posture : now;
}

}  // namespace colift::control
