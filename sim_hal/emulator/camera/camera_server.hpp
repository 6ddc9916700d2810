#pragma once

#include <atomic>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "sim_hal/emulator/camera/camera_faults.hpp"
#include "sim_hal/emulator/camera/camera_source.hpp"
#include "sim_hal/emulator/camera/camera_wire.hpp"

namespace colift::sim_hal {

struct CameraServerConfig {
  std::string address;  ///< "@NAME", no file; empty: a name of its own.
  std::string serial = "EMULATED0001";
  double rate_hz = 30.0;
  std::uint32_t first_ticks = 0xF0000000;  ///< Of the device's counter: wraps 4.5 s later.
  std::vector<CameraFault> faults;
  std::uint64_t seed = 1;
};

struct CameraServerReport {
  std::uint64_t exposed = 0;    ///< Frames that were due while somebody wanted them.
  std::uint64_t sent = 0;       ///< Handed over whole.
  std::uint64_t not_taken = 0;  ///< The client was not ready for them: lost, as on USB.
  std::uint64_t infrared = 0;
  std::uint64_t clients = 0;  ///< Connections so far.
  std::uint64_t refused = 0;  ///< While there was no device.
  double worst_render_ms = 0.0;
  double tilt_deg = 0.0;  ///< Where the motor was sent.
  int brightness = 0;     ///< Of the infrared image, as it was asked for; 0: never.
};

/// An emulated Kinect in real time, in a thread of its own, for the library in freenect/. One client at a
/// time, as on USB.
class CameraServer {
 public:
  struct Event {
    double t_s = 0.0;
    std::string text;
  };

  CameraServer(CameraServerConfig config, std::unique_ptr<CameraSource> eye);
  ~CameraServer();
  CameraServer(const CameraServer&) = delete;
  CameraServer& operator=(const CameraServer&) = delete;

  /// Errors: BadConfig (the address is taken).
  [[nodiscard]] hal::Result<> start();
  void stop();
  /// What a client puts behind "emulated:".
  [[nodiscard]] const std::string& address() const { return config_.address; }

  /// A fault from now on; its `at_s` counts from this call. Any thread.
  void inject(CameraFault fault);
  [[nodiscard]] CameraServerReport report() const;
  /// What happened since the last call. Any thread.
  [[nodiscard]] std::vector<Event> take_events();
  [[nodiscard]] double elapsed_s() const;

 private:
  struct Waiting {
    hal::Timestamp due{0};
    std::vector<std::uint8_t> bytes;
  };

  void run();
  void accept_client();
  void drop_client(const std::string& why);
  void hear();
  void frame_due(hal::Timestamp now);
  void spoil(CameraExposure& e);
  void send_exposure(const CameraExposure& e, hal::Timestamp now);
  void put(CameraMessage what, std::uint32_t value, const void* bytes, std::size_t count, hal::Timestamp due);
  void flush(hal::Timestamp now);
  void follow_faults();
  [[nodiscard]] const CameraFault* now_active(CameraFault::Kind kind) const;
  void report(std::string text);
  [[nodiscard]] std::uint32_t ticks_at(hal::Timestamp at) const;

  CameraServerConfig config_;
  std::unique_ptr<CameraSource> eye_;
  hal::SteadyClock clock_;
  std::thread thread_;
  std::atomic<bool> stop_{false};
  int listener_ = -1, client_ = -1;
  std::uint32_t wants_ = 0;
  hal::Timestamp began_{0}, next_{0};
  std::optional<hal::Timestamp> first_at_;
  double t_s_ = 0.0;
  std::uint64_t frame_ = 0;
  std::vector<char> was_active_;
  std::deque<Waiting> queue_;
  std::size_t written_ = 0;  ///< Of the queue's first.
  std::vector<std::uint8_t> heard_;
  std::vector<std::uint16_t> last_codes_, frozen_;
  std::optional<CameraExposure> held_back_;
  std::optional<std::uint32_t> same_ticks_;
  double turned_deg_ = 0.0, clock_set_s_ = 0.0;

  mutable std::mutex mutex_;
  std::vector<CameraFault> wished_;
  std::vector<Event> events_;
  CameraServerReport report_;
  double published_s_ = 0.0;
};

}  // namespace colift::sim_hal
