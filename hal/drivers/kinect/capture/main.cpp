// colift-kinect: reads one Kinect v1 through libfreenect and puts its frames into shared memory. Started by
// CoLift's camera driver, which ends it and starts it anew whenever it hangs, crashes or loses the device.

#include <sys/resource.h>
#include <sys/syscall.h>

#include <charconv>
#include <csignal>
#include <cstdio>
#include <mutex>
#include <thread>

#include "hal/drivers/kinect/capture/device.hpp"
#include "hal/drivers/kinect/capture/words_out.hpp"

namespace {

using colift::capture::Device;
using colift::capture::End;
using colift::capture::say;
using colift::capture::say_end;
using colift::hal::kinect::CaptureEnd;
using colift::hal::kinect::CaptureState;

/// Lines from the controller. Its thread also ends the process when the controller is gone, even while the
/// library hangs.
class Commands {
 public:
  void listen() {
    std::thread([this] {
      char bytes[256];
      std::string rest;
      for (;;) {
        const ssize_t n = ::read(STDIN_FILENO, bytes, sizeof bytes);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) {
          ask_to_quit();
          std::this_thread::sleep_for(std::chrono::milliseconds(500));  // for an orderly end
          std::_Exit(0);
        }
        for (ssize_t i = 0; i < n; ++i) {
          if (bytes[i] != '\n') {
            if (rest.size() < 100) rest += bytes[i];
            continue;
          }
          const std::lock_guard lock(mutex_);
          if (lines_.size() < 20) lines_.push_back(rest);
          rest.clear();
        }
      }
    }).detach();
  }

  std::vector<std::string> take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(lines_, {});
  }

 private:
  void ask_to_quit() {
    const std::lock_guard lock(mutex_);
    lines_.emplace_back("quit");
  }
  std::mutex mutex_;
  std::vector<std::string> lines_;
};

template <class Number>
std::optional<Number> number_after(const std::string& line, std::string_view name) {
  if (!line.starts_with(name)) return std::nullopt;
  Number value{};
  const char* const last = line.data() + line.size();
  const auto [end, error] = std::from_chars(line.data() + name.size(), last, value);
  if (error != std::errc{} || end != last) return std::nullopt;
  return value;
}

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

/// Little is lost when the machine gives nothing: the library buffers 32 ms.
void ask_for_priority() {
  sched_param request{};
  request.sched_priority = 10;  // below the arm's cycle
  if (::sched_setscheduler(0, SCHED_RR | SCHED_RESET_ON_FORK, &request) != 0)
    (void)::setpriority(PRIO_PROCESS, 0, -10);
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
  std::signal(SIGPIPE, SIG_IGN);
  (void)::setvbuf(stdout, nullptr, _IOLBF, 0);
  (void)::fcntl(STDOUT_FILENO, F_SETFL, ::fcntl(STDOUT_FILENO, F_GETFL) | O_NONBLOCK);
  auto ring = colift::hal::kinect::FrameRingWriter::map(ring_fd);
  if (!ring) {
    say_end(CaptureEnd::BadCall, ring.error().text());
    return 2;
  }
  ask_for_priority();
  Commands commands;
  commands.listen();

  Device device(*ring, serial, motor);
  std::optional<End> end = device.open();
  bool quit = false;
  while (!end && !quit) {
    ring->beat();
    end = device.turn();
    for (const std::string& line : commands.take()) quit = quit || !obey(line, device);
  }
  // the words first: closing a device that is gone may take for ever
  if (end) say_end(end->why, end->reason);
  ring->set_state(CaptureState::Ended);
  device.close();
  return end ? 1 : 0;
}
