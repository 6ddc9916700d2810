#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim_hal/emulator/hand/hand_server.hpp"
#include "tools/emulate/emulate.hpp"

namespace colift::tools {

struct EmulateHandOptions {
  EmulateOptions common;
  /// "socketcand:ADDRESS:PORT/BUS": a gateway that is opened here; "socketcan:IF": a bus of this machine.
  std::string bus = "socketcand:127.0.0.1:29536/can0";
  std::optional<double> width_m;  ///< Of an object between the fingers of the light plant.
  bool awake = false;             ///< The pucks were woken before and know their zero.
  int firmware = 200;
  std::vector<double> gauges;  ///< Of F1 to F3: true torque over that of the maker's curve; empty: 1.
  int group = 5;               ///< Third group of every puck; 8 in hands of 2010.
};

/// The document colift.emulate/1 of a hand.
[[nodiscard]] std::string emulate_hand_json(const EmulateHandOptions& options,
                                            const sim_hal::HandEmulatorReport& report,
                                            const sim_hal::HandServerTiming& timing, double duration_s,
                                            const std::string& reason);

/// The far end of the hand's bus. 0 the client broke no rule, 1 it did, 2 bad options, 3 the bus is not to be
/// had.
[[nodiscard]] int cmd_emulate_hand(const CommonOptions& common, const EmulateHandOptions& options);

}  // namespace colift::tools
