#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "sim_hal/emulator/krc/krc_emulator.hpp"

namespace colift::sim_hal {

struct KrcServerConfig {
  KrcConfig krc;
  std::uint16_t from_port = 0;  ///< Of the controller; 0: any.
  double speed = 1.0;  ///< Controller seconds in a second; 0: a cycle for each answer, as fast as they come.
  bool realtime = true;  ///< Asks for SCHED_FIFO; goes on without when it is not granted.
  int cpu = -1;  ///< That of a client on the same machine: a CPU that stands still stops both, and no answer
                 ///< is missed for it; -1: any.
};

/// How well the machine kept the controller's time.
struct KrcServerTiming {
  std::uint64_t cycles = 0;
  std::uint64_t late = 0;  ///< Cycles that began more than a quarter of a cycle late; the client loses
                           ///< nothing by them, the controller's time stands still meanwhile.
  double worst_late_ms = 0.0, plant_ms = 0.0, worst_plant_ms = 0.0;  ///< plant_ms: mean.
  double wall_s = 0.0;
  bool realtime = false;  ///< SCHED_FIFO was granted.
  /// Cycles whose answer was missed while the client commanded: when the measurement went out, and when it
  /// was too late. By CLOCK_MONOTONIC (s), so that they can be laid beside what others saw of this machine.
  struct Missed {
    double sent_s = 0.0, until_s = 0.0;
  };
  std::vector<Missed> missed;  ///< Of those in command; the first 1000.
};

/// An emulated KRC in real time on a UDP port, in a thread of its own.
class KrcServer {
 public:
  struct Event {
    double t_s = 0.0;
    std::string text;
  };

  /// The plant is used by the server's thread alone between start() and stop().
  KrcServer(KrcServerConfig config, const hal::ArmDynamics& dynamics, std::unique_ptr<KrcPlant> plant);
  ~KrcServer();
  KrcServer(const KrcServer&) = delete;
  KrcServer& operator=(const KrcServer&) = delete;

  /// Opens the port and starts the controller. Errors: LinkLost (port in use), BadConfig, NotReady (runs).
  [[nodiscard]] hal::Result<> start();
  /// Ends it at its next cycle; any number of times.
  void stop();

  /// A fault from now on; its `at_s` counts from this call. Any thread.
  void inject(KrcFault fault);
  /// The program came to its end, or the port broke.
  [[nodiscard]] bool ended() const { return ended_; }
  [[nodiscard]] KrcReport report() const;
  [[nodiscard]] KrcServerTiming timing() const;
  /// What happened since the last call. Any thread.
  [[nodiscard]] std::vector<Event> take_events();

 private:
  void run();
  void take_requests();
  void note_missed(hal::Timestamp sent, std::uint64_t& before);
  void wait_for_answers(hal::Timestamp sent, hal::Timestamp until);
  void publish();

  KrcServerConfig config_;
  hal::ArmDynamics dynamics_;
  std::unique_ptr<KrcPlant> plant_;
  std::unique_ptr<hal::DatagramLink> link_;
  std::unique_ptr<KrcEmulator> krc_;
  hal::SteadyClock wall_;
  std::thread thread_;
  std::atomic<bool> stop_{false}, ended_{false};
  hal::Timestamp cycle_at_{0};    // emulated, of the last cycle
  hal::Timestamp cycle_wall_{0};  // and when that was
  KrcServerTiming timing_;

  mutable std::mutex mutex_;
  std::vector<Event> events_;
  std::vector<KrcFault> wished_;
  std::atomic<bool> requests_{false};
  KrcReport published_;
  KrcServerTiming published_timing_;
};

}  // namespace colift::sim_hal
