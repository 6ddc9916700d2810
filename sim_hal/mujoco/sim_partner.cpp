#include "sim_hal/mujoco/sim_partner.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim_hal/synthetic/hash_random.hpp"

namespace colift::sim_hal {
namespace {

constexpr double kTick_s = 0.001;
constexpr double kUp_n_m = 7000.0, kSide_n_m = 1500.0, kDamping_ns_m = 150.0, kStrength_n = 250.0;
constexpr double kTurn_nm_rad = 8.0, kTurnDamping = 0.4, kTurnStrength_nm = 1.5;
constexpr double kFastest_m_s = 0.25, kFollow_per_s = 20.0, kLevel_per_s = 0.5, kMostLevelled_m = 0.02;
constexpr double kSeenTilt_rad = 0.009;                    // half a degree: a smaller tilt nobody sees
constexpr double kOnGround_m = 0.001, kRelax_per_s = 1.0;  // what rests on the ground he does not strain at
constexpr double kOffGround_m = 0.01;  // below that he lets it down instead of levelling it
constexpr double kRegrasp_s = 1.0, kSeenBefore_s = 0.6;
constexpr double kLeadAfter_s = 1.0, kLead_s = 2.0;
constexpr double kTremor_m = 0.0005;
constexpr std::uint64_t kTremorStream = 0x7e3;

double min_jerk(double x) {
  const double t = std::clamp(x, 0.0, 1.0);
  return t * t * t * (10.0 + t * (-15.0 + 6.0 * t));
}

bool earlier(const PartnerScriptEvent& a, const PartnerScriptEvent& b) {
  return a.at_s < b.at_s;
}

/// Where an event goes to; `away` is from the object's middle.
Vec3 direction_of(const PartnerScriptEvent& event, Vec3 away) {
  away.z() = 0.0;
  const Vec3 direction = event.direction.value_or(away);
  return direction.norm() > 0.0 ? Vec3(direction.normalized()) : Vec3(Vec3::Zero());
}

Vec3 at_most(const Vec3& v, double length) {
  const double n = v.norm();
  return n > length ? Vec3(v * (length / n)) : v;
}

}  // namespace

SimPartner::SimPartner(const ScenarioPartner& partner, const ScenarioTask& task, std::uint64_t seed)
    : partner_(partner), task_(task) {
  Draws draws(seed, kTremorStream);
  for (std::size_t i = 0; i < 3; ++i) {
    tremor_hz_[i] = draws.between(8.0, 10.0);
    tremor_rad_[i] = draws.between(0.0, 2.0 * std::numbers::pi);
  }
  if (partner.kind == "none") return;
  holds_.push_back({partner.grasp, partner.arrives_s, std::nullopt});
  for (const PartnerScriptEvent& event : partner.events)
    (event.in_state.empty() ? coming_ : waiting_).push_back(event);
  std::stable_sort(coming_.begin(), coming_.end(), earlier);
}

void SimPartner::task_state(const std::string& name, double t_s) {
  for (auto event = waiting_.begin(); event != waiting_.end();) {
    if (event->in_state != name) {
      ++event;
      continue;
    }
    event->at_s += t_s;
    coming_.push_back(std::move(*event));
    event = waiting_.erase(event);
  }
  std::stable_sort(coming_.begin(), coming_.end(), earlier);
}

void SimPartner::do_events(double t_s) {
  if (holds_.empty()) return;
  std::size_t done = 0;
  for (; done < coming_.size() && coming_[done].at_s <= t_s; ++done) {
    const PartnerScriptEvent& event = coming_[done];
    if (event.action == "confirm-lower") {
      lower_confirmed_ = true;
      continue;
    }
    if (event.action == "confirm-continue") {
      continue_confirmed_ = true;
      continue;
    }
    if (event.action == "stumble") {
      stumbles_ = event;
      continue;
    }
    if (event.action == "sway") {
      sways_ = event;
      continue;
    }
    if (event.action == "second-hand") {
      second_ = event;
      second_start_W_.reset();
      continue;
    }
    second_.reset();
    PartnerHold& now = holds_.back();
    if (!now.until_s) now.until_s = std::max(event.at_s, now.from_s);
    if (event.action == "steps-aside") now.leaves = true;
    if (event.action == "move" && event.to)
      holds_.push_back({*event.to, event.at_s + kRegrasp_s, std::nullopt});
  }
  coming_.erase(coming_.begin(), coming_.begin() + static_cast<std::ptrdiff_t>(done));
}

std::optional<Vec3> SimPartner::second_hand(double t_s) const {
  if (!second_ || !holding(t_s)) return std::nullopt;
  return second_->to;
}

// a pull at the hand that holds, beyond what he means to do
Vec3 SimPartner::stumble_n(const PartnerView& view, const Vec3& at_W) const {
  if (!stumbles_ || view.t_s >= stumbles_->at_s + stumbles_->for_s) return Vec3::Zero();
  return stumbles_->force_n * direction_of(*stumbles_, at_W - view.X_WT.translation());
}

Vec3 SimPartner::sway_m(const PartnerView& view, const Vec3& at_W) const {
  if (!sways_ || view.t_s >= sways_->at_s + sways_->for_s) return Vec3::Zero();
  const double there = std::sin(std::numbers::pi * (view.t_s - sways_->at_s) / sways_->for_s);
  return there * there * sways_->by_m * direction_of(*sways_, at_W - view.X_WT.translation());
}

// as stiff as the first one, and with it
void SimPartner::add_second_hand(const PartnerView& view, Action& action) {
  if (!second_ || !second_->to) return;
  const Vec3 at_W = view.X_WT * *second_->to;
  if (!second_start_W_) second_start_W_ = at_W - Vec3(0.0, 0.0, grip_.request_m);
  const Vec3 request_W = *second_start_W_ + Vec3(0.0, 0.0, grip_.request_m);
  const Vec3 v_W = view.v_W + view.w_W.cross(at_W - view.X_WT.translation());
  const Vec3 stiffness(kSide_n_m, kSide_n_m, kUp_n_m);
  const Vec3 force_W = at_most(stiffness.cwiseProduct(request_W - at_W) - kDamping_ns_m * v_W, kStrength_n);
  action.torque_W += (at_W - action.at_W).cross(force_W);
  action.force_W += force_W;
}

bool SimPartner::ask(const Vec3& grasp_T, double t_s) {
  if (!partner_.obliging || partner_.kind == "none" || partner_.kind == "support") return false;
  coming_.clear();
  waiting_.clear();
  while (holds_.size() > 1 && holds_.back().from_s > t_s) holds_.pop_back();
  PartnerHold& now = holds_.back();
  // who has let go already hears it all the same
  const double free_s = std::max(t_s + kHears_s, now.from_s);
  if (!now.until_s || *now.until_s > t_s) now.until_s = free_s;
  holds_.push_back({grasp_T, free_s + kRegrasp_s, std::nullopt});
  return true;
}

std::optional<std::size_t> SimPartner::holding(double t_s) const {
  for (std::size_t i = 0; i < holds_.size(); ++i) {
    if (t_s >= holds_[i].from_s && (!holds_[i].until_s || t_s < *holds_[i].until_s)) return i;
  }
  return std::nullopt;
}

const PartnerHold* SimPartner::hold_to_show(double t_s) const {
  const PartnerHold* shown = nullptr;
  for (const PartnerHold& hold : holds_) {
    if (!shown || t_s >= hold.from_s - kSeenBefore_s) shown = &hold;
  }
  return shown;
}

void SimPartner::take_hold(std::size_t hold, const PartnerView& view) {
  grip_ = {};
  grip_.hold = hold;
  grip_.start_W = view.X_WT * holds_[hold].grasp_T;
  grip_.R_WT = view.X_WT.linear();
}

// his own sag under the load tilts the object towards him: that he sees and takes out
void SimPartner::follow(const Seen& seen) {
  const double off_m = seen.robot_m - seen.own_m;
  const double measured_m = off_m - std::clamp(off_m, -seen.unseen_m, seen.unseen_m);
  grip_.levelled_m =
      std::clamp(grip_.levelled_m + kLevel_per_s * kTick_s * measured_m, -kMostLevelled_m, kMostLevelled_m);
  const double up = std::clamp(seen.robot_m / kOffGround_m, 0.0, 1.0);
  const double goal = std::max(seen.robot_m + up * grip_.levelled_m, 0.0);
  const double speed = kFollow_per_s * (goal - grip_.request_m);
  grip_.request_m += kTick_s * std::clamp(speed, -kFastest_m_s, kFastest_m_s);
}

void SimPartner::lead(const PartnerView& view, const Seen& now) {
  if (!robot_T_) return;
  const double t = view.t_s - locked_at_s_ - kLeadAfter_s;
  const double up = min_jerk(t / kLead_s) - min_jerk((t - kLead_s - task_.hold_s) / kLead_s);
  const double goal = task_.height * up;
  if (up > 0.0) {
    grip_.levelled_m = std::clamp(grip_.levelled_m + kLevel_per_s * kTick_s * (goal - now.own_m),
                                  -kMostLevelled_m, kMostLevelled_m);
  } else {
    grip_.levelled_m = 0.0;
  }
  grip_.request_m = goal + grip_.levelled_m;
}

Vec3 SimPartner::tremor(double t_s) const {
  Vec3 p;
  for (int i = 0; i < 3; ++i) {
    const auto a = static_cast<std::size_t>(i);
    p[i] = kTremor_m * std::sin(2.0 * std::numbers::pi * tremor_hz_[a] * t_s + tremor_rad_[a]);
  }
  return p;
}

std::optional<SimPartner::Action> SimPartner::tick(const PartnerView& view) {
  // a grip that is renewed in the air is no new start
  if (view.robot_T && view.robot_T != robot_T_ && grip_.request_m < kOnGround_m) {
    robot_T_ = view.robot_T;
    robot_z_m_ = (view.X_WT * *robot_T_).z();
    locked_at_s_ = view.t_s;
  }
  do_events(view.t_s);
  const auto holds = holding(view.t_s);
  if (!holds || partner_.kind == "support") {
    grip_.hold.reset();
    return std::nullopt;
  }
  if (grip_.hold != holds) {
    take_hold(*holds, view);
    past_.fill({});
  }
  const PartnerHold& hold = holds_[*holds];
  const Vec3 at_W = view.X_WT * hold.grasp_T;
  Seen now;
  if (robot_T_) {
    now.robot_m = (view.X_WT * *robot_T_).z() - robot_z_m_;
    now.unseen_m = kSeenTilt_rad * (*robot_T_ - hold.grasp_T).norm();
  }
  now.own_m = at_W.z() - grip_.start_W.z();
  Seen& seen = past_[tick_++ % past_.size()];
  if (partner_.kind == "leader") {
    lead(view, now);
  } else {
    follow(seen);
    if (seen.robot_m < kOnGround_m)
      grip_.start_W += kRelax_per_s * kTick_s * (at_W - grip_.start_W - Vec3(0.0, 0.0, grip_.request_m));
  }
  seen = now;

  Vec3 request_W = grip_.start_W + Vec3(0.0, 0.0, grip_.request_m) + tremor(view.t_s);
  if (sways_) request_W += sway_m(view, at_W);
  const Vec3 stiffness(kSide_n_m, kSide_n_m, kUp_n_m);
  const Vec3 v_W = view.v_W + view.w_W.cross(at_W - view.X_WT.translation());
  Action action;
  action.at_W = at_W;
  action.force_W = at_most(stiffness.cwiseProduct(request_W - at_W) - kDamping_ns_m * v_W, kStrength_n);
  const Eigen::AngleAxisd turned(view.X_WT.linear() * grip_.R_WT.transpose());
  action.torque_W =
      at_most(-kTurn_nm_rad * turned.angle() * turned.axis() - kTurnDamping * view.w_W, kTurnStrength_nm);
  if (stumbles_) action.force_W += stumble_n(view, at_W);
  add_second_hand(view, action);
  return action;
}

}  // namespace colift::sim_hal
