#include "tools/emulate/emulate.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <thread>
#include <utility>

#include "tools/cli/interrupt.hpp"

namespace colift::tools {
namespace {

void line(const CommonOptions& common, const std::string& text) {
  std::FILE* out = common.json ? stderr : stdout;
  std::fputs((text + "\n").c_str(), out);
  std::fflush(out);
}

}  // namespace

void EmulateLines::ready(const std::string& what) const {
  line(common_, fmt::format("ready: {}", what));
}

void EmulateLines::event(double t_s, const std::string& what) const {
  if (!common_.quiet) line(common_, fmt::format("t={:.3f} {}", t_s, what));
}

void EmulateLines::result(const std::string& what) const {
  std::fputs((what + "\n").c_str(), stdout);
  std::fflush(stdout);
}

tl::unexpected<hal::Error> bad_option(const char* option, std::string reason) {
  return hal::failure(hal::ErrorCode::BadInput, option, std::move(reason));
}

hal::Result<> check_seconds(const char* option, const std::optional<double>& value_s, double least) {
  if (!value_s || (*value_s >= least && std::isfinite(*value_s))) return {};
  return bad_option(option, fmt::format("{} is no time; expected seconds from {:g}", *value_s, least));
}

std::string run_emulator(const EmulateOptions& options, const EmulatorLoop& watch) {
  for (;;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    watch.print();
    std::optional<std::string> reason = watch.ended ? watch.ended() : std::nullopt;
    if (!reason && InterruptGuard::asked()) reason = "interrupted";
    if (!reason && options.for_s && watch.elapsed_s() >= *options.for_s) reason = "the time is over";
    if (!reason) continue;
    watch.stop();
    watch.print();
    return *reason;
  }
}

}  // namespace colift::tools
