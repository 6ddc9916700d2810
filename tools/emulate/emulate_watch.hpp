#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <thread>

#include "tools/cli/session.hpp"
#include "tools/emulate/emulate.hpp"

namespace colift::tools {

/// Prints what happens at a running emulator until it is over, stops it, and says why it was. `ended` names a
/// reason of the device's own, if there is one; `elapsed_s` is the device's time.
template <class Server, class Ended, class Elapsed>
[[nodiscard]] std::string watch_emulator(Server& server, const EmulateOptions& options,
                                         const EmulateLines& lines, Ended&& ended, Elapsed&& elapsed_s) {
  const auto print = [&] {
    for (const auto& e : server.take_events()) lines.event(e.t_s, e.text);
  };
  for (;;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    print();
    std::optional<std::string> because = ended();
    if (!because && InterruptGuard::asked()) because = "interrupted";
    if (!because && options.for_s && elapsed_s() >= *options.for_s) because = "the time is over";
    if (!because) continue;
    server.stop();
    print();
    return *because;
  }
}

}  // namespace colift::tools
