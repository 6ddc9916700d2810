// colift-kinect: reads one Kinect v1 through libfreenect and puts its frames into shared memory. Started by
// CoLift's camera driver, which ends it and starts it anew whenever it hangs, crashes or loses the device.

#include <cstdio>

#include "hal/drivers/capture_link/process/capture_loop.hpp"
#include "hal/drivers/kinect/capture/device.hpp"

namespace {

using colift::capture::Device;
using colift::capture::number_after;
using colift::capture::say;
using colift::capture::say_end;
using colift::hal::capture::CaptureEnd;

/// False: quit.
bool obey(const std::string& line, Device& device) {
  if (line == "quit") return false;
  std::optional<std::string> refused;
  if (line == "infrared on" || line == "infrared off")
    refused = device.want_infrared(line == "infrared on");
  else if (const auto degrees = number_after<double>(line, "tilt "))
    refused = device.tilt(*degrees);
  else if (const auto brightness = number_after<int>(line, "brightness "))
    refused = device.set_brightness(*brightness);
  else
    refused = "not a request: " + line;
  if (refused) say_end(CaptureEnd::Request, *refused);
  return true;
}

/// For the doctor: whether the library is there, starts, and has what is needed. Opens no device.
int probe() {
  freenect_context* context = nullptr;
  if (freenect_init(&context, nullptr) < 0) {
    say("note libusb does not start: is /dev/bus/usb there?");
    return 1;
  }
  const bool depth = colift::capture::depth_mode().has_value();
  const bool infrared = colift::capture::infrared_mode().has_value();
  (void)freenect_shutdown(context);
  say(std::string("note ") + (depth ? "11-bit depth" : "no 11-bit depth") +
      (infrared ? ", infrared" : ", no infrared"));
  return depth ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  int ring_fd = -1;
  std::string serial;
  bool motor = false, asked = false;
  for (int i = 1; i < argc; ++i) {
    const std::string a = argv[i];
    if (a == "--motor")
      motor = true;
    else if (a == "--probe")
      asked = true;
    else if (a == "--ring" && i + 1 < argc)
      ring_fd = number_after<int>(argv[++i], "").value_or(-1);
    else if (a == "--serial" && i + 1 < argc)
      serial = argv[++i];
    else
      ring_fd = -2;
  }
  if (asked) return probe();
  if (ring_fd < 0) {
    std::fputs("colift-kinect is started by colift's camera driver: see \"colift hal camera watch\"\n",
               stderr);
    return 2;
  }
  auto ring = colift::capture::begin_capture(ring_fd);
  if (!ring) return 2;
  Device device(*ring, serial, motor);
  return colift::capture::run_capture(*ring, device, obey);
}
