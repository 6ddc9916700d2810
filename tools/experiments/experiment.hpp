#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "control/config/resolve_config.hpp"
#include "tools/experiments/kept_lift.hpp"
#include "tools/experiments/statistics.hpp"
#include "tools/experiments/trial_table.hpp"
#include "tools/visualization/canvas.hpp"

namespace colift::control {
struct RunRecord;
}

namespace colift::experiments {

/// Where the camera stands.
enum class View {
  OfLayout,  ///< As the layout has it: mostly beyond the object, looking at robot and partner.
  Side,      ///< Beside the robot, as in config/scenario/table_side_camera.yaml: sees the faces towards the
             ///< arm, which the thesis's method needs.
};

/// What one trial is made from. The same trial gives the same rows, wherever and beside whatever it runs.
struct Trial {
  std::uint64_t seed = 1;  ///< Of the campaign.
  int index = 0;
  control::Method method = control::Method::Fast;
  View view = View::OfLayout;
  /// Told how each whole lift of the trial ended; mostly empty.
  std::function<void(const control::RunRecord&)> watch = {};

  /// A number of its own for everything random in it, the same for both methods.
  [[nodiscard]] std::uint64_t own_seed(std::uint64_t stream) const;
};

/// Without the trial's number and method, which the campaign puts before them.
struct TrialRows {
  Row row;
  std::vector<Row> details;  ///< One per grasp that was tried.
  std::string words;         ///< For the screen.
  /// The lift of a trial that missed a requirement; the campaign keeps it beside the table.
  std::optional<KeptLift> kept = {};
};

/// A figure of a whole campaign.
struct Figure {
  std::string key;   ///< In the JSON.
  std::string name;  ///< For people.
  Estimate estimate;
  std::string unit;  ///< "%" multiplies by 100 on the screen.
  std::optional<double> goal = {};
  bool at_least = true;     ///< The goal is a lower bound; else an upper one.
  std::string thesis = {};  ///< What the thesis found.

  [[nodiscard]] bool met() const {
    return !goal || (estimate.n > 0 && (at_least ? estimate.value >= *goal : estimate.value <= *goal));
  }
};

/// What the figures and the plot are made from: rows of one method.
struct Results {
  const TrialTable& trials;
  const TrialTable& details;
};

/// What speaks against a trial: the larger, the worse.
struct Badness {
  double value = 0.0;
  std::string words;
};

/// One experiment of the thesis's chapter 6, or one that goes beyond it.
struct Experiment {
  std::string name, title, thesis;  ///< `thesis`: where it stands, "6.3.2".
  std::string question;             ///< What a trial is and what is measured, in one or two sentences.
  int default_trials = 10;
  bool times_computing = false;  ///< One trial at a time, so that they do not slow each other.
  bool real_time = false;        ///< Needs a quiet machine of its own: not a part of `all`.
  std::vector<std::string> columns, detail_columns;  ///< After trial and method.
  std::function<TrialRows(const Trial&)> run;
  std::optional<control::TaskSaid> task;  ///< What it says about its lifts, where all are alike.
  std::string trials_set;  ///< Entries of the configuration that trials set beside it, for people.
  std::function<std::vector<Figure>(const Results&)> figures;
  std::function<picture::Canvas(const Results&)> plot;
  /// How bad a trial was, in words and in a number; nullopt: it does not count. Unset: trials are not ranked.
  std::function<std::optional<Badness>(const Results&, const Row&)> badness = {};
};

/// All of them, in the order of the thesis; made once.
[[nodiscard]] const std::vector<Experiment>& all_experiments();
[[nodiscard]] const Experiment* find_experiment(const std::string& name);

// one file each
[[nodiscard]] Experiment grasps_experiment();
[[nodiscard]] Experiment realtime_experiment();
[[nodiscard]] Experiment tilt_experiment();
[[nodiscard]] Experiment load_experiment();
[[nodiscard]] Experiment complex_experiment();
[[nodiscard]] Experiment robust_experiment();
[[nodiscard]] Experiment wrong_cog_experiment();
[[nodiscard]] Experiment slip_experiment();
[[nodiscard]] Experiment tasks_experiment();
[[nodiscard]] Experiment agents_experiment();
[[nodiscard]] Experiment let_go_experiment();
[[nodiscard]] Experiment people_experiment();
[[nodiscard]] Experiment false_stops_experiment();
[[nodiscard]] Experiment fingers_experiment();
[[nodiscard]] Experiment faults_experiment();
[[nodiscard]] Experiment stalls_experiment();
[[nodiscard]] Experiment mass_experiment();
[[nodiscard]] Experiment share_experiment();
[[nodiscard]] Experiment lift_alone_experiment();
[[nodiscard]] Experiment rooms_experiment();
[[nodiscard]] Experiment stances_experiment();
[[nodiscard]] Experiment imperfect_experiment();
[[nodiscard]] Experiment impedance_experiment();
[[nodiscard]] Experiment certificate_experiment();
[[nodiscard]] Experiment views_experiment();
[[nodiscard]] Experiment furniture_experiment();
[[nodiscard]] Experiment candidates_experiment();
[[nodiscard]] Experiment hidden_hand_experiment();

}  // namespace colift::experiments
