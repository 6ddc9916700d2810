#pragma once

#include <vector>

#include "hal/config/range.hpp"

namespace colift::planner {

/// How a plan leaves a start that is too near to something.
struct EscapeConfig {
  std::vector<double> radii_rad{0.03, 0.06, 0.12, 0.2, 0.3, 0.45};
  int tries = 200;
  int exact_tries = 8;

  template <class Visitor>
  void visit(Visitor& v) {
    v("radii_rad", radii_rad, hal::Range{0.001, 3.2},
      "Max joint distances from the start within which a free position is searched, one after the other "
      "(rad).");
    v("tries", tries, hal::Range{1, 1e6}, "Max number of random positions within each of these distances.");
    v("exact_tries", exact_tries, hal::Range{1, 1e6},
      "Max number of those that are free by the fast check and tried with the exact one.");
  }
};

/// How a path is shortened.
struct ShortcutConfig {
  int rounds = 160;
  int give_up_after = 32;
  int passes = 4;
  double min_gain = 0.01;

  template <class Visitor>
  void visit(Visitor& v) {
    v("rounds", rounds, hal::Range{0, 1e6}, "Max number of random shortcuts that are tried.");
    v("give_up_after", give_up_after, hal::Range{1, 1e6}, "Consecutive failures that end these tries.");
    v("passes", passes, hal::Range{0, 1000}, "Max number of passes over all corners.");
    v("min_gain", min_gain, hal::kFraction,
      "Min gain of a shortcut that is checked, as a fraction of the path's length.");
  }
};

/// How a collision-free path is searched and shortened.
struct SearchConfig {
  double max_edge_rad = 1.0;
  int attempts = 3;
  double same_posture_rad = 0.3;
  double max_turn_rad_per_m = 20.0;
  double sphere_excess_m = 0.009;
  EscapeConfig escape;
  ShortcutConfig shortcut;

  template <class Visitor>
  void visit(Visitor& v) {
    v("max_edge_rad", max_edge_rad, hal::Range{0.01, 20},
      "Max edge by which a tree of RRT-Connect grows (rad, Euclidean).");
    v("attempts", attempts, hal::Range{1, 10},
      "Max number of searches, each at half the step, when the check of the trajectory finds a contact.");
    v("same_posture_rad", same_posture_rad, hal::Range{0, 3.2},
      "Max difference in any joint of two arm postures that count as one goal (rad).");
    v("max_turn_rad_per_m", max_turn_rad_per_m, hal::Range{0.1, 1000},
      "Max joint motion per metre of a straight path of the hand; more is a jump near a singularity "
      "(rad/m).");
    v("sphere_excess_m", sphere_excess_m, hal::Range{0.001, 0.1},
      "Max distance by which the spheres of the fast check stand out of the robot's surface (m).");
    v("escape", escape, "How a plan leaves a start that is too near to something.");
    v("shortcut", shortcut, "How a path is shortened.");
  }
};

}  // namespace colift::planner
