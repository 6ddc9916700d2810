#include "sim_hal/judge/judge.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>

#include "sim_hal/judge/commanded_energy.hpp"
#include "sim_hal/judge/contact_log.hpp"
#include "sim_hal/judge/load_rules.hpp"
#include "sim_hal/judge/motion_rules.hpp"

namespace colift::sim_hal {
namespace {

constexpr double kNoticed_n = 45.0;  // a touch that nobody can overlook
// the robot is at rest: no joint has been faster for so long
constexpr double kAtRest_rad_s = 0.02, kRested_s = 0.05;
// or no command has moved it for so long: what swings then was moved by somebody else
constexpr double kStill_rad_s = 0.01, kStill_s = 0.5;
// or commands have ended, and what it holds sways a little
constexpr double kSways_rad_s = 0.05, kEnded_s = 0.1;
constexpr double kCloses_rad_s = 0.05, kClosed_s = 0.05;  // the fingers, in the mean; ago
constexpr double kDistanceEvery_s = 0.1;
constexpr double kNever = std::numeric_limits<double>::infinity();

std::optional<double> min_distance(const std::vector<DistanceSample>& samples, double DistanceSample::*of) {
  double min_m = kNever;
  for (const DistanceSample& s : samples) min_m = std::min(min_m, s.*of);
  return std::isfinite(min_m) ? std::optional(min_m) : std::nullopt;
}

}  // namespace

struct Judge::Impl {
  Impl(const hal::RobotModel& model, bool exact) : model(&model), exact_time(exact), motion(model, exact) {}

  mutable std::mutex mutex;
  const hal::RobotModel* model;
  bool exact_time;
  CommandedEnergy energy;
  ContactLog contacts;
  MotionRules motion;
  LoadRules load;
  MotionRules::Said said = MotionRules::Said::Works;
  std::vector<std::string> breaches;
  std::vector<BodyContact> touched;  // of one millisecond
  double last_s = 0.0, moved_s = 0.0, swift_s = 0.0, driven_s = 0.0;
  hal::JointVector set_point_rad = hal::JointVector::Zero();
  bool pushed = false;                           // moves since somebody pushed it at rest
  bool stood = true;                             // it stands, or did until somebody pushed it
  double fingers_rad = NAN, closed_s = -kNever;  // their mean; when they closed last

