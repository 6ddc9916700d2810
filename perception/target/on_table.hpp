#pragma once

#include "hal/config/range.hpp"

namespace colift::perception {

/// What counts as a target on a table, in place of the entries of the same name in TargetConfig: low, wholly
/// in view, and seen to stand on the table, because what is beyond its rim, a person on a chair too, rises
/// above its plane.
struct OnTableConfig {
  double max_height_m = 0.6;
  double max_cut = 0.1;
  double max_floating_m = 0.05;
  double min_on_ground = 0.2;
  double min_confidence = 0.6;
  double top_cut_weight = 1.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("max_height_m", max_height_m, hal::kPositive, "Max height of a target over the table (m).");
    v("max_cut", max_cut, hal::kFraction,
      "Max fraction of a target's side that the left, right or bottom of the view cuts off.");
    v("max_floating_m", max_floating_m, hal::kPositive,
      "Max height over the table at which the lowest part that is seen of a target begins (m).");
    v("min_on_ground", min_on_ground, hal::kFraction,
      "Min fraction of a target's outline along which the table begins.");
    v("min_confidence", min_confidence, hal::kFraction,
      "Min confidence with which an object is taken for the target; below it a person has to point at it.");
    v("top_cut_weight", top_cut_weight, hal::kFraction,
      "Weight in max_cut of the fraction of the upper side that the view cuts off.");
  }
};

}  // namespace colift::perception
