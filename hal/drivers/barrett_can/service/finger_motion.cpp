#include "hal/drivers/barrett_can/service/finger_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "hal/drivers/barrett_can/calibration/hand_calibration.hpp"
#include "hal/drivers/barrett_can/hand_units.hpp"
#include "hal/drivers/barrett_can/pucks/puck_link.hpp"
#include "hal/drivers/barrett_can/pucks/wait_on.hpp"
#include "hal/types/units.hpp"

namespace colift::hal {
namespace {

using namespace barrett;
using Kind = FingerMotion::Kind;

constexpr const char* kWhere = "hand.finger";
constexpr int kModeTorque = 2, kModeVelocity = 4;
constexpr double kAnswer_s = 0.35;      // three tries, on a slow link too
constexpr double kSettings_s = 0.4;     // of settings that are read back
constexpr std::int32_t kNear = 600;     // of its end a stopped puck has reached it, as the driver has it
constexpr std::int32_t kStill = 50;     // counts: noise
constexpr std::int32_t kMargin = 1500;  // to the ends of the range, without joint limits of the puck
constexpr std::int32_t kClosedFrom = 12'000;  // such fingers may hold something, as start-up has it
constexpr std::int32_t kRelief = 24'000;      // 17 degrees, over which what was pressed lets go of the gauge
constexpr double kOverTorque = 1.3;           // of what was asked, at the gauge
constexpr auto kSettles = std::chrono::milliseconds(60);
constexpr auto kRenewTorque = std::chrono::milliseconds(4);  // 200 Hz at least (maker's wiki)

tl::unexpected<Error> refuse(ErrorCode code, std::string words) {
  return failure(code, kWhere, std::move(words));
}

class Mover {
 public:
  Mover(CanBus& bus, const Clock& clock, const BarrettHandConfig& config, const FingerMotion& motion,
        const std::function<bool()>& interrupted)
      : clock_(clock),
        config_(config),
        motion_(motion),
        finger_(motion.finger),
        interrupted_(interrupted),
        link_(bus, clock, duration_of(1e-3 * config.reply_ms), duration_of(1e-3 * config.tactile_reply_ms)),
        units_per_nm_(config.torque_units_per_nm) {}

  Result<FingerMotionEnd> run() {
    if (auto good = check_request(); !good) return tl::unexpected(good.error());
    if (auto good = load_calibration(); !good) return tl::unexpected(good.error());
    link_.measure_round_trip(duration_of(kAnswer_s));
    if (auto good = look(); !good) return tl::unexpected(good.error());
    end_.from_rad = end_.to_rad = start_ / kFingerCounts_rad;
    if (auto good = check_target(); !good) return tl::unexpected(good.error());
    if (auto good = begin(); !good) {
      rest();
      return tl::unexpected(good.error());
    }
    end_.moved = true;
    const Timestamp began = clock_.now();
    watch(began);
    end_.took_s = seconds(clock_.now() - began);
    rest();
    end_.to_rad = position() / kFingerCounts_rad;
    return end_;
  }

 private:
  [[nodiscard]] const Reported& reported(Property p) const { return link_.reported(finger_, p); }
  [[nodiscard]] std::int32_t position() const { return reported(Property::P).value; }
  [[nodiscard]] bool opens() const {
    return motion_.kind == Kind::To ? target_ < start_ : motion_.value < 0.0;
  }

  bool wait(double limit_s, const std::function<bool()>& until) {
    return wait_on(link_, clock_, duration_of(limit_s), until);
  }

