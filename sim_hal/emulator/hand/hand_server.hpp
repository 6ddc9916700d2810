#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "sim_hal/emulator/hand/hand_emulator.hpp"

namespace colift::sim_hal {

/// How well the machine kept the hand's time.
struct HandServerTiming {
  std::uint64_t late = 0;  ///< Times that more than 20 ms were lost; the hand's time stood still meanwhile.
  double worst_late_ms = 0.0, wall_s = 0.0;
};

/// An emulated hand in real time on a bus, in a thread of its own: HandGateway for TCP clients, or any other
/// CanBus, as that of hal/os/make_can_bus.hpp for a vcan or a real interface. A gateway brings about bus-off
/// and a lost interface; on another bus the pucks are only deaf and dumb then.
class HandServer {
 public:
  struct Event {
    double t_s = 0.0;
    std::string text;
  };

  /// Plant and bus are used by the server's thread alone between start() and stop().
  HandServer(HandEmulatorConfig config, std::unique_ptr<HandPlant> plant, std::unique_ptr<hal::CanBus> bus);
  ~HandServer();
  HandServer(const HandServer&) = delete;
  HandServer& operator=(const HandServer&) = delete;

  /// Opens the bus and switches the hand on. Errors: those of the bus, BadConfig, NotReady (runs).
  [[nodiscard]] hal::Result<> start();
  /// Any number of times.
  void stop();

  /// A fault from now on; its `at_s` counts from this call. Any thread.
  void inject(HandFault fault);
  [[nodiscard]] HandEmulatorReport report() const;
  [[nodiscard]] HandServerTiming timing() const;
  /// What happened since the last call. Any thread.
  [[nodiscard]] std::vector<Event> take_events();
  [[nodiscard]] double elapsed_s() const;

 private:
  void run();
  void publish();

  HandEmulatorConfig config_;
  std::unique_ptr<HandPlant> plant_;
  std::unique_ptr<hal::CanBus> bus_;
  std::unique_ptr<HandEmulator> hand_;
  hal::SteadyClock wall_;
  std::thread thread_;
  std::atomic<bool> stop_{false};
  HandServerTiming timing_;

  mutable std::mutex mutex_;
  std::vector<Event> events_;
  std::vector<HandFault> wished_;
  HandEmulatorReport published_;
  HandServerTiming published_timing_;
  double published_s_ = 0.0;
};

}  // namespace colift::sim_hal
