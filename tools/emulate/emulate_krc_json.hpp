#pragma once

#include <string>

#include "sim_hal/emulator/krc/krc_server.hpp"
#include "tools/emulate/emulate.hpp"

namespace colift::tools {

/// The document colift.emulate/1 of a KRC.
[[nodiscard]] std::string emulate_krc_json(const EmulateKrcOptions& options, const sim_hal::KrcReport& report,
                                           const sim_hal::KrcServerTiming& timing, const std::string& reason);

}  // namespace colift::tools
