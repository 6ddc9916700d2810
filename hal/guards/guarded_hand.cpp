#include "hal/guards/guarded_hand.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <optional>

namespace colift::hal {

namespace {

// the BH8-282's ranges, and a little for the play of its gears
constexpr double kPlay_rad = 0.1;
constexpr double kMostFinger_rad = 2.4435;  // 140 deg
constexpr double kMostOuter_rad = 1.6;  // a third of the inner joint's, and the breakaway's further closing
constexpr double kMostSpread_rad = std::numbers::pi;
constexpr double kMostTorque_nm = 100.0;  // at a fingertip; beyond it a strain gauge talks nonsense
constexpr double kMostForce_n = 1000.0;

bool within(double value, double low, double high) {
  return value >= low && value <= high;  // false for NaN
}

}  // namespace

struct GuardedHand::Impl {
  std::unique_ptr<Hand> inner;
  HandGuardConfig config;
  const Clock* clock = nullptr;
  std::optional<Timestamp> newest;
  bool closed = false;  ///< close() was asked for, and release() was not asked for since.
  std::uint64_t rejected = 0;
  std::string last_error;

  tl::unexpected<Error> reject(ErrorCode code, const char* where, std::string detail) {
    ++rejected;
    last_error = fmt::format("{}: {}", where, detail);
    return failure(code, where, std::move(detail));
  }

  static std::optional<std::string> implausible(const HandState& s) {
    for (std::size_t f = 0; f < kFingers; ++f) {
      if (!within(s.finger_rad[f], -kPlay_rad, kMostFinger_rad + kPlay_rad))
        return fmt::format("F{} is measured at {:.3f} rad (0 to {:.3f})", f + 1, s.finger_rad[f],
                           kMostFinger_rad);
      if (!within(s.outer_rad[f], -kPlay_rad, kMostOuter_rad + kPlay_rad))
        return fmt::format("outer joint of F{} is measured at {:.3f} rad (0 to {:.3f})", f + 1,
                           s.outer_rad[f], kMostOuter_rad);
      if (!std::isnan(s.torque_nm[f]) && std::abs(s.torque_nm[f]) > kMostTorque_nm)
        return fmt::format("torque of F{} is measured at {:.1f} N m", f + 1, s.torque_nm[f]);
      if (!std::isnan(s.tip_force_n[f]) && std::abs(s.tip_force_n[f]) > kMostForce_n)
        return fmt::format("tip force of F{} is measured at {:.1f} N", f + 1, s.tip_force_n[f]);
    }
    if (!within(s.spread_rad, -kPlay_rad, kMostSpread_rad + kPlay_rad))
      return fmt::format("the spread is measured at {:.3f} rad (0 to {:.3f})", s.spread_rad, kMostSpread_rad);
    return std::nullopt;
  }
};

GuardedHand::GuardedHand(std::unique_ptr<Hand> inner, const HandGuardConfig& config, const Clock* clock)
    : impl_(std::make_unique<Impl>()) {
  impl_->inner = std::move(inner);
  impl_->config = config;
  impl_->clock = clock;
}

GuardedHand::~GuardedHand() = default;

Result<> GuardedHand::configure() {
  impl_->newest.reset();
  return impl_->inner->configure();
}

Result<> GuardedHand::activate() {
  return impl_->inner->activate();
}

void GuardedHand::deactivate() noexcept {
  impl_->inner->deactivate();
}

DeviceHealth GuardedHand::health() const {
  DeviceHealth h = impl_->inner->health();
  h.rejected += impl_->rejected;
  if (!impl_->last_error.empty()) h.last_error = impl_->last_error;
  return h;
}

Result<HandState> GuardedHand::state() {
  Impl& g = *impl_;
  constexpr const char* kWhere = "hand.state";
  auto state = g.inner->state();
  if (!state) return state;
  if (const auto why = Impl::implausible(*state)) return g.reject(ErrorCode::BadReply, kWhere, *why);
  if (g.newest && state->measured_at < *g.newest)
    return g.reject(ErrorCode::BadReply, kWhere,
                    fmt::format("a state from {:.1f} ms before the last one",
                                1e3 * seconds(*g.newest - state->measured_at)));
  if (g.clock) {
    const double age = seconds(g.clock->now() - state->measured_at);
    if (age > g.config.stale_s)
      return g.reject(
          ErrorCode::Timeout, kWhere,
          fmt::format("the newest state is {:.0f} ms old (limit {:.0f})", 1e3 * age, 1e3 * g.config.stale_s));
  }
  g.newest = state->measured_at;
  return state;
}

Result<> GuardedHand::preshape(double spread_rad) {
  Impl& g = *impl_;
  constexpr const char* kWhere = "hand.preshape";
  if (!within(spread_rad, 0.0, kMostSpread_rad))
    return g.reject(ErrorCode::LimitExceeded, kWhere,
                    fmt::format("a spread of {:.3f} rad (0 to {:.3f})", spread_rad, kMostSpread_rad));
  if (g.closed)
    return g.reject(ErrorCode::NotReady, kWhere, "the hand was closed and not released; release() opens it");
  const auto now = state();
  if (!now)
    return g.reject(now.error().code, kWhere,
                    "whether the hand holds something is not known: " + now.error().detail);
  if (now->held) return g.reject(ErrorCode::NotReady, kWhere, "the hand holds something; release() opens it");
  return g.inner->preshape(spread_rad);
}

Result<> GuardedHand::close(double torque_nm) {
  Impl& g = *impl_;
  if (!(torque_nm > 0.0 && torque_nm <= g.config.max_torque_nm))
    return g.reject(ErrorCode::LimitExceeded, "hand.close",
                    fmt::format("a torque of {:.3f} N m (more than 0, at most {:.3f})", torque_nm,
                                g.config.max_torque_nm));
  g.closed = true;  // also when the call fails: nobody knows how far it came
  return g.inner->close(torque_nm);
}

Result<> GuardedHand::release() {
  auto done = impl_->inner->release();
  if (done) impl_->closed = false;
  return done;
}

std::vector<std::string> GuardedHand::realtime() const {
  return impl_->inner->realtime();
}

void GuardedHand::stop() noexcept {
  impl_->inner->stop();
}

}  // namespace colift::hal