  Result<> check_request() const {
    const auto beyond = [](std::string words) { return refuse(ErrorCode::LimitExceeded, std::move(words)); };
    if (finger_ == Puck::Spread) return beyond("the spread is turned by preshape, expected F1, F2 or F3");
    const double torque_nm = motion_.kind == Kind::Torque ? std::abs(motion_.value) : motion_.torque_nm;
    if (!(torque_nm > 0.0 && torque_nm <= config_.max_torque_nm))
      return beyond(fmt::format("a torque of {} N m, expected more than 0 and at most {}", torque_nm,
                                config_.max_torque_nm));
    if (motion_.kind == Kind::Velocity &&
        !(std::abs(motion_.value) > 0.01 && std::abs(motion_.value) <= kMaxVelocity_rad_s))
      return beyond(fmt::format("{:.1f} deg/s, expected up to {:.0f} either way", rad_to_deg(motion_.value),
                                rad_to_deg(kMaxVelocity_rad_s)));
    if (!std::isfinite(motion_.value)) return beyond("not a number");
    if (!(motion_.for_s > 0.0 && motion_.for_s <= kMaxFor_s))
      return beyond(fmt::format("a time of {} s, expected up to {:.0f}", motion_.for_s, kMaxFor_s));
    return {};
  }

  // a wrong file is told before anything is asked of the hand
  Result<> load_calibration() {
    if (config_.calibration_file.empty()) return {};
    auto read = load_hand_calibration(config_.calibration_file);
    if (!read) return tl::unexpected(read.error());
    calibration_ = std::move(*read);
    return {};
  }

  Result<> look() {
    constexpr std::array kAsked{Property::Stat, Property::P, Property::Ct, Property::Mode, Property::Temp};
    for (const Puck puck : kFingerPucks)
      for (const Property p : kAsked) link_.ask(puck, p);
    for (const Property p : {Property::Role, Property::Sg, Property::Sn}) link_.ask(finger_, p);
    (void)wait(kAnswer_s, [&] {
      return std::none_of(kFingerPucks.begin(), kFingerPucks.end(), [&](Puck puck) {
        return std::any_of(kAsked.begin(), kAsked.end(), [&](Property p) { return link_.pending(puck, p); });
      });
    });
    for (const Puck puck : kFingerPucks) {
      const Reported& stat = link_.reported(puck, Property::Stat);
      const bool this_one = puck == finger_;
      if (!stat.known) {
        if (this_one) return refuse(ErrorCode::LinkLost, fmt::format("{} does not answer", name(puck)));
        continue;
      }
      if (this_one && stat.value == kStatError)
        return refuse(ErrorCode::DeviceFault, fmt::format("{} reports an error", name(puck)));
      if (this_one &&
          (stat.value != kStatReady || link_.reported(puck, Property::Ct).value != zero_mark(puck)))
        return refuse(ErrorCode::NotReady, fmt::format("{} is asleep or does not know its zero", name(puck)));
      if (const Reported& mode = link_.reported(puck, Property::Mode); mode.known && mode.value != kModeIdle)
        return refuse(ErrorCode::NotReady,
                      fmt::format("the motor of {} is on (MODE {}): another program drives the hand",
                                  name(puck), mode.value));
      const Reported& p = link_.reported(puck, Property::P);
      closed_ += p.known && p.value > kClosedFrom ? 1 : 0;
    }
    const Reported& temp = reported(Property::Temp);
    if (!reported(Property::P).known || !temp.known)
      return refuse(ErrorCode::LinkLost,
                    fmt::format("{} does not report its position and heat", name(finger_)));
    if (temp.value >= config_.limit_c)
      return refuse(ErrorCode::DeviceFault, fmt::format("{} has {} C (limit {:.0f}): it has to cool first",
                                                        name(finger_), temp.value, config_.limit_c));
    start_ = position();
    const bool gauge = reported(Property::Role).known && (reported(Property::Role).value & kRoleStrain) != 0;
    if (gauge && reported(Property::Sg).known) strain_start_ = reported(Property::Sg).value;
    if (const PuckScale* scale = calibration_.of(reported(Property::Sn).value);
        scale && reported(Property::Sn).known) {
      strain_scale_ = scale->strain_scale;
      if (scale->torque_points > 0) units_per_nm_ = scale->torque_units_per_nm;
    }
    return {};
  }

