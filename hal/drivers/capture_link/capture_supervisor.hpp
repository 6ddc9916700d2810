#pragma once

#include <optional>
#include <string>

#include "hal/depth_camera.hpp"
#include "hal/drivers/capture_link/capture_monitor.hpp"
#include "hal/drivers/capture_link/capture_process.hpp"
#include "hal/drivers/capture_link/frame_ring.hpp"

namespace colift::hal::capture {

/// The life of a camera whose library runs in a capture process: started, watched, ended and started anew. A
/// camera derives from it and turns raw frames into frames; its calls of hal::DepthCamera end here. One
/// thread.
class CaptureSupervisor {
 public:
  /// `name` begins the place of an error, "kinect". The clock outlives it; it is that of the time stamps.
  CaptureSupervisor(std::string name, const CaptureTimes& times, const RingShape& shape, const Clock& clock);
  CaptureSupervisor(const CaptureSupervisor&) = delete;
  CaptureSupervisor& operator=(const CaptureSupervisor&) = delete;
  virtual ~CaptureSupervisor() = default;

  /// As hal::DepthCamera has them; `call` is set before. Only the first configure() waits, up to `open_s`.
  [[nodiscard]] Result<> configure();
  [[nodiscard]] Result<> activate();
  void deactivate() { active_ = false; }
  [[nodiscard]] DeviceHealth health() const;
  [[nodiscard]] Result<DepthFrame> next_frame(std::chrono::milliseconds timeout);

  /// Everything that is due: the process's words, its deadlines.
  void look_after();
  /// Until the process says or shows something, at most 20 ms.
  void wait(Duration timeout) const;

  [[nodiscard]] bool opened() const { return opened_; }
  [[nodiscard]] bool active() const { return active_; }
  [[nodiscard]] bool running() const { return watch_.running(); }
  [[nodiscard]] const CaptureMonitor& watch() const { return watch_; }
  [[nodiscard]] const CaptureNews& news() const { return news_; }
  [[nodiscard]] const std::string& error() const { return error_; }  ///< Empty: it streams.
  [[nodiscard]] std::uint64_t broken() const { return broken_; }     ///< Not what a frame looks like.
  [[nodiscard]] pid_t pid() const { return process_ ? process_->pid() : -1; }
  [[nodiscard]] std::uint64_t missed() const { return ring_ ? ring_->missed(Stream::Depth) : 0; }
  /// To the process, one line; lost when there is none.
  void send_line(const std::string& line) const;
  [[nodiscard]] std::string words_of_loss() const;

 protected:
  /// A new depth frame, if one is there that is good.
  [[nodiscard]] virtual std::optional<DepthFrame> take() = 0;
  /// A process was started: what belonged to the one before is forgotten.
  virtual void started() {}
  /// The process may have said something.
  virtual void heard() {}
  /// Whether the source ends by itself and does not come back, as a recording does.
  [[nodiscard]] virtual bool is_recording() const { return false; }

  /// The newest raw frame; false: none, or not what a frame looks like, which is counted.
  [[nodiscard]] bool read(Stream stream, RawFrame& into);
  void reject(std::string why);
  /// Takes what the process has said by now, which is before any frame that is in the ring by now.
  void listen();
  /// Of a raw frame, on the robot's clock: the process's word, kept within reason.
  [[nodiscard]] Timestamp arrival(const FrameStamp& stamp) const;

  const Clock& clock_;
  CaptureCall call_;

 private:
  void start();
  [[nodiscard]] Result<> first_frame();
  [[nodiscard]] DepthFrame hand_out(DepthFrame frame);
  void note_loss(const std::string& why);
  [[nodiscard]] bool lost() const;
  [[nodiscard]] std::string words_of_end() const;
  [[nodiscard]] Error wrong(ErrorCode code, const char* where, std::string what) const;

  std::string name_;
  CaptureTimes times_;
  RingShape shape_;
  SteadyClock machine_;  // that of the capture process
  CaptureMonitor watch_;
  std::optional<FrameRing> ring_;
  std::optional<CaptureProcess> process_;
  CaptureNews news_;
  std::string error_, last_error_;
  std::uint64_t accepted_ = 0, rejected_ = 0, broken_ = 0;
  Timestamp frame_at_{0};  ///< When the last depth frame was handed out.
  bool opened_ = false, active_ = false;
};

}  // namespace colift::hal::capture
