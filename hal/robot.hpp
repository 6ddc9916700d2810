#pragma once

#include <memory>
#include <vector>

#include "hal/arm.hpp"
#include "hal/depth_camera.hpp"
#include "hal/hand.hpp"
#include "hal/types/camera_name.hpp"
#include "hal/types/time.hpp"

namespace colift::hal {

/// All that control is given. Which back ends stand behind it is decided in one file of tools/.
struct Robot {
  std::unique_ptr<Arm> arm;
  std::unique_ptr<Hand> hand;
  std::unique_ptr<DepthCamera> camera;
  std::vector<std::unique_ptr<DepthCamera>> more_cameras;  ///< Other views of the same scene; may be empty.
  std::unique_ptr<Clock> clock;
};

}  // namespace colift::hal
