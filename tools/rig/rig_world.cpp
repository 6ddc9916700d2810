#include "tools/rig/rig_world.hpp"

#include <chrono>
#include <cmath>

#include "tools/rig/back_ends.hpp"

namespace colift::tools {

hal::Result<sim_hal::Scenario> read_scenario(const std::optional<std::filesystem::path>& file) {
  if (file && *file == kClearedFloor)
    return sim_hal::parse_scenario(
        "schema: colift.scenario/1\n"
        "object: {kind: box, size: [0.3, 0.3, 0.3], mass: 2.0, pose: {xyz: [-1.6, 1.6, 0.0]}}\n"
        "camera: {xyz: [2.1, -0.7, 1.3], look_at: [0.65, 0.0, 0.45]}\n"
        "partner: {kind: none}\n",
        "cleared floor");
  if (file) return sim_hal::load_scenario(*file);
  return sim_hal::built_in_scenario();
}

hal::Result<sim_hal::Scenario> read_absolute_scenario(const std::optional<std::filesystem::path>& file) {
  auto scenario = read_scenario(file);
  if (!scenario) return scenario;
  const std::string entry = sim_hal::relative_time(*scenario);
  if (entry.empty()) return scenario;
  return hal::failure(hal::ErrorCode::BadConfig, file ? file->string() : "scenario",
                      entry +
                          " counts from a state of the task, which an emulated device does not know; "
                          "expected a time since the start (at_s, enters_s)");
}

hal::Result<std::shared_ptr<const hal::RobotModel>> read_model(const std::string& file) {
  if (file.empty()) return std::make_shared<hal::RobotModel>(hal::built_in_robot());
  auto model = hal::load_robot(file);
  if (!model) return tl::unexpected(model.error());
  return std::make_shared<hal::RobotModel>(std::move(*model));
}

hal::Result<std::shared_ptr<sim_hal::SimWorld>> make_world(const RobotFile& file,
                                                           const sim_hal::Scenario& scenario,
                                                           const hal::RobotModel& model, std::uint64_t seed) {
  sim_hal::SimConfig sim;
  const double period_ms = file.arm == "simulated" ? file.arm_period_ms : file.fri.cycle_ms;
  sim.arm_period = std::chrono::milliseconds(std::lround(period_ms));
  auto world = sim_hal::SimWorld::make(scenario, model, seed, sim);
  if (!world) return tl::unexpected(world.error());
  return std::shared_ptr<sim_hal::SimWorld>(std::move(*world));
}

}  // namespace colift::tools
