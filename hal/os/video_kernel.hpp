#pragma once

#include <memory>

#include "hal/video_calls.hpp"

namespace colift::hal {

/// The calls as this machine's kernel answers them.
[[nodiscard]] std::unique_ptr<VideoCalls> make_video_kernel();

}  // namespace colift::hal
