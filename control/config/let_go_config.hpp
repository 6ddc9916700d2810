#pragma once

#include "hal/config/range.hpp"

namespace colift::control {

/// How quickly load, force and picture say that the partner let go; their thresholds stand in CarryConfig and
/// in the presence of his hand. SI units.
struct LetGoConfig {
  double load_filter_s = 0.25;
  double pull_filter_s = 0.3;
  int pull_cycles = 4;
  double steady_fraction = 0.3;
  double hand_gain = 0.1;
  int hand_frames = 3;
  double small_hand_m2 = 0.0012;
  int small_hand_frames = 3;
  int low_frames = 2;
  double carried_m = 0.008;
  double min_load_n = 5.0;
  double fall_m = 0.008;
  double fall_s = 0.15;

  template <class Visitor>
  void visit(Visitor& v) {
    v("load_filter_s", load_filter_s, hal::Range{0.01, 10},
      "Time constant of the mean against which carry.load_gain_n is a gain: a person's jerk is quicker, a "
      "lift slower (s).");
    v("pull_filter_s", pull_filter_s, hal::Range{0.01, 10},
      "Time constant of the mean against which carry.pull_n is a pull (s).");
    v("pull_cycles", pull_cycles, hal::Range{1, 1000},
      "Cycles in a row with such a force; a knock is shorter.");
    v("steady_fraction", steady_fraction, hal::kFraction,
      "The force is steady again below this fraction of carry.pull_n.");
    v("hand_gain", hand_gain, hal::Range{0.001, 1},
      "Gain of a frame in the mean of how much is seen of his hand.");
    v("hand_frames", hand_frames, hal::Range{1, 100},
      "Frames after which it counts as known how much of his hand is seen.");
    v("small_hand_m2", small_hand_m2, hal::Range{0, 0.1},
      "Of a hand that usually shows less than this any motion may hide all of it (m^2): it has left ...");
    v("small_hand_frames", small_hand_frames, hal::Range{1, 30},
      "... when it is gone in so many frames in a row.");
    v("low_frames", low_frames, hal::Range{1, 100},
      "Frames in a row with his end lower than carry.partner_lag_m.");
    v("carried_m", carried_m, hal::Range{0.001, 0.1},
      "His end is off the ground when it is seen higher than this (m).");
    v("min_load_n", min_load_n, hal::Range{0, 100}, "A load below this says nothing of who carries (N).");
    v("fall_m", fall_m, hal::Range{0.002, 0.1},
      "His end falls when it is seen to sink by this much more than the palm (m) ...");
    v("fall_s", fall_s, hal::Range{0.03, 2},
      "... within this time: near the ground it cannot sink by carry.partner_lag_m (s).");
  }
};

/// What has to be seen and felt before a lift is called one. SI units.
struct EvidenceConfig {
  double min_rise_fraction = 0.5;
  double top_fraction = 0.8;
  double min_load_n = 1.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("min_rise_fraction", min_rise_fraction, hal::kFraction,
      "Min rise of either end of the object, as a fraction of task.lift_height_m: a tilted object has one "
      "end lower, one that stands on an edge does not rise there at all.");
    v("top_fraction", top_fraction, hal::kFraction,
      "The palm is at the top from this fraction of task.lift_height_m on.");
    v("min_load_n", min_load_n, hal::kNotNegative, "Min mean load in the hand at the top (N).");
  }
};

}  // namespace colift::control
