#pragma once

#include "tools/run/run_view.hpp"

namespace colift::tests {

/// A whole run as it might have happened, made without control and physics: a table and a person are rendered
/// with the noise of a Kinect, really looked at and decided on; states, curves and truth are laid out by
/// hand.
struct RunExample {
  control::RunRecord record;
  tools::RunSetting setting;
  tools::RunTruth truth;
  tools::RunScenes scenes;

  [[nodiscard]] tools::RunView view() const { return {record, setting, &truth, &scenes}; }
};

/// Lifted 5 cm and put down again.
[[nodiscard]] RunExample lifted_run();

/// Nobody came.
[[nodiscard]] RunExample refused_run();

/// The partner let go in the air: stopped with the grip kept, and the camera was gone for a while.
[[nodiscard]] RunExample stopped_run();

}  // namespace colift::tests
