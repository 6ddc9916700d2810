#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "hal/drivers/capture_link/capture_words.hpp"
#include "hal/types/result.hpp"
#include "hal/types/time.hpp"

namespace colift::hal::capture {

/// What is started: program and arguments, and what its environment has beyond ours ("KEY=VALUE").
struct CaptureCall {
  std::string program;
  std::vector<std::string> arguments;
  std::vector<std::string> environment;
};

/// A capture process of ours. It is in a process group of its own, so that Ctrl-C does not reach it, under
/// ordinary scheduling, and has no file of ours but its ring and two pipes. It ends by itself when we do.
class CaptureProcess {
 public:
  /// The ring's memory becomes its file 3. Errors: BadConfig (no such program).
  [[nodiscard]] static Result<CaptureProcess> start(const CaptureCall& call, int ring_fd);
  CaptureProcess(CaptureProcess&& other) noexcept;
  CaptureProcess& operator=(CaptureProcess&& other) noexcept;
  /// Asks it to end, and kills it if it does not within 0.3 s; waits for 0.5 s at most.
  ~CaptureProcess();

  /// Takes what it has said since.
  void listen(CaptureNews& news);
  /// Waits until it says something or is gone, no longer than `timeout`.
  void wait(Duration timeout) const;
  /// Whether it is still there. Reaps it when it is not.
  [[nodiscard]] bool exists();
  /// How it ended: "status 1", "signal 11 (Segmentation fault)".
  [[nodiscard]] const std::string& ended() const { return ended_; }
  /// One line; lost when it does not listen.
  void send_line(const std::string& line) const;
  void kill() const;
  [[nodiscard]] pid_t pid() const { return pid_; }
  /// Given up: a process that the kernel cannot end. Nobody waits for it any more.
  void abandon() { pid_ = -1; }

 private:
  CaptureProcess(pid_t pid, int to, int from) : pid_(pid), to_(to), from_(from) {}
  void close_pipes();
  pid_t pid_ = -1;
  int to_ = -1, from_ = -1;
  std::string ended_;
  CaptureLines lines_;
};

}  // namespace colift::hal::capture
