#include "tools/bring_up/hand/cmd_calibrate_finger.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <utility>

#include "tools/bring_up/bring_up.hpp"
#include "tools/bring_up/finger/calibrate_finger.hpp"
#include "tools/bring_up/finger/finger_words.hpp"
#include "tools/bring_up/hand/hal_hand_task.hpp"
#include "tools/bring_up/hand/logged_bus.hpp"
#include "tools/cli/interrupt.hpp"
#include "tools/cli/session.hpp"
#include "tools/cli/today.hpp"
#include "tools/cli/wait_for_person.hpp"
#include "tools/visualization/file_output.hpp"

namespace colift::tools {

int cmd_calibrate_finger(const CommonOptions& common, const HalOptions& options,
                         const hal::BarrettHandConfig& config) {
  constexpr const char* kWhere = "hal hand calibrate";
  const auto bad = [&](const char* where, std::string why) {
    return report_error(kWhere, hal::Error{hal::ErrorCode::BadInput, where, std::move(why)});
  };
  const auto finger = parse_finger(options.finger);
  if (!finger) return bad("FINGER", fmt::format("\"{}\", expected F1, F2 or F3", options.finger));
  if (options.press && !options.yes)
    return bad("--press", "the finger presses with all that its motor may give: keep clear, and say --yes");
  if (options.pause_s && !(*options.pause_s >= 0.0 && *options.pause_s <= 600.0))
    return bad("--pause", "expected 0 to 600 s");
  FingerCalibration what{*finger, options.torques_nm, options.press, today()};
  if (what.torques_nm.empty()) what.torques_nm = {0.2, 0.4, 0.6};
  hal::HandCalibration file;
  if (options.out && std::filesystem::exists(*options.out)) {
    auto kept = hal::load_hand_calibration(*options.out);
    if (!kept) return report_error(kWhere, kept.error());
    file = std::move(*kept);
  }
  const hal::SteadyClock clock;
  auto bus = make_bus(config, clock);
  if (!bus) return report_error("hal hand", bus.error());
  const InterruptGuard signals;
  const auto result = calibrate_finger(*bus->bus, clock, config, what, [&](const std::string& words) {
    std::fprintf(
        stderr, "%s%s\n", words.c_str(),
        options.pause_s ? fmt::format(" ({:.0f} s)", *options.pause_s).c_str() : "; then press Enter");
    return wait_for_person(options.pause_s);
  });
  if (!result) {
    if (InterruptGuard::asked()) return kInterrupted;
    if (result.error().where == "--torques" || result.error().where == "stdin")
      return report_error(kWhere, result.error());
    const bool no_line = result.error().code == hal::ErrorCode::BadInput;
    report_failure(
        "hand", options.verb, result.error().text(),
        fmt::format("next: {}\n", no_line ? "check weights and lever, and that nothing else touches "
                                            "the finger; then measure again"
                                          : hand_advice(result.error().code, config.can)));
    return kDeviceFailed;
  }
  if (options.out) {
    file.take(result->scale);
    const std::string text = hal::text_of(file);
    if (auto done = picture::write_file(*options.out,
                                        {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
        !done)
      return report_error(kWhere, done.error());
  }
  std::fputs((common.json ? calibration_document(*finger, *result) + "\n"
                          : calibration_text(*finger, *result) +
                                (options.out ? fmt::format("{}: calibration_file: of a robot file\n",
                                                           options.out->string())
                                             : std::string()))
                 .c_str(),
             stdout);
  return kDone;
}

}  // namespace colift::tools
