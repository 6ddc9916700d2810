#include "tools/recover/cmd_recover.hpp"

#include <cstdio>

#include "tools/cli/config_of.hpp"
#include "tools/cli/interrupt.hpp"
#include "tools/recover/operator.hpp"
#include "tools/recover/recover_json.hpp"

namespace colift::tools {
namespace {

int exit_code(const control::RecoveryRecord& record) {
  if (InterruptGuard::asked()) return kInterrupted;
  if (record.recovered) return kDone;
  return record.device_failed ? kDeviceFailed : kNoGoal;
}

}  // namespace

control::RecoveryRecord recover_rig(Rig& rig, const Setup& setup, std::uint64_t seed,
                                    const control::RecoveryHooks& hooks) {
  const hal::SteadyClock stopwatch;
  const control::RigView view{*rig.model, setup.hand, setup.hand_tables, rig.X_WC, {}};
  control::Recovery recovery(rig.robot, view, setup.config, {setup.method, seed, rig.drive, rig.home_rad},
                             stopwatch);
  return recovery.run(hooks);
}

int cmd_recover(const CommonOptions& common, const RecoverOptions& options, const WiredDevices* wired) {
  RunOptions run;
  run.robot = options.robot;
  run.scenario = options.scenario;
  auto setup = load_setup(config_of_run(common, run));
  if (!setup) return report_error("recover", setup.error());
  show_warnings("recover", common, *setup);
  std::optional<hal::Pose> X_WC;
  if (setup->calibration) X_WC = setup->calibration->X_BC();
  auto rig = open_rig({options.robot, options.scenario, run.seed, X_WC}, setup->config, wired);
  if (!rig) return report_error("recover", rig.error());
  if (options.yes && !rig->simulated)
    return report_error("recover", {hal::ErrorCode::BadInput, "--yes",
                                    "is for simulated and emulated rigs; here a person confirms each step"});
  if (!options.yes && !KeyboardOperator::is_there())
    return report_error("recover",
                        {hal::ErrorCode::BadInput, "stdin",
                         "is no terminal; expected a person at the keyboard, who confirms each step"});
  const InterruptGuard signals;
  std::optional<KeyboardOperator> keyboard;
  if (!options.yes) keyboard.emplace(setup->config.recovery.hold_to_run_s);
  const auto hooks = keyboard ? keyboard->hooks(InterruptGuard::asked)
                              : confirm_everything(InterruptGuard::asked, common.quiet);
  const control::RecoveryRecord record = recover_rig(*rig, *setup, run.seed, hooks);
  const int code = exit_code(record);
  if (common.json)
    std::puts(recover_document(record).c_str());
  else
    std::printf("%s: %s\n", record.recovered ? "recovered" : "held", record.reason.c_str());
  std::fflush(stdout);
  return code;
}

}  // namespace colift::tools
