#pragma once

#include <string>

namespace colift::planner {

/// Which contacts a motion may make.
enum class Contacts {
  None,             ///< On the way: nothing may touch anything.
  FingersOnTarget,  ///< Last bit of the approach, and away again: hand links may be beside the target (their
                    ///< exact test is HandCollision's), arm links may not.
  Carrying,         ///< The target is in the hand and carried along.
};

/// What a configuration would touch.
struct Touch {
  enum class With { Nothing, Obstacle, Target, Ground, Itself, Limits, Carried };
  With with = With::Nothing;
  std::string part;      ///< Link that touches; of Itself the other one too, of Limits the joint.
  double depth_m = 0.0;  ///< By how much it is too near (rad for Limits); 0 where nobody measured it.
  [[nodiscard]] std::string text() const;  ///< "forearm comes 12 mm too near to an obstacle"
};

}  // namespace colift::planner
