#include <stdexcept>

#include "hal/robot_model/robot_model.hpp"

namespace colift::hal {

const RobotModel& built_in_robot() {
  static const RobotModel model = [] {
    auto parsed = parse_robot(
#include "built_in_robot.inc"
        , "built-in robot");
    // the text is compiled in and tested: only a broken build gets here
    if (!parsed) throw std::logic_error(parsed.error().text());
    return *std::move(parsed);
  }();
  return model;
}

}  // namespace colift::hal
