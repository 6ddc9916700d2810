#pragma once

#include <string>

#include "tools/bring_up/hal_arm_task.hpp"
#include "tools/bring_up/hal_arm_view.hpp"

namespace colift::tools {

/// Document colift.hal.arm/1 of one verb: connection, answers, drives, program, joints, what stands against
/// command mode, and how the task ended.
[[nodiscard]] std::string arm_document(const std::string& verb, const ArmView& view,
                                       const hal::RobotModel& model, const ArmTask& task,
                                       const ArmTaskEnd& end);

/// The same schema for `limits`.
[[nodiscard]] std::string limits_document(const hal::RobotModel& model, const hal::GuardConfig& guard);

}  // namespace colift::tools
