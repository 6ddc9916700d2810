#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hal/types/result.hpp"
#include "tools/cli/options.hpp"

namespace colift::tools {

/// What every emulated device takes.
struct EmulateOptions {
  std::optional<std::filesystem::path> scenario;  ///< Unset: the built-in table.
  std::string plant = "mujoco";                   ///< mujoco | light
  std::optional<double> for_s;                    ///< Unset: until it is interrupted or the client closes.
  std::vector<std::string> faults;                ///< "T:KIND[:DURATION]"
  double speed = 1.0;
  std::uint64_t seed = 1;
};

struct EmulateKrcOptions {
  EmulateOptions common;
  std::string to = "127.0.0.1:49938";
  int from_port = 0;
  double cycle_ms = 2.0;
  std::string script = "colift";
  std::optional<int> strategy;  ///< 10, 20 or 30; unset: the program's own.
  double linger_s = 1.5;
  double session_s = 10.0;  ///< How long the vendor's program commands.
  std::optional<double> restart_s;
  double idle_s = 20.0;  ///< Until idle brakes close; 0: never.
  bool brakes_need_motion = false;
  bool strict = false;
  bool friction = false;  ///< Of the light plant.
};

/// The far end of the arm's wire. 0 the client broke no rule, 1 it did, 2 bad options, 3 the port is not
/// to be had.
[[nodiscard]] int cmd_emulate_krc(const CommonOptions& common, const EmulateKrcOptions& options);

/// Lines of a running emulator: "ready: ..." and events. To stdout, or to stderr when stdout is for JSON.
class EmulateLines {
 public:
  explicit EmulateLines(const CommonOptions& common) : common_(common) {}
  void ready(const std::string& what) const;
  void event(double t_s, const std::string& what) const;  ///< Not with --quiet.
  /// The end: a summary, or a document with --json; to stdout.
  void result(const std::string& what) const;

 private:
  const CommonOptions& common_;
};

/// A command line option that cannot be. BadInput.
[[nodiscard]] tl::unexpected<hal::Error> bad_option(const char* option, std::string reason);
/// Errors: BadInput (a time that is not finite, or below `least`).
[[nodiscard]] hal::Result<> check_seconds(const char* option, const std::optional<double>& value_s,
                                          double least = 0.0);

/// Running emulators, as the loop that waits for their end sees them.
struct EmulatorLoop {
  std::function<void()> print;        ///< What has happened since the last call, and whatever is due.
  std::function<double()> elapsed_s;  ///< The device's time.
  std::function<void()> stop;
  std::function<std::optional<std::string>()> ended = {};  ///< A reason of the device's own, if there is one.
};
/// Watches until the emulators are over, stops them, and says why it was.
[[nodiscard]] std::string run_emulator(const EmulateOptions& options, const EmulatorLoop& watch);

/// The same for one server, whose events are printed as they are.
template <class Server>
[[nodiscard]] std::string run_server(Server& server, const EmulateOptions& options, const EmulateLines& lines,
                                     std::function<double()> elapsed_s,
                                     std::function<std::optional<std::string>()> ended = {}) {
  return run_emulator(options, {[&] {
                                  for (const auto& e : server.take_events()) lines.event(e.t_s, e.text);
                                },
                                std::move(elapsed_s), [&] { server.stop(); }, std::move(ended)});
}

}  // namespace colift::tools
