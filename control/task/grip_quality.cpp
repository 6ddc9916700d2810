#include "control/task/grip_quality.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "planner/grasp/grasp_stability.hpp"

namespace colift::control {
namespace {

constexpr double kTip_m = 0.05;  // outer joint to the pad's middle (maker's Denavit-Hartenberg table)
// Of the outer joint beyond a third of the inner one: the clutch has given way (9500 counts of the motor).
constexpr double kBrokenAway_rad = 0.15;
constexpr double kFeltTorque_nm = 0.08;
constexpr double kGrips_nm = 0.2,
                 kBesidePad = 0.2;  // torque of a grip; of the force that its pad should feel
constexpr std::array<const char*, hal::kTactileArrays> kNames{"F1", "F2", "F3", "palm"};

// A fingertip has eight rows of three from its root, the palm rows of 5, 7, 7 and 5 (maker's geometry).
int row_of(std::size_t array, std::size_t cell) {
  if (array != hal::kPalmArray) return static_cast<int>(cell) / 3;
  return cell < 5 ? 0 : cell < 12 ? 1 : cell < 19 ? 2 : 3;
}

ArrayContact contact_of(std::size_t array, const hal::TactileArray& a, double force_n, double threshold) {
  ArrayContact c;
  c.force_n = force_n;
  double sum = 0.0, rows = 0.0;
  for (std::size_t i = 0; i < a.pressure_n_cm2.size(); ++i) {
    const double p = a.pressure_n_cm2[i];
    if (!(p > threshold)) continue;  // NaN: no sensor
    ++c.cells;
    sum += p;
    rows += p * row_of(array, i);
  }
  if (sum > 0.0) c.row = rows / sum;
  return c;
}

}  // namespace

GripQuality grip_quality(const hal::HandState& hand, double asked_nm, const GripConfig& config) {
  GripQuality q;
  q.asked_nm = asked_nm;
  q.torque_nm = hand.torque_nm;
  q.cells = hand.tactile;
  for (std::size_t i = 0; i < q.contacts.size(); ++i)
    q.contacts[i] =
        contact_of(i, hand.tactile[i], i < hal::kFingers ? hand.tip_force_n[i] : hand.palm_force_n,
                   config.cell_contact_n_cm2);
  double strongest_nm = NAN, normal_n = NAN;
  bool broken_away = false;
  for (std::size_t f = 0; f < hal::kFingers; ++f) {
    const bool felt = q.contacts[f].cells > 0 || hand.tip_force_n[f] > config.contact_n ||
                      hand.torque_nm[f] > kFeltTorque_nm;
    q.contact_points += felt ? 1 : 0;
    broken_away = broken_away || hand.outer_rad[f] - hand.finger_rad[f] / 3.0 > kBrokenAway_rad;
    strongest_nm = std::fmax(strongest_nm, hand.torque_nm[f]);
    const double by_gauge_n = hand.torque_nm[f] / kTip_m, by_pad_n = hand.tip_force_n[f];
    q.beside_pad[f] = hand.torque_nm[f] > kGrips_nm && by_pad_n < kBesidePad * by_gauge_n;
    const bool by_pad = by_pad_n > config.contact_n && !q.beside_pad[f];  // NaN: no pad
    const double n = by_pad ? by_pad_n : by_gauge_n;
    if (!std::isnan(n)) normal_n = (std::isnan(normal_n) ? 0.0 : normal_n) + std::fmax(n, 0.0);
  }
  q.squeeze_n = broken_away ? NAN : 0.5 * normal_n;
  if (q.palm_touches()) {
    ++q.contact_points;
    normal_n += std::isnan(hand.palm_force_n) ? 0.0 : hand.palm_force_n;
  }
  if (asked_nm > 0.0 && !broken_away) q.held_fraction = std::fmax(strongest_nm, 0.0) / asked_nm;
  if (std::isnan(strongest_nm)) q.held_fraction = NAN;
  q.friction_limit_n = config.friction * normal_n;
  return q;
}

std::string describe(const GripQuality& q) {
  std::string who, forces;
  int cells = 0;
  for (std::size_t i = 0; i < q.contacts.size(); ++i) {
    const bool known = !std::isnan(q.contacts[i].force_n);
    if (i < hal::kFingers)
      forces +=
          fmt::format("{}{}", i > 0 ? ", " : "", known ? fmt::format("{:.0f}", q.contacts[i].force_n) : "-");
    if (q.contacts[i].cells == 0) continue;
    who += fmt::format("{}{}", who.empty() ? "" : ", ", kNames[i]);
    cells += q.contacts[i].cells;
  }
  std::string t = cells > 0 ? fmt::format("contacts: {} ({} cells)", who, cells)
                            : fmt::format("{} contacts", q.contact_points);
  t += fmt::format("; pads {} N", forces);
  if (!std::isnan(q.held_fraction)) t += fmt::format("; holds at {:.2f} of what was asked", q.held_fraction);
  for (std::size_t f = 0; f < hal::kFingers; ++f)
    if (q.beside_pad[f])
      t += fmt::format("; {} presses with {:.2f} N m beside its pad", kNames[f], q.torque_nm[f]);
  if (!std::isnan(q.friction_limit_n)) t += fmt::format("; friction carries {:.0f} N", q.friction_limit_n);
  return t;
}

std::string slip_words(const hal::HandState& hand) {
  const std::string why = hand.warning.str();
  return "slip detected by the fingers" + (why.empty() ? why : ": " + why);
}

double slip_margin(const GripQuality& quality, const planner::GraspCandidate& grasp, planner::HandModel hand,
                   const hal::Wrench& load) {
  if (std::isnan(quality.squeeze_n)) return NAN;
  std::array<int, 2> fingers{};
  for (const planner::HandFinger& finger : hand.fingers) ++fingers[finger.side < 0 ? 0 : 1];
  hand.finger_force_n = quality.squeeze_n / std::max({1, fingers[0], fingers[1]});
  return planner::stability_margins(grasp, hand, load).slip;
}

double friction_margin(const GripQuality& quality, double load_n) {
  return load_n > 0.0 ? quality.friction_limit_n / load_n : NAN;
}

}  // namespace colift::control
