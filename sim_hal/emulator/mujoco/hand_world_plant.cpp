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
constexpr double kMeasured_nm = 0.03, kMeasured_n = 0.5;
constexpr double kFreeTorque = 300.0;
constexpr double kMin_nm = 0.02;
constexpr int kPressAgain_ms = 200;
constexpr std::size_t kFirstTouched = 6, kBehindTouched = 15;  // cells 7 to 15, the middle of the pad

}  // namespace

HandWorldPlant::HandWorldPlant(SimWorld& world, const HandWorldConfig& config)
    : world_(world), config_(config) {
  world_moves_ = true;
  read_world();
}

HandWorldPlant::Request HandWorldPlant::wished() const {
  Request request;
  bool closes = false, opens = false, shut = false;
  for (std::size_t f = 0; f < kHandFingers; ++f) {
    const HandMotor& m = motors_[f];
    shut = shut || joints_[f].motor > kOpen;
    if (!m.powered || m.torque <= 0.0) continue;
    if (m.speed > 0.0 && way(f) > kThere)
      request.torque_nm[f] = std::max(kMin_nm, m.torque / config_.tip_units_nm);
    request.opens[f] = m.speed < 0.0 && way(f) < -kThere;
    closes = closes || request.torque_nm[f] > 0.0;
    opens = opens || request.opens[f];
  }
  if (opens || closes) {
    request.move = opens ? Move::Open : Move::Close;
    return request;
  }
  const HandMotor& spread = motors_[kHandSpread];
  const bool turns = spread.powered && spread.torque > 0.0 && spread.speed != 0.0 &&
                     std::abs(way(kHandSpread)) > kSpreadThere;
  if (turns && !shut) request.move = Move::Turn, request.spread_rad = spread.goal / kSpreadGear_rad;
  return request;
}

void HandWorldPlant::begin(const Request& request) {
  if (request.move == Move::Close) world_.close_hand(request.torque_nm);
  if (request.move == Move::Open) world_.open_hand(request.opens);
  if (request.move == Move::Turn) world_.preshape_hand(request.spread_rad);
  request_ = request;
  since_request_ms_ = 0;
  world_moves_ = true;
}

bool HandWorldPlant::differs(const Request& request) const {
  if (request.move != request_.move) return true;
  if (request.move == Move::Turn) return std::abs(request.spread_rad - request_.spread_rad) > 0.001;
  if (request.move == Move::Open) return request.opens != request_.opens;
  for (std::size_t f = 0; f < kHandFingers; ++f)
    if ((request.torque_nm[f] > 0.0) != (request_.torque_nm[f] > 0.0) ||
        std::abs(request.torque_nm[f] - request_.torque_nm[f]) > 0.1 * request_.torque_nm[f])
      return true;
  return false;
}

// The world's fingers are locked when they have stopped; a motor that is on would go on.
bool HandWorldPlant::yielded(const Request& request) const {
  if (request.move != Move::Close || world_moves_ || since_request_ms_ <= kPressAgain_ms) return false;
  for (std::size_t f = 0; f < kHandFingers; ++f)
    if (request.torque_nm[f] > 0.0 && joints_[f].strain_nm < 0.5 * request.torque_nm[f]) return true;
  return false;
}

void HandWorldPlant::tell_world() {
  const Request request = wished();
  ++since_request_ms_;
  if (request.move != Move::None) {
    if (differs(request) || yielded(request)) begin(request);
    return;
  }
  if (request_.move == Move::None) return;
  // closing with no torque locks the worms, and lets the world count what is touched as a grasp
  if (request_.move == Move::Close && touches_ && world_moves_)
    world_.close_hand(request.torque_nm);
  else
    world_.power_hand(false);
  request_ = request;
}

void HandWorldPlant::read_world() {
  const hal::HandState s = world_.hand_state();
  // the last millisecond of a move counts
  const bool moves = s.moving || world_moves_ || world_.hand_worms_turn();
  world_moves_ = s.moving;
  touches_ = false;
  const auto follow = [](double& commanded, double now, double goal, double there, bool powered) {
    if (powered && std::abs(now - goal) < there)
      commanded = goal;
    else if (std::abs(now - commanded) > kNoise)
      commanded = now;
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
    touches_ = touches_ || std::abs(j.strain_nm) > kMeasured_nm || s.tip_force_n[f] > kMeasured_n;
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
