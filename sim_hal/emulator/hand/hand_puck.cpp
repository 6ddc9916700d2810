#include "sim_hal/emulator/hand/hand_puck.hpp"

#include <algorithm>
#include <cmath>

namespace colift::sim_hal {
namespace {

using namespace prop;

constexpr double kNear = 0.5;            // counts: the trapezoid has arrived
constexpr double kStill = 0.05;          // counts in a millisecond
constexpr double kStopFound_ms = 100.0;  // without motion, while it looks for the open stop
constexpr int kIdle = 0, kTorque = 2, kPosition = 3, kVelocity = 4, kTrapezoid = 5;
constexpr int kReset = 2, kInitialise = 13, kStepClose = 14, kStepOpen = 15, kTorqueClose = 16,
              kTorqueOpen = 17, kClose = 18, kMove = 19, kOpen = 20, kTerminate = 21;
constexpr int kMinStrain = 667, kMostStrain = 3460;  // where a puck protects its gauge
constexpr int kProtectOff = 10000, kProtectOn = 10001;
constexpr double kFastest = 400.0;  // counts/ms
constexpr int kAddr = 6, kValue = 7;
constexpr std::int32_t kMostCounts = 2'097'151;  // 22 bits
// heat: a puck that gives 2200 units for long ends 45 K above its surroundings, its motor 60 K
constexpr double kPuckRise_k = 45.0, kMotorRise_k = 60.0, kFullTorque = 2200.0;
constexpr double kPuckLag_ms = 300e3, kMotorLag_ms = 120e3, kIdleRise_k = 6.0;
constexpr double kDerates_k = 16.0;  // below OTEMP

bool in_monitor(int property) {
  return property == kVers || property == kRole || property == kSn || property == kId || property == kError ||
         property == kStat || property == kAddr || property == kValue;
}

std::int32_t rounded(double v) {
  return static_cast<std::int32_t>(std::lround(v));
}

}  // namespace

HandPuck::HandPuck(std::size_t index, const HandPuckConfig& config)
    : index_(index),
      node_(kFirstHandNode + static_cast<int>(index)),
      config_(config),
      puck_c_(config.ambient_c + kIdleRise_k),
      motor_c_(config.ambient_c) {
  for (int n = 0; n < 128; ++n)
    if (const HandProperty* p = hand_property(n))
      flash_[static_cast<std::size_t>(n)] = index_ == kHandSpread ? p->spread : p->finger;
  flash_[kVers] = config.firmware;
  flash_[kRole] = index_ == kHandSpread ? config.spread_role : config.finger_role;
  flash_[kSn] = 100 + node_;
  flash_[kId] = node_;
  flash_[kPidx] = node_ - 10;
  flash_[85] = node_ - 3;
  flash_[kGrpC] = config.group_c;
  if ((flash_[kRole] & 0x1000) == 0) flash_[kTactid] = -2;
  load_flash();
  if (config.awake) life_ = Life::Ready;
}

void HandPuck::load_flash() {
  ram_ = flash_;
  speed_property_ = kMv;
}

void HandPuck::start(const HandJoint& joint) {
  now_ = joint;
  frozen_motor_ = joint.motor;
  frozen_joint_ = joint.joint;
  if (config_.awake) return;
  zero_ = joint.motor;
  joint_zero_ = joint.joint;
}

bool HandPuck::listens_to(int group) const {
  return group == ram_[kGrpA] || group == ram_[kGrpB] || group == ram_[kGrpC];
}

bool HandPuck::knows(int property) const {
  const HandProperty* p = hand_property(property);
  return p != nullptr && config_.firmware >= p->since;
}

bool HandPuck::has_pad() const {
  return (ram_[kRole] & 0x1000) != 0;
}

std::int32_t HandPuck::position() const {
  return rounded((frozen_ ? frozen_motor_ : now_.motor) - zero_);
}

std::int32_t HandPuck::joint() const {
  return rounded((frozen_ ? frozen_joint_ : now_.joint) - joint_zero_);
}

std::optional<std::int32_t> HandPuck::get(int property) const {
  if (!knows(property)) return config_.answers_unknown ? std::optional(0) : std::nullopt;
  if (!hand_property(property)->readable()) return std::nullopt;
  if (life_ == Life::Monitor && !in_monitor(property)) return std::nullopt;
  switch (property) {
    case kStat:
      return life_ == Life::Ready ? 2 : life_ == Life::Error ? 1 : 0;
    case kMode:
      return finding_ ? kTrapezoid : mode();
    case kP:
      return position();
    case kJp:
      return has_joint() ? joint() : 0;
    case kT:
      return rounded(now_.torque);
    case kV:
      return rounded(speed_);
    case kTemp:
      return rounded(puck_c_);
    case kTherm:
      return rounded(motor_c_);
    case kUpsecs:
      return rounded(std::floor(up_ms_ / 1000.0)) & 0x7fff;
    case kImotor:
      return std::clamp(2048 + rounded(now_.torque * 0.2), 0, 4095);
    case kSg: {
      if (!has_joint() || (ram_[kRole] & 0x0800) == 0) return 2048;
      const double idle = config_.strain_idle[index_];
      const double wanted =
          hand_strain_nm(idle) + (now_.strain_nm + weight_nm_) / config_.strain_scale[index_];
      double low = 0.0, high = 4095.0;
      while (high - low > 0.25) {
        const double middle = 0.5 * (low + high);
        (hand_strain_nm(middle) < wanted ? low : high) = middle;
      }
      return rounded(low);
    }
    default:
      return ram_[static_cast<std::size_t>(property)];
  }
}

HandCells HandPuck::cells() const {
  HandCells out{};
  if (!has_pad()) return out;
  for (std::size_t i = 0; i < kHandCells; ++i)
    out[i] =
        static_cast<std::uint16_t>(std::clamp(std::lround(256.0 * (now_.pressure[i] - tare_[i])), 0L, 4095L));
  return out;
}

HandPuck::Taken HandPuck::set(int property, std::int32_t value) {
  if (!knows(property)) return Taken::Unknown;
  if (property == kStat) {
    if (value == 2 && life_ == Life::Monitor) {
      life_ = Life::Booting;
      boot_ms_ = 1e3 * config_.boot_s;
    } else if (value == 0 && life_ != Life::Monitor) {
      reset();
    }
    return Taken::Yes;
  }
  if (life_ != Life::Ready) return Taken::Asleep;
  const HandProperty& p = *hand_property(property);
  if (!p.writable()) return Taken::ReadOnly;
  if (!p.wide) value = static_cast<std::int16_t>(value & 0xffff);
  switch (property) {
    case kMode:
      set_mode(value);
      break;
    case kCmd:
      command(value);
      break;
    case kP:
      // a set-point while it holds a position; when idle, the position is called so from now on
      if (mode() == kIdle)
        zero_ = now_.motor - std::clamp(value, -kMostCounts, kMostCounts);
      else
        set_point_ = value;
      break;
    case kM:
      move_to(value, kMv);
      break;
    case kTact:
      if (value == 3)
        tare_ = now_.pressure;
      else if (value == 0 || (has_pad() && (value == 1 || value == 2)))
        at(kTact) = value;
      break;
    case kHsg:
      if (value == kProtectOff || value == kProtectOn)
        protects_ = value == kProtectOn;
      else
        at(kHsg) = value;
      break;
    case kSave:
    case kDef:
    case kLoad:
      for (int n = 0; n < 128; ++n) {
        if (n != value && value != -1) continue;
        const auto i = static_cast<std::size_t>(n);
        const HandProperty* row = hand_property(n);
        if (row == nullptr || !row->writable() || row->access == HandProperty::Access::Command) continue;
        if (property == kSave) flash_[i] = ram_[i];
        if (property == kLoad) ram_[i] = flash_[i];
        if (property == kDef && n != kId) flash_[i] = index_ == kHandSpread ? row->spread : row->finger;
      }
      break;
    default:
      at(property) = value;
  }
  return Taken::Yes;
}

void HandPuck::set_mode(int mode) {
  if (mode < kIdle || mode > kTrapezoid) return;
  finding_ = false;
  at(kMode) = mode;
  still_ms_ = 0.0;
  set_point_ = position();
  speed_property_ = kMv;
}

void HandPuck::move_to(std::int32_t target, int speed_property) {
  at(kE) = target;
  set_mode(kTrapezoid);
  speed_property_ = speed_property;
}

void HandPuck::command(int code) {
  switch (code) {
    case kReset:
      reset();
      break;
    case kInitialise:
      finding_ = true;
      still_ms_ = 0.0;
      quiet_ms_ = 1e3 * config_.hi_silence_s;
      break;
    case kStepClose:
      move_to(std::min(position() + ram_[kDs], ram_[kCt]), kMcv);
      break;
    case kStepOpen:
      move_to(std::max(position() - ram_[kDs], ram_[kOt]), kMov);
      break;
    case kTorqueClose:
    case kTorqueOpen:
      set_mode(kTorque);
      at(kT) = code == kTorqueClose ? ram_[kMt] : -ram_[kMt];
      break;
    case kClose:
      move_to(ram_[kCt], kMcv);
      break;
    case kMove:
      move_to(ram_[kDp], kMv);
      break;
    case kOpen:
      move_to(ram_[kOt], kMov);
      break;
    case kTerminate:
      set_mode(kIdle);
      break;
    default:
      break;  // of the old RS-232 language, nothing on the bus
  }
}

void HandPuck::end_move() {
  at(kMode) = ram_[kHold] != 0 ? kPosition : kIdle;
  finding_ = false;
  still_ms_ = 0.0;
  set_point_ = position();
}

double HandPuck::torque_limit() const {
  const int limit = ram_[finding_ ? kIhit : kMt];
  const double over_k = puck_c_ - (ram_[kOtemp] - kDerates_k);
  return std::max(0, limit) * std::clamp(1.0 - over_k / kDerates_k, 0.0, 1.0);
}

double HandPuck::trapezoid(double from, double to) const {
  const double most = std::abs(static_cast<double>(ram_[static_cast<std::size_t>(speed_property_)]));
  const double accel = std::max(ram_[kAccel], 1) / 256.0;
  const double way = to - from, sign = way < 0.0 ? -1.0 : 1.0;
  const double before = std::max(0.0, sign * speed_);
  // half a millisecond's braking less: time comes in steps
  const double braking = std::sqrt(2.0 * accel * std::abs(way) + 0.25 * accel * accel) - 0.5 * accel;
  return sign * std::min({most, before + accel, std::max(braking, 0.1), std::abs(way), kFastest});
}

HandMotor HandPuck::decide() {
  HandMotor m;
  wished_ = 0.0;
  if (life_ != Life::Ready || (mode() == kIdle && !finding_)) return m;
  m.powered = true;
  m.torque = torque_limit();
  const double here = (frozen_ ? frozen_motor_ : now_.motor) - zero_;
  double goal = here;
  if (finding_) {
    wished_ = std::clamp<double>(ram_[kIvel], -kFastest, kFastest);
    goal = wished_ < 0.0 ? -zero_ : kFingerStop - zero_;
  } else if (mode() == kTrapezoid) {
    goal = ram_[kE];
    wished_ = trapezoid(here, goal);
  } else if (mode() == kPosition) {
    goal = set_point_;
    wished_ = std::clamp(0.1 * (goal - here), -kFastest, kFastest);
    if (std::abs(goal - here) < 1.0) wished_ = 0.0;
  } else if (mode() == kVelocity) {
    const double most = std::abs(static_cast<double>(ram_[kMv]));
    wished_ = std::clamp<double>(ram_[kV], -most, most);
    goal = wished_ < 0.0 ? ram_[kOt] : ram_[kCt];
    if (wished_ < 0.0 ? here + wished_ < goal : here + wished_ > goal) wished_ = goal - here;
  } else if (mode() == kTorque) {
    m.torque = std::min(m.torque, std::abs(static_cast<double>(ram_[kT])));
    wished_ = std::clamp(0.1 * ram_[kT], -kFastest, kFastest);
    goal = wished_ < 0.0 ? -zero_ : kFingerStop - zero_;
  }
  m.speed = wished_;
  m.goal = goal + zero_;
  return m;
}

bool HandPuck::strain_stops() const {
  if (finding_ || !has_joint() || (ram_[kRole] & 0x0800) == 0) return false;
  const std::int32_t sg = get(kSg).value_or(2048);
  if (wished_ > 0.0) return (ram_[kHsg] > 0 && sg > ram_[kHsg]) || (protects_ && sg > kMostStrain);
  if (wished_ < 0.0) return (ram_[kLsg] > 0 && sg < ram_[kLsg]) || (protects_ && sg < kMinStrain);
  return false;
}

void HandPuck::warm_up(double torque) {
  const double load = std::min(4.0, torque * torque / (kFullTorque * kFullTorque));
  puck_c_ += (config_.ambient_c + kIdleRise_k + kPuckRise_k * load - puck_c_) / kPuckLag_ms;
  motor_c_ += (config_.ambient_c + kMotorRise_k * load - motor_c_) / kMotorLag_ms;
  at(kPtemp) = std::max(at(kPtemp), rounded(puck_c_));
}

bool HandPuck::look(const HandJoint& joint) {
  speed_ = joint.motor - now_.motor;
  now_ = joint;
  up_ms_ += 1.0;
  warm_up(joint.torque);
  if (!frozen_) frozen_motor_ = now_.motor, frozen_joint_ = now_.joint;
  if (quiet_ms_ > 0.0) quiet_ms_ -= 1.0;
  if (life_ == Life::Booting) {
    boot_ms_ -= 1.0;
    if (boot_ms_ <= 0.0) life_ = Life::Ready;
  } else if (life_ == Life::Monitor && config_.auto_ready_s > 0.0 && up_ms_ >= 1e3 * config_.auto_ready_s) {
    life_ = Life::Ready;
  }
  if (life_ != Life::Ready || (mode() == kIdle && !finding_)) return false;
  still_ms_ = std::abs(speed_) < kStill ? still_ms_ + 1.0 : 0.0;
  if (finding_) {
    if (still_ms_ < kStopFound_ms || quiet_ms_ > 0.0) return false;
    // wherever it stands is its open stop now: the encoder knows no better
    zero_ = now_.motor;
    joint_zero_ = now_.joint;
    at(kE) = 0;
    end_move();
    return true;
  }
  const bool arrived = mode() == kTrapezoid && std::abs(now_.motor - zero_ - ram_[kE]) < kNear && !frozen_;
  const bool given_up = ram_[kTstop] > 0 && still_ms_ >= ram_[kTstop];
  if (arrived || given_up || strain_stops()) end_move();
  return false;
}

void HandPuck::reset() {
  load_flash();
  at(kPtemp) = rounded(puck_c_);
  life_ = Life::Monitor;
  zero_ = now_.motor;
  joint_zero_ = now_.joint;
  tare_ = {};
  finding_ = false;
  protects_ = true;
  quiet_ms_ = up_ms_ = 0.0;
}

void HandPuck::fail(int error_code) {
  life_ = Life::Error;
  finding_ = false;
  at(kMode) = kIdle;
  at(kError) = error_code;
}

void HandPuck::supply(double v) {
  at(kVbus) = rounded(v);
}

void HandPuck::heat(double c) {
  puck_c_ = motor_c_ = c;
}

void HandPuck::shift(double counts) {
  zero_ -= counts;
}

}  // namespace colift::sim_hal
