// The files of calibrations: of a camera the samples' and the result's, of a hand its scales.

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "hal/drivers/barrett_can/calibration/hand_calibration.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "perception/calibration/calibration_file.hpp"
#include "perception/calibration/sample_folder.hpp"

using namespace colift;

namespace {

void demand(bool fine, const char* what) {
  if (fine) return;
  std::fprintf(stderr, "%s\n", what);
  std::abort();
}

void demand_place(const hal::Error& error) {
  demand(error.code == hal::ErrorCode::BadConfig, "another error than BadConfig");
  demand(error.where.starts_with("input.yaml") && !error.detail.empty(), "an error without a place");
  demand(error.text().find('\n') == std::string::npos, "an error of several lines");
}

/// Joints with the limits of the arm; the files need no more of a robot.
const hal::RobotModel& robot() {
  static const hal::RobotModel model = [] {
    hal::RobotModel m;
    m.links.resize(hal::kArmJoints);
    for (int i = 0; i < hal::kArmJoints; ++i) {
      m.arm[static_cast<std::size_t>(i)] = i;
      m.links[static_cast<std::size_t>(i)].lower_rad = -2.9;
      m.links[static_cast<std::size_t>(i)].upper_rad = 2.9;
    }
    return m;
  }();
  return model;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  if (const auto file = perception::parse_calibration(text, "input.yaml")) {
    demand(file->X_BC().matrix().allFinite(), "an accepted camera is nowhere");
    demand(file->covariance.empty() || file->covariance.size() == 81, "half a covariance");
  } else {
    demand_place(file.error());
  }
  if (const auto file = hal::parse_hand_calibration(text, "input.yaml")) {
    const auto again = hal::parse_hand_calibration(text_of(*file), "input.yaml");
    demand(again && again->pucks.size() == file->pucks.size(), "a file that is not read as it was written");
  } else {
    demand_place(file.error());
  }
  if (const auto file = perception::parse_samples(text, "input.yaml", robot())) {
    for (const auto& s : file->samples) {
      demand(s.joints_rad.size() == hal::kArmJoints, "an arm of other joints");
      demand(s.images.empty() != s.pixel.empty(), "a sample without a spot");
      for (const auto& image : s.images)
        demand(image.file.find("..") == std::string::npos && image.file.front() != '/', "a file outside");
    }
  } else {
    demand_place(file.error());
  }
  return 0;
}
