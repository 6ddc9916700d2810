#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>

#include "hal/types/result.hpp"

namespace colift::telemetry {

// How another process asks a run for its last seconds: by a file in a folder that only its user can write,
// $XDG_RUNTIME_DIR/colift or /tmp/colift-UID. No signal: none is ever sent to a process that does not expect
// it.

/// Announces this process as a run that can be asked, and answers.
class FlightPost {
 public:
  /// Errors: NotReady when the folder cannot be made, or belongs to somebody else. A run goes on without.
  [[nodiscard]] static hal::Result<FlightPost> open();
  ~FlightPost();
  FlightPost(FlightPost&& other) noexcept;
  FlightPost& operator=(FlightPost&&) = delete;

  /// The file that was asked for, once; asked again, the request is answered: call it when the file is
  /// written.
  [[nodiscard]] std::optional<std::filesystem::path> asked();

 private:
  explicit FlightPost(std::filesystem::path folder);
  std::filesystem::path announcement_, request_;
  int lock_ = -1;  ///< Of the announcement.
  bool answering_ = false;
};

/// Asks the newest run of this user, or the given one, to write its last seconds to `file`, and waits until
/// it has. Errors: NotFound (no such run), Timeout (it did not answer), BadInput (it could not write).
[[nodiscard]] hal::Result<> ask_for_flight(const std::filesystem::path& file, std::optional<pid_t> run,
                                           double timeout_s);

/// Where last seconds go when nobody said where: $XDG_STATE_HOME/colift or ~/.local/state/colift.
[[nodiscard]] std::filesystem::path flight_folder();

}  // namespace colift::telemetry
