#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "control/config/method.hpp"
#include "hal/types/result.hpp"
#include "sim_hal/scenario/scenario.hpp"

namespace colift::experiments {

/// A whole lift of a trial as `colift run` makes it once more, to be watched and recorded.
struct KeptLift {
  sim_hal::Scenario scenario;
  std::uint64_t seed = 0;  ///< Of the run.
  std::string rig = {};    ///< Whose sensors have faults (`--rig`); empty: ideal ones.
};

/// Writes FOLDER/NAME.yaml, whose head says the command that repeats the run. Errors: it cannot be written.
[[nodiscard]] hal::Result<std::filesystem::path> keep_lift(const KeptLift& lift, control::Method method,
                                                           const std::filesystem::path& folder,
                                                           const std::string& name);

}  // namespace colift::experiments
