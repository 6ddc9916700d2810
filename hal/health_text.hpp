#pragma once

#include "hal/device.hpp"

namespace colift::hal {

/// As documents and screens have it: "streaming", "lost", ...
[[nodiscard]] inline const char* to_string(DeviceHealth::State state) {
  switch (state) {
    case DeviceHealth::State::Absent:
      return "absent";
    case DeviceHealth::State::Opening:
      return "opening";
    case DeviceHealth::State::Streaming:
      return "streaming";
    case DeviceHealth::State::Stalled:
      return "stalled";
    case DeviceHealth::State::Lost:
      return "lost";
    case DeviceHealth::State::Failed:
      return "failed";
  }
  return "unknown";
}

}  // namespace colift::hal