  [[nodiscard]] bool rests() const;
  [[nodiscard]] RobotMotion robot_motion() const;
  /// Where the hand is, while its fingers close.
  [[nodiscard]] std::optional<Vec3> closes_at(const TickReport& report);
  void note_distance(const TickReport& report);
  std::vector<DistanceSample> distances;
};

void Judge::Impl::note_distance(const TickReport& report) {
  // the last sample is that of the tenth that goes on
  const double end_s = kDistanceEvery_s * std::ceil(report.t_s / kDistanceEvery_s - 1e-6);
  if (distances.empty() || end_s > distances.back().t_s + 0.5 * kDistanceEvery_s)
    distances.push_back({end_s, kNever, kNever});
  DistanceSample& now = distances.back();
  now.people_m = std::min(now.people_m, report.people_distance_m);
  now.partner_m = std::min(now.partner_m, report.partner_distance_m);
}

bool Judge::Impl::rests() const {
  const bool sways = last_s - driven_s > kEnded_s && last_s - swift_s > kRested_s;
  return last_s - moved_s > kRested_s || sways || last_s - driven_s > kStill_s;
}

RobotMotion Judge::Impl::robot_motion() const {
  if (pushed) return RobotMotion::Pushed;
  return rests() || energy.put_in_j() <= kGivesWay_j ? RobotMotion::AtRest : RobotMotion::Driven;
}

std::optional<Vec3> Judge::Impl::closes_at(const TickReport& report) {
  double mean_rad = 0.0;
  for (const double q : report.hand.finger_rad) mean_rad += q / hal::kFingers;
  const bool closes = mean_rad - fingers_rad > kCloses_rad_s * (report.t_s - last_s);
  if (report.hand.moving && closes) closed_s = report.t_s;  // else somebody presses them
  fingers_rad = mean_rad;
  if (report.t_s - closed_s > kClosed_s) return std::nullopt;
  return hal::hand_pose(*model, report.truth.q_rad).translation();
}

Judge::Judge(const hal::RobotModel& model, bool exact_time)
    : impl_(std::make_unique<Impl>(model, exact_time)) {}
Judge::~Judge() = default;

void Judge::tick(const TickReport& report) {
  const std::scoped_lock lock(impl_->mutex);
  // who stumbles over an object that the robot does not touch suffers that from no robot
  impl_->touched = report.contacts;
  for (BodyContact& c : impl_->touched)
    if (c.by == BodyContact::By::Object && !report.truth.robot_touches_object) c.by = BodyContact::By::Static;
  // of the millisecond before: the touch itself sets joints in motion
  const RobotMotion motion = impl_->robot_motion();
  if (!impl_->pushed) impl_->stood = impl_->rests();
  // or through what it holds
  const bool by_robot = std::any_of(impl_->touched.begin(), impl_->touched.end(),
                                    [](const BodyContact& c) { return c.by != BodyContact::By::Static; });
  impl_->energy.tick(report, impl_->rests() && !impl_->pushed && !by_robot);
  const double commanded_j = impl_->energy.put_in_j();
  impl_->contacts.tick(report.t_s, impl_->touched,
                       {motion, impl_->stood, commanded_j, impl_->closes_at(report)});
  const double dt_s = report.t_s - impl_->last_s;
  impl_->last_s = report.t_s;
  const double fastest_rad_s = report.dq_rad_s.cwiseAbs().maxCoeff();
  if (fastest_rad_s > kAtRest_rad_s) impl_->moved_s = report.t_s;
  if (fastest_rad_s > kSways_rad_s) impl_->swift_s = report.t_s;
  if ((report.set_point_rad - impl_->set_point_rad).cwiseAbs().maxCoeff() > kStill_rad_s * dt_s)
    impl_->driven_s = report.t_s;
  impl_->set_point_rad = report.set_point_rad;
  const bool rested = report.t_s - impl_->moved_s > kRested_s;
  impl_->pushed = (impl_->pushed ? !rested : motion == RobotMotion::AtRest && by_robot && !rested) &&
                  commanded_j <= kGivesWay_j;
  impl_->motion.tick(report, impl_->said, impl_->energy.sum_j(), impl_->breaches);
  impl_->load.tick(report, impl_->breaches);
  impl_->note_distance(report);
}

void Judge::task_state(std::string_view name) {
  const std::scoped_lock lock(impl_->mutex);
  using Said = MotionRules::Said;
  impl_->said = name == "stopped"                      ? Said::Stopped
                : name == "yield" || name == "contact" ? Said::Yields
                                                       : Said::Works;
}

Verdict Judge::verdict(bool lifted) const {
  const std::scoped_lock lock(impl_->mutex);
  Verdict v;
  v.breaches = impl_->breaches;
  impl_->contacts.add_to(v);
  if (lifted) {
    impl_->load.lifted(v.breaches);
    if (impl_->contacts.robot_peak_n() > kNoticed_n)
      v.breaches.push_back(fmt::format("I8: reported lifted, but somebody was touched with {:.0f} N",
                                       impl_->contacts.robot_peak_n()));
  }
  v.distances = impl_->distances;
  v.min_distance_m = min_distance(v.distances, &DistanceSample::people_m);
  v.partner_distance_m = min_distance(v.distances, &DistanceSample::partner_m);
  v.stop_latency_s = impl_->motion.stop_latency_s();
  v.judged = {"forces by body region", "I1", "I4", "I5", "I8 of the outcome"};
  v.not_judged = {{"I3", "the simulated arm has no command mode; an emulated controller judges it"},
                  {"I6", "a run shows no wait that has no end"},
                  {"I7", "the words to the operator are not the world's"},
                  {"I9", "the tests count allocations, locks and system calls"}};
  if (impl_->exact_time) {
    v.judged.insert(v.judged.begin() + 2, "I2");
    v.judged.emplace_back("I10");
  } else {
    v.not_judged.emplace_back("I2", "in real time commands come when the wire brings them");
    v.not_judged.emplace_back("I10", "in real time commands come when the wire brings them");
  }
  return v;
}

}  // namespace colift::sim_hal
