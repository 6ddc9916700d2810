#include "sim_hal/judge/contact_log.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "sim_hal/judge/commanded_energy.hpp"
#include "sim_hal/judge/force_limits.hpp"

namespace colift::sim_hal {
namespace {

constexpr double kTick_s = 0.001;
constexpr double kPause_s = 0.05;     // without contact for so long: another touch
constexpr double kFree_s = 0.01;      // without contact for so long: not pressed without a pause
constexpr double kTransient_s = 0.5;  // ISO/TS 15066: what lasts longer is quasi-static
constexpr double kPressed_n = 5.0;    // from that on two sides clamp
constexpr double kOpposed = -0.5;     // cosine between the pushes of two sides
constexpr double kHand_m = 0.25;      // around the palm: fingers reach that far
constexpr double kAtRest_m_s = 0.02;  // a surface that comes no faster came not

bool opposes(const BodyContact& a, const BodyContact& b) {
  return a.person == b.person && a.region == b.region && a.left == b.left && b.force_n > kPressed_n &&
         a.force_n > kPressed_n && a.force_W.normalized().dot(b.force_W.normalized()) < kOpposed;
}

}  // namespace

void ContactLog::tick(double t_s, const std::vector<BodyContact>& contacts, const RobotDoes& robot) {
  for (const BodyContact& c : contacts) {
    if (c.by == BodyContact::By::Static) continue;
    const bool opposed =
        std::any_of(contacts.begin(), contacts.end(), [&](const BodyContact& o) { return opposes(c, o); });
    add(t_s, c, opposed, robot);
  }
}

void ContactLog::add(double t_s, const BodyContact& c, bool opposed, const RobotDoes& robot) {
  const auto same = std::find_if(touches_.rbegin(), touches_.rend(), [&](const Touch& t) {
    return t.judged.person == c.person && t.region == c.region && t.left == c.left && t.by == c.by &&
           t_s - t.last_s < kPause_s;
  });
  const bool is_new = same == touches_.rend();
  if (is_new) {
    Touch touch;
    touch.judged.t_s = touch.first_s = touch.pressed_s = touch.last_s = t_s;
    touch.judged.region = to_string(c.region);
    touch.judged.by = c.by == BodyContact::By::Robot ? "robot" : "object";
    touch.judged.person = c.person;
    touch.judged.closing_m_s = c.closing_m_s;
    touch.by = c.by;
    touch.motion = robot.motion;
    touch.stood = robot.stood;
    touch.region = c.region;
    touch.left = c.left;
    touches_.push_back(touch);
  }
  Touch& touch = is_new ? touches_.back() : *same;
  const bool new_tick = t_s > touch.last_s || touch.first_s == t_s;
  // a hand that bounces between fingers is hit again and again, and not held
  if (t_s - touch.last_s > kFree_s) touch.pressed_s = t_s;
  touch.last_s = t_s;
  const bool lasts = t_s - touch.pressed_s > kTransient_s && c.force_n > kPressed_n;
  if ((opposed || lasts) && new_tick) touch.judged.clamped_s += kTick_s;
  double& peak = opposed || lasts ? touch.clamped_n : touch.transient_n;
  peak = std::max(peak, c.force_n);
  if ((opposed || lasts) && t_s - touch.first_s > kTransient_s)
    touch.judged.kept_n = std::max(touch.judged.kept_n, c.force_n);
  touch.gripped |=
      c.by == BodyContact::By::Robot && robot.closes_at_W && (c.at_W - *robot.closes_at_W).norm() < kHand_m;
  if (c.by == BodyContact::By::Robot) robot_peak_n_ = std::max(robot_peak_n_, c.force_n);
  // until the peak: what springs back afterwards came not towards him
  if (c.force_n >= touch.judged.force_n) {
    touch.peak_motion = robot.motion;
    touch.judged.robot_m_s = std::max(touch.judged.robot_m_s, c.other_m_s);
    touch.judged.commanded_j = std::max(touch.judged.commanded_j, robot.commanded_j);
  }
  touch.judged.force_n = std::max(touch.judged.force_n, c.force_n);
}

void ContactLog::add_to(Verdict& verdict) const {
  for (const Touch& touch : touches_) {
    const ForceLimit limit = force_limit(touch.region);
    JudgedContact judged = touch.judged;
    const bool clamped_is_worse =
        touch.clamped_n / limit.quasi_static_n >= touch.transient_n / limit.transient_n;
    judged.limit_n = clamped_is_worse ? limit.quasi_static_n : limit.transient_n;
    const double counts_n = judged.counts_n = clamped_is_worse ? touch.clamped_n : touch.transient_n;
    // who runs into a robot that has long been at rest is hurt by nothing that a program does, nor is he by
    // what swings back from his own push, as long as no command puts energy into it: all of it was his. An
    // object that is lowered onto him needs no energy of any command: of what the robot holds that is said
    // only where the robot stood. What keeps him pressed or clamped is the robot's, however that began, and
    // so is what closing fingers do
    const bool rested = touch.motion == RobotMotion::AtRest ||
                        (touch.motion == RobotMotion::Pushed && touch.peak_motion == RobotMotion::AtRest);
    const bool came_not = rested && judged.robot_m_s < kAtRest_m_s;
    const bool pushed = touch.by == BodyContact::By::Robot
                            ? touch.motion != RobotMotion::Driven && touch.peak_motion == RobotMotion::Pushed
                            : touch.stood && touch.peak_motion != RobotMotion::Driven;
    const bool gives_way = pushed && judged.commanded_j <= kGivesWay_j;
    judged.his_own = (came_not || gives_way) && !touch.gripped && judged.kept_n <= limit.quasi_static_n;
    if (counts_n > judged.limit_n && !judged.his_own)
      verdict.breaches.push_back(fmt::format("{}: {:.0f} N {} by the {} at {:.3f} s (limit {:.0f} N)",
                                             judged.region, counts_n, clamped_is_worse ? "clamped" : "hit",
                                             judged.by, judged.t_s, judged.limit_n));
    verdict.contacts.push_back(std::move(judged));
  }
}

}  // namespace colift::sim_hal
