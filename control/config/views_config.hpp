#pragma once

#include "hal/config/range.hpp"
#include "perception/views/view_alignment.hpp"

namespace colift::control {

/// How the views of several cameras are joined.
struct ViewsConfig {
  double max_age_s = 0.1;
  double same_hand_m = 0.12;
  double same_body_m = 0.15;
  double object_margin_m = 0.06;
  double min_of_object = 0.8;
  double covered_m = 0.03;
  double min_correction_m = 0.006;
  double min_sigmas = 6.0;
  double max_correction_m = 0.05;
  double max_rotation_deg = 2.0;
  double pushed_m = 0.025;
  double max_receded = 0.2;
  double check_pose_s = 0.2;
  int pushed_checks = 2;
  perception::AlignmentConfig alignment;

  template <class Visitor>
  void visit(Visitor& v) {
    v("max_age_s", max_age_s, hal::Range{0.01, 5},
      "Max age of another camera's frame, against that of the first, for its view to count (s).");
    v("same_hand_m", same_hand_m, hal::Range{0, 1},
      "Contacts in two views that are no farther apart are one hand's (m).");
    v("same_body_m", same_body_m, hal::Range{0, 2},
      "Bodies in two views whose boxes are no farther apart are one (m).");
    v("object_margin_m", object_margin_m, hal::Range{0, 1},
      "Another view's object lies in the box of the first one's, grown by this (m).");
    v("min_of_object", min_of_object, hal::kFraction,
      "Min fraction of its points in there; with less it is another thing.");
    v("covered_m", covered_m, hal::Range{0, 1},
      "A view shows the whole object when what others show lies in its completed shape, grown by this (m).");
    v("min_correction_m", min_correction_m, hal::Range{0, 1},
      "Min shift by which another camera's pose is corrected to agree with the first, root mean square (m).");
    v("min_sigmas", min_sigmas, hal::Range{0, 100},
      "Min shift in its standard deviations: a less certain one is neither a correction nor a push.");
    v("max_correction_m", max_correction_m, hal::Range{0, 1},
      "Max shift of this kind; beyond, the camera is not used (m).");
    v("max_rotation_deg", max_rotation_deg, hal::Range{0, 30}, "Max rotation of this kind (deg).");
    v("pushed_m", pushed_m, hal::Range{0.001, 1},
      "A camera is pushed when what stands still is seen farther off, root mean square, than this (m).");
    v("max_receded", max_receded, hal::kFraction,
      "... or when more than this fraction of its image lies behind what stood there.");
    v("check_pose_s", check_pose_s, hal::Range{0.03, 10},
      "Time between two checks of whether a camera was pushed (s).");
    v("pushed_checks", pushed_checks, hal::Range{1, 100}, "Number of such checks in a row that find it.");
    v("alignment", alignment, "How two views are aligned.");
  }
};

}  // namespace colift::control