  Result<> check_target() {
    double target_rad = motion_.value;
    if (motion_.kind == Kind::Step) target_rad += start_ / kFingerCounts_rad;
    if (motion_.kind == Kind::To || motion_.kind == Kind::Step) {
      if (!(target_rad >= 0.0 && target_rad <= kMaxFinger_rad))
        return refuse(ErrorCode::LimitExceeded,
                      fmt::format("{} would stand at {:.1f} deg, expected 0 to {:.0f}", name(finger_),
                                  rad_to_deg(target_rad), rad_to_deg(kMaxFinger_rad)));
      target_ = static_cast<std::int32_t>(std::lround(target_rad * kFingerCounts_rad));
    } else {
      target_ = motion_.value > 0.0 ? kClosedCounts - kMargin : kMargin;
      if (at_end())
        return refuse(ErrorCode::LimitExceeded, fmt::format("{} is at that end already", name(finger_)));
    }
    if (opens() && closed_ >= 2 && !motion_.although_closed)
      return refuse(ErrorCode::NotReady,
                    "fingers are closed and may hold something, which would fall: support it, and say --yes");
    return {};
  }

  /// A closed finger may begin under load: as it opens, its gauge falls without meeting anything.
  [[nodiscard]] bool is_relieved() const {
    return opens() && start_ > kClosedFrom && start_ - position() < kRelief;
  }

  [[nodiscard]] bool at_end() const {
    return motion_.value > 0.0 ? position() >= target_ : position() <= target_;
  }

  [[nodiscard]] std::int32_t units(double nm) const {
    return static_cast<std::int32_t>(
        std::clamp(nm * units_per_nm_, config_.min_torque_units, config_.move_torque_units));
  }

  Result<> begin() {
    const double limit_nm = motion_.kind == Kind::Torque ? std::abs(motion_.value) : motion_.torque_nm;
    int strain_limit = 0;
    if (strain_start_ && !opens())
      strain_limit = std::min(strain_counts(*strain_start_, limit_nm / strain_scale_).value_or(kStrainMost),
                              kStrainMost);
    // a puck would end these by itself where the finger rests; here the program does
    const bool on_time = motion_.kind == Kind::Torque || motion_.kind == Kind::Velocity;
    link_.set(finger_, Property::Mode, kModeIdle, true);
    link_.set(finger_, Property::Mt, units(limit_nm), true);
    link_.set(finger_, Property::Tstop, on_time ? 0 : static_cast<std::int32_t>(config_.stopped_ms), true);
    if (strain_start_) link_.set(finger_, Property::Hsg, strain_limit, true);
    switch (motion_.kind) {
      case Kind::To:
      case Kind::Step:
        link_.set(finger_, Property::E, target_, true);
        break;
      case Kind::Velocity:
        link_.set(finger_, Property::V,
                  static_cast<std::int32_t>(std::lround(1e-3 * motion_.value * kFingerCounts_rad)), false);
        break;
      case Kind::Torque:
        link_.set(finger_, Property::T, torque_units(), false);
        break;
    }
    const int mode = motion_.kind == Kind::Velocity ? kModeVelocity : on_time ? kModeTorque : kModeTrapezoid;
    link_.set(finger_, Property::Mode, mode, false);
    const bool through = wait(kSettings_s, [&] { return !link_.busy(finger_); });
    if (const auto refused = link_.take_refusal(finger_))
      return refuse(ErrorCode::DeviceFault,
                    fmt::format("{} does not take {}", name(finger_), property_info(*refused).name));
    if (!through) return refuse(ErrorCode::LinkLost, "the settings did not get through");
    return {};
  }

  [[nodiscard]] std::int32_t torque_units() const {
    return motion_.value > 0.0 ? units(motion_.value) : -units(-motion_.value);
  }

