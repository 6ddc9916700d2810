#include "tools/run/run_pace.hpp"

#include <chrono>
#include <cmath>
#include <thread>

namespace colift::tools {

void Pace::wait_for(hal::Timestamp simulated) {
  if (speed_ <= 0.0) return;
  const hal::SteadyClock wall;
  if (!simulated_start_) {
    simulated_start_ = simulated;
    wall_start_ = wall.now();
    return;
  }
  const auto due =
      *wall_start_ + std::chrono::duration_cast<hal::Duration>((simulated - *simulated_start_) / speed_);
  if (due > wall.now()) std::this_thread::sleep_for(due - wall.now());
}

hal::Result<double> speed_of(const ViewOptions& options, control::Drive drive, bool published) {
  if (!options.speed) return (options.view || published) && drive == control::Drive::InStep ? 1.0 : 0.0;
  if (!std::isfinite(*options.speed) || *options.speed < 0.0)
    return hal::failure(hal::ErrorCode::BadInput, "--speed",
                        "expected 0 (as fast as it goes) or a positive number");
  if (drive != control::Drive::InStep && *options.speed != 1.0)
    return hal::failure(hal::ErrorCode::BadInput, "--speed",
                        "these devices run in real time; only 1 is possible");
  return drive == control::Drive::InStep ? *options.speed : 0.0;
}

}  // namespace colift::tools
