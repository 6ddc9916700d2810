#pragma once

#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "control/task/machine/task_machine.hpp"
#include "hal/device.hpp"
#include "hal/types/time.hpp"
#include "tools/run/run_view.hpp"

namespace colift::tools {

/// One device, as the operator sees it.
struct DeviceStatus {
  std::string name;  ///< "arm", "hand", "camera".
  hal::DeviceHealth health;
  double rate_hz = 0.0;  ///< Of what arrives; 0: worked out from what was accepted over a second.
};

/// What is going on. Filled by the run at any rate; what is unknown stays unset.
struct RunStatus {
  double t_s = 0.0;  ///< Since the start, on the run's clock.
  control::Task state = control::Task::Observe;
  double in_state_s = 0.0;
  std::string reason;  ///< Why it came into this state.
  std::string now;     ///< What it is doing in particular, where there is more to say than waits_for(state).
  std::string press;   ///< How a person makes the run continue that waits for it; empty: it does not.
  std::optional<double> done;  ///< Part of the state's work that is done, 0 to 1.
  std::vector<DeviceStatus> devices;
  std::optional<hal::Vec3> partner;  ///< Where he is seen to hold the object (W).
  std::string partner_note;          ///< "a hand moves near the object", "let go 0.3 s ago".
  std::optional<int> candidate;      ///< Its id.
  std::optional<double> share_predicted;
  std::string decision_note;
  std::optional<double> load_n, share, height_m, tilt_rad, slip_m;
  std::vector<std::string> faults;  ///< Newest last; the last two are shown.
};

/// How it is shown.
struct ProgressStyle {
  bool live = false;    ///< One screen that renews itself; else a line for each change.
  bool silent = false;  ///< Nothing at all (--quiet).
  bool colour = false;
  bool unicode = false;
  int columns = 80;
};
/// Live on a terminal that can, plain lines elsewhere and with --json; honours NO_COLOR and TERM=dumb.
[[nodiscard]] ProgressStyle progress_style(std::FILE* out, bool json, bool quiet);

/// The screen's lines, each at most `columns` wide without its colour codes.
[[nodiscard]] std::vector<std::string> progress_screen(const RunStatus& status, const RunSetting& setting,
                                                       const ProgressStyle& style);

/// Shows a run while it goes on. One thread.
class RunProgress {
 public:
  /// `wall` limits the screen to 15 changes a second; a change of state always shows.
  RunProgress(std::FILE* out, const ProgressStyle& style, const RunSetting& setting, const hal::Clock& wall);
  /// Gives the terminal back as it was.
  ~RunProgress();
  RunProgress(const RunProgress&) = delete;
  RunProgress& operator=(const RunProgress&) = delete;

  void show(const RunStatus& status);
  /// The terminal has echoed a line below the screen.
  void line_was_typed();
  /// The last screen stays; the cursor comes back. Then print run_summary().
  void end();

 private:
  /// How much a device had accepted when, for its rate.
  struct Count {
    std::string name;
    double t_s = 0.0, rate_hz = 0.0;
    std::uint64_t accepted = 0;
  };

  void fill_rates(RunStatus& status);
  void draw(const RunStatus& status);
  void plain(const RunStatus& status);

  std::FILE* out_;
  ProgressStyle style_;
  const RunSetting* setting_;
  const hal::Clock* wall_;
  std::size_t lines_ = 0;
  std::optional<hal::Timestamp> drawn_at_;
  std::optional<RunStatus> last_;  ///< Newest that was handed in.
  std::optional<control::Task> said_;
  std::string press_said_;
  std::size_t faults_said_ = 0;
  std::vector<Count> counts_;
};

/// What happened and how good it was, in plain words, lines of at most `columns`.
[[nodiscard]] std::string run_summary(const RunView& view, int columns = 80);

}  // namespace colift::tools
