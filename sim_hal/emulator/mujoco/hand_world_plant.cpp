#include "sim_hal/emulator/mujoco/hand_world_plant.hpp"

#include <algorithm>
#include <cmath>

namespace colift::sim_hal {
namespace {

constexpr hal::Duration kTick = std::chrono::milliseconds(1);
constexpr double kThere = 200.0;                  // counts: two milliseconds' way of a finger
constexpr double kSpreadThere = 60.0;             // 0.3 degrees
constexpr double kNoise = 30.0;                   // counts: the links tremble, encoders on worms do not
constexpr double kOpen = 0.3 * kInnerCounts_rad;  // the world's hand turns its spread from here on
constexpr double kFelt_nm = 0.03, kFelt_n = 0.5;
constexpr double kFreeTorque = 300.0;
constexpr double kLeast_nm = 0.02;
constexpr int kLock_ms = 150;  // the world needs some 80 ms to see that its fingers stand
constexpr int kPressAgain_ms = 200;
constexpr std::size_t kFirstTouched = 6, kBehindTouched = 15;  // cells 7 to 15, the middle of the pad

}  // namespace

HandWorldPlant::HandWorldPlant(SimWorld& world, const HandWorldConfig& config)
    : world_(world), config_(config) {
  world_moves_ = true;
  read_world();
}

HandWorldPlant::Move HandWorldPlant::wished() const {
  bool closes = false, opens = false, shut = false;
  for (std::size_t f = 0; f < kHandFingers; ++f) {
    shut = shut || joints_[f].motor > kOpen;
    if (!motors_[f].powered || motors_[f].torque <= 0.0) continue;
    closes = closes || (motors_[f].speed > 0.0 && way(f) > kThere);
    opens = opens || (motors_[f].speed < 0.0 && way(f) < -kThere);
  }
  if (closes != opens) return closes ? Move::Close : Move::Open;
  if (closes) return Move::None;
  const HandMotor& spread = motors_[kHandSpread];
  const bool turns = spread.powered && spread.torque > 0.0 && spread.speed != 0.0 &&
                     std::abs(way(kHandSpread)) > kSpreadThere;
  return turns && !shut ? Move::Turn : Move::None;
}

void HandWorldPlant::begin(Move move, double torque_nm, double spread_rad) {
  if (move == Move::Close) world_.close_hand(torque_nm);
  if (move == Move::Open) world_.open_hand();
  if (move == Move::Turn) world_.preshape_hand(spread_rad);
  move_ = move;
  told_nm_ = torque_nm;
  told_rad_ = spread_rad;
  since_told_ms_ = without_wish_ms_ = 0;
  world_moves_ = true;
}

void HandWorldPlant::tell_world() {
  const Move wish = wished();
  double most = 0.0;
  for (std::size_t f = 0; f < kHandFingers; ++f)
    if (motors_[f].powered && motors_[f].speed > 0.0) most = std::max(most, motors_[f].torque);
  const double torque_nm = std::max(kLeast_nm, most / config_.tip_units_nm);
  const double spread_rad = motors_[kHandSpread].goal / kSpreadGear_rad;
  ++since_told_ms_;
  if (wish == Move::None) {
    ++without_wish_ms_;
    // a grip that is just being locked is left to lock
    const bool locks = move_ == Move::Close && touches_ && without_wish_ms_ < kLock_ms;
    if (move_ != Move::None && !locks) {
      if (world_moves_) world_.stop_hand();
      move_ = Move::None;
    }
    return;
  }
  without_wish_ms_ = 0;
  const bool other_torque = wish == Move::Close && std::abs(torque_nm - told_nm_) > 0.1 * told_nm_;
  const bool other_way = wish == Move::Turn && std::abs(spread_rad - told_rad_) > 0.001;
  // the world's fingers are locked when they have stopped; a motor that is on would go on
  bool lost = false;
  if (wish == Move::Close && !world_moves_)
    for (std::size_t f = 0; f < kHandFingers; ++f)
      lost = lost || (motors_[f].powered && way(f) > kThere && joints_[f].strain_nm < 0.5 * told_nm_);
  if (wish != move_ || other_torque || other_way || (lost && since_told_ms_ > kPressAgain_ms))
    begin(wish, torque_nm, spread_rad);
}

void HandWorldPlant::read_world() {
  const hal::HandState s = world_.hand_state();
  const bool moves = s.moving || world_moves_;  // the last millisecond of a move counts
  world_moves_ = s.moving;
  touches_ = false;
  const auto follow = [](double& told, double now, double goal, double there, bool powered) {
    if (powered && std::abs(now - goal) < there)
      told = goal;
    else if (std::abs(now - told) > kNoise)
      told = now;
  };
  for (std::size_t f = 0; f < kHandFingers; ++f) {
    HandJoint& j = joints_[f];
    const HandMotor& m = motors_[f];
    const double before = j.motor;
    // encoders sit on worms: a locked finger does not move them
    if (moves)
      follow(j.motor, std::max(0.0, (s.finger_rad[f] + s.outer_rad[f]) * kTotalCounts_rad), m.goal, kThere,
             m.powered && m.speed != 0.0);
    if (j.motor != before) j.joint = std::max(0.0, s.finger_rad[f] * kWormCounts_rad);
    j.strain_nm = s.torque_nm[f];
    touches_ = touches_ || std::abs(j.strain_nm) > kFelt_nm || s.tip_force_n[f] > kFelt_n;
    const double sign = m.speed > 0.0 ? 1.0 : -1.0;
    j.torque = 0.0;
    if (m.powered && m.speed != 0.0)
      j.torque =
          sign * (j.motor == before
                      ? m.torque
                      : std::min(m.torque, kFreeTorque + config_.tip_units_nm * std::max(0.0, j.strain_nm)));
    double weight_cm2 = 0.0;
    const auto share = [](std::size_t cell) { return cell % 3 == 1 ? 2.0 : 1.0; };
    for (std::size_t cell = kFirstTouched; cell < kBehindTouched; ++cell)
      weight_cm2 += share(cell) * hand_cell_cm2(false, cell);
    for (std::size_t cell = kFirstTouched; cell < kBehindTouched; ++cell)
      j.pressure[cell] = share(cell) * s.tip_force_n[f] / weight_cm2;
  }
  HandJoint& spread = joints_[kHandSpread];
  const HandMotor& m = motors_[kHandSpread];
  follow(spread.motor, std::max(0.0, s.spread_rad * kSpreadGear_rad), m.goal, kSpreadThere,
         m.powered && m.speed != 0.0);
  spread.torque = m.powered && m.speed != 0.0 ? std::copysign(std::min(m.torque, kFreeTorque), m.speed) : 0.0;
}

void HandWorldPlant::advance(hal::Duration by) {
  for (auto ticks = by / kTick; ticks > 0; --ticks) {
    tell_world();
    if (config_.moves_world) world_.advance(kTick);
    read_world();
  }
}

}  // namespace colift::sim_hal
