#pragma once

#include <array>
#include <cmath>
#include <string>

#include "control/config/task_config.hpp"
#include "hal/hand.hpp"
#include "planner/grasp_candidate.hpp"
#include "planner/hand/hand_model.hpp"

namespace colift::control {

/// One array of tactile cells in contact. Index of arrays: F1, F2, F3, palm.
struct ArrayContact {
  int cells = 0;         ///< Above GripConfig::cell_contact_n_cm2; 0 without sensors, too.
  double force_n = NAN;  ///< NaN without sensors.
  double row = NAN;      ///< Centre of pressure, in rows of cells from the array's root; NaN without contact.
};

/// How well the closed hand holds, from what it measures. NaN where the hand has no sensor for it.
struct GripQuality {
  std::array<ArrayContact, hal::kTactileArrays> contacts{};
  std::array<hal::TactileArray, hal::kTactileArrays> cells{};  ///< As they were.
  std::array<double, hal::kFingers> torque_nm{};               ///< At the fingertips, from strain gauges.
  int contact_points = 0;         ///< Arrays with a cell in contact, or fingers that measure a torque.
  double asked_nm = NAN;          ///< Of close().
  double held_fraction = NAN;     ///< Torque of the strongest finger over what was asked.
  double friction_limit_n = NAN;  ///< Load along the object's surface at which it would slip.
  double squeeze_n = NAN;         ///< Normal force of each of both sides: half of what the fingers measure.
  /// Its gauge measures a grip of which its pad feels less than a fifth: the contact is beside the pad.
  std::array<bool, hal::kFingers> beside_pad{};
  [[nodiscard]] bool palm_touches() const { return contacts[hal::kPalmArray].cells > 0; }
};

/// Of a hand that was closed with `asked_nm`. The strongest finger counts, because F1 and F2 share what F3
/// bears; a broken-away finger's gauge says nothing of its inner link, which presses: then no fraction. The
/// friction limit is friction times the sum of the normal forces: pads, else (without them, or beside them)
/// torque over the 50 mm from outer joint to pad.
[[nodiscard]] GripQuality grip_quality(const hal::HandState& hand, double asked_nm, const GripConfig& config);

/// "contacts: F1, F3, palm (21 cells); 12, -, 11 N; holds at 0.83 of what was asked; friction carries 23 N".
[[nodiscard]] std::string describe(const GripQuality& quality);

/// What a hand that slips says of it: "slip detected by the fingers: the spread turned by 12 degrees ...".
[[nodiscard]] std::string slip_words(const hal::HandState& hand);

/// By which factor `load` (what the object does to the hand, force and torque about the point that it hangs
/// on, W) may grow until the object slips in a grip that presses as measured: planner::stability_margins with
/// that squeeze. A load that the fingers bear by their shape does not slip: infinite. NaN where the squeeze
/// is not known.
[[nodiscard]] double slip_margin(const GripQuality& quality, const planner::GraspCandidate& grasp,
                                 planner::HandModel hand, const hal::Wrench& load);

/// The friction limit over a load: below 1 it slips. NaN where one of them is not known.
[[nodiscard]] double friction_margin(const GripQuality& quality, double load_n);

}  // namespace colift::control