  void watch(Timestamp began) {
    Timestamp moved_at = began, renewed_at = began;
    std::int32_t last = start_;
    const bool timed = motion_.kind == Kind::Velocity || motion_.kind == Kind::Torque;
    const double limit_s = timed ? motion_.for_s : config_.move_s;
    const double limit_nm =
        kOverTorque * (motion_.kind == Kind::Torque ? std::abs(motion_.value) : motion_.torque_nm);
    const auto ended = [&](std::string how, bool as_asked) {
      end_.how = std::move(how);
      end_.as_asked = as_asked;
      return true;
    };
    const bool by_itself = wait(limit_s, [&] {
      const Timestamp now = clock_.now();
      for (const Property p : {Property::P, Property::Mode})
        if (!link_.pending(finger_, p)) link_.ask(finger_, p);
      if (strain_start_ && !link_.pending(finger_, Property::Sg)) link_.ask(finger_, Property::Sg);
      if (motion_.kind == Kind::Torque && now - renewed_at >= kRenewTorque && !link_.busy(finger_)) {
        link_.set(finger_, Property::T, torque_units(), false);
        renewed_at = now;
      }
      if (interrupted_()) return ended("interrupted: it stays where it is", false);
      if (link_.silent(finger_)) return ended(fmt::format("{} stopped answering", name(finger_)), false);
      if (strain_start_) {
        if (is_relieved()) strain_start_ = std::min(*strain_start_, reported(Property::Sg).value);
        const double nm =
            strain_scale_ * (strain_nm(reported(Property::Sg).value) - strain_nm(*strain_start_));
        end_.max_torque_nm = std::fmax(end_.max_torque_nm, nm);
        if (std::abs(nm) > limit_nm) return ended(fmt::format("it measures {:.2f} N m: enough", nm), timed);
      }
      if (std::abs(position() - last) > kStill) {
        last = position();
        moved_at = now;
      }
      if (timed && at_end()) return ended("it is at the end of its range", true);
      const Reported& mode = reported(Property::Mode);
      const bool idle = mode.known && mode.asked_at > began + kSettles && mode.value == kModeIdle;
      const bool still = now - moved_at > duration_of(config_.still_s) && motion_.kind != Kind::Torque;
      if (!idle && !still) return false;
      if (!timed && std::abs(position() - target_) <= kNear) return ended("it has arrived", true);
      return ended("it was stopped by what it met", false);
    });
    if (by_itself) return;
    (void)ended(timed ? "its time is over" : "it did not arrive in time", timed);
  }

  void rest() {
    link_.drop_settings(finger_);
    link_.set(finger_, Property::Mode, kModeIdle, true);
    link_.set(finger_, Property::Tstop, static_cast<std::int32_t>(config_.stopped_ms), true);
    if (strain_start_) link_.set(finger_, Property::Hsg, 0, true);
    const Timestamp set_at = clock_.now();
    (void)wait(kSettings_s, [&] { return !link_.busy(finger_) || link_.silent(finger_); });
    link_.ask(finger_, Property::Mode);
    link_.ask(finger_, Property::P);
    (void)wait(kAnswer_s, [&] {
      return !link_.pending(finger_, Property::Mode) && !link_.pending(finger_, Property::P);
    });
    const Reported& mode = reported(Property::Mode);
    end_.rests = mode.known && mode.asked_at >= set_at && mode.value == kModeIdle;
  }

  const Clock& clock_;
  const BarrettHandConfig& config_;
  const FingerMotion& motion_;
  const Puck finger_;
  const std::function<bool()>& interrupted_;
  PuckLink link_;
  FingerMotionEnd end_;
  std::int32_t start_ = 0, target_ = 0;
  std::optional<std::int32_t> strain_start_;
  HandCalibration calibration_;
  double strain_scale_ = 1.0;  // true torque over that of the maker's curve
  double units_per_nm_;
  int closed_ = 0;
};

}  // namespace

Result<FingerMotionEnd> move_finger(CanBus& bus, const Clock& clock, const BarrettHandConfig& config,
                                    const FingerMotion& motion, const std::function<bool()>& interrupted) {
  if (auto opened = bus.open(); !opened) return tl::unexpected(opened.error());
  return Mover(bus, clock, config, motion, interrupted).run();
}

}  // namespace colift::hal
