// colift-openni2: reads one depth camera through OpenNI2 and puts its frames into shared memory. Started by
// CoLift's camera driver, which ends it and starts it anew whenever it hangs, crashes or loses the device.

#include <cstdio>

#include "hal/drivers/capture_link/process/capture_loop.hpp"
#include "hal/drivers/openni2_camera/capture/device.hpp"

namespace {

using colift::capture::Device;
using colift::capture::DeviceRequest;
using colift::capture::number_after;
using colift::capture::say;
using colift::capture::say_end;
using colift::hal::capture::CaptureEnd;

/// For the doctor: whether the library is there, starts, and which devices it finds. Opens none.
int probe() {
  if (oniInitialize(ONI_API_VERSION) != ONI_STATUS_OK) {
    say(std::string("note OpenNI2 does not start: ") + oniGetExtendedError());
    return 1;
  }
  OniDeviceInfo* all = nullptr;
  int count = 0;
  std::string found;
  if (oniGetDeviceList(&all, &count) == ONI_STATUS_OK) {
    for (int i = 0; i < count; ++i) found += std::string(i == 0 ? ": " : ", ") + all[i].uri;
    (void)oniReleaseDeviceList(all);
  }
  const OniVersion v = oniGetVersion();
  say("note version " + std::to_string(v.major) + "." + std::to_string(v.minor) + ", " +
      std::to_string(count) + (count == 1 ? " device" : " devices") + found);
  oniShutdown();
  return 0;
}

/// False: quit.
bool obey(const std::string& line, Device& device) {
  if (line == "quit") return false;
  if (line == "finish") {
    device.finish_recording();
    say("finished");
  } else {
    say_end(CaptureEnd::Request, "not a request: " + line);
  }
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  int ring_fd = -1;
  bool asked = false;
  DeviceRequest request;
  for (int i = 1; i < argc; ++i) {
    const std::string a = argv[i];
    const std::string value = i + 1 < argc ? argv[i + 1] : "";
    const int number = number_after<int>(value, "").value_or(-1);
    if (a == "--probe") {
      asked = true;
      continue;
    }
    ++i;
    if (a == "--ring")
      ring_fd = number;
    else if (a == "--device")
      request.uri = value;
    else if (a == "--file")
      request.file = value;
    else if (a == "--record")
      request.record = value;
    else if (a == "--width")
      request.mode.width = number;
    else if (a == "--height")
      request.mode.height = number;
    else if (a == "--rate")
      request.mode.rate_hz = number;
    else if (a == "--unit-um")
      request.mode.unit_um = static_cast<std::uint32_t>(number);
    else
      ring_fd = -2;
  }
  if (asked) return probe();
  if (ring_fd < 0) {
    std::fputs("colift-openni2 is started by colift's camera driver: see \"colift hal camera watch\"\n",
               stderr);
    return 2;
  }
  auto ring = colift::capture::begin_capture(ring_fd);
  if (!ring) return 2;
  Device device(*ring, std::move(request));
  return colift::capture::run_capture(*ring, device, obey);
}
