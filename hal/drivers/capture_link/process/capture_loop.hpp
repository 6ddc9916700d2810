#pragma once

#include <string>

#include "hal/drivers/capture_link/process/commands.hpp"
#include "hal/drivers/capture_link/process/words_out.hpp"

namespace colift::capture {

/// A capture process from its device's start to its end: turns, beats and the controller's lines. `device`
/// has open(), turn() (both say why it ended, or nothing) and close(); `obey(line, device)` is false for
/// "quit". The exit code of the process: 0 asked to end, 1 the device ended it.
template <class Device, class Obey>
int run_capture(hal::capture::FrameRingWriter& ring, Device& device, Obey obey) {
  static Commands& commands = *new Commands;  // its thread reads until the process is gone
  commands.listen();
  auto end = device.open();
  bool quit = false;
  while (!end && !quit) {
    ring.beat();
    end = device.turn();
    for (const std::string& line : commands.take()) quit = quit || !obey(line, device);
  }
  // the words first: closing a device that is gone may take for ever
  if (end) say_end(end->why, end->reason);
  ring.set_state(hal::capture::CaptureState::Ended);
  device.close();
  return end ? 1 : 0;
}

}  // namespace colift::capture
