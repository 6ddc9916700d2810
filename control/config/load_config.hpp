#pragma once

#include "hal/config/range.hpp"

namespace colift::control {

/// How the load at the palm is estimated from external joint torques.
struct LoadConfig {
  double filter_s = 0.05;

  template <class Visitor>
  void visit(Visitor& v) {
    v("filter_s", filter_s, hal::Range{0, 2}, "Time constant of the force estimate (s).");
  }
};

}  // namespace colift::control
