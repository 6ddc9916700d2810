#include <algorithm>
#include <cmath>

#include "planner/motion/trajectory/trajectory_maker.hpp"
#include "planner/motion/trajectory/trajectory_profile.hpp"

namespace colift::planner {
namespace {

using hal::JointVector;

/// Natural cubic spline through points: twice continuously differentiable.
class Curve {
 public:
  Curve(std::vector<double> at, std::vector<JointVector> points) : s_(std::move(at)), q_(std::move(points)) {
    const std::size_t n = s_.size();
    bend_.assign(n, JointVector::Zero());
    // tridiagonal system for the second derivatives, Thomas' algorithm
    std::vector<double> upper(n, 0.0);
    for (std::size_t i = 1; i + 1 < n; ++i) {
      const double h0 = s_[i] - s_[i - 1], h1 = s_[i + 1] - s_[i];
      const double pivot = 2.0 * (h0 + h1) - h0 * upper[i - 1];
      upper[i] = h1 / pivot;
      bend_[i] = (6.0 * ((q_[i + 1] - q_[i]) / h1 - (q_[i] - q_[i - 1]) / h0) - h0 * bend_[i - 1]) / pivot;
    }
    for (std::size_t i = n - 1; i-- > 1;) bend_[i] -= upper[i] * bend_[i + 1];
  }

  [[nodiscard]] double length() const { return s_.back(); }

  [[nodiscard]] JointVector at(double s) const {
    const std::size_t i = interval(s);
    const double h = s_[i + 1] - s_[i], b = std::clamp((s - s_[i]) / h, 0.0, 1.0), a = 1.0 - b;
    return a * q_[i] + b * q_[i + 1] +
           (h * h / 6.0) * ((a * a * a - a) * bend_[i] + (b * b * b - b) * bend_[i + 1]);
  }

  [[nodiscard]] JointVector slope(double s) const {
    const std::size_t i = interval(s);
    const double h = s_[i + 1] - s_[i], b = std::clamp((s - s_[i]) / h, 0.0, 1.0), a = 1.0 - b;
    return (q_[i + 1] - q_[i]) / h +
           (h / 6.0) * ((1.0 - 3.0 * a * a) * bend_[i] + (3.0 * b * b - 1.0) * bend_[i + 1]);
  }

 private:
  [[nodiscard]] std::size_t interval(double s) const {
    const auto next = std::upper_bound(s_.begin() + 1, s_.end() - 1, s);
    return static_cast<std::size_t>(next - s_.begin()) - 1;
  }

  std::vector<double> s_;
  std::vector<JointVector> q_, bend_;
};

/// Way travelled at times 0, h, 2 h, ..., steps h.
std::vector<double> travelled(const SpeedProfile& profile, std::size_t steps) {
  std::vector<double> out(steps + 1, 0.0);
  const double h = profile.duration_s() / static_cast<double>(steps);
  double start_s = 0.0, s = 0.0, v = profile.start_velocity, a = 0.0;
  std::size_t k = 1;
  for (const auto& phase : profile.phases) {
    const double j = phase.jerk;
    const auto way = [&](double t) { return s + t * (v + t * (0.5 * a + t * j / 6.0)); };
    for (; k <= steps && static_cast<double>(k) * h <= start_s + phase.duration_s; ++k) {
      out[k] = way(static_cast<double>(k) * h - start_s);
    }
    const double t = phase.duration_s;
    s = way(t);
    v += t * (a + 0.5 * t * j);
    a += t * j;
    start_s += t;
  }
  for (; k <= steps; ++k) out[k] = s;
  return out;
}

/// Pieces of constant jerk through positions at times 0, h, 2 h, ..., with velocity and acceleration 0 at
/// both ends. For that the second and the last but one position are left free.
void append_through(TrajectoryMaker& maker, const std::vector<JointVector>& q, double h) {
  const std::size_t n = q.size() - 1;
  // Continuous velocity: ddq[i-1] + 4 ddq[i] + ddq[i+1] = 6 (q[i+1] - 2 q[i] + q[i-1]) / h^2. A free position
  // lies at q[0] + h^2 / 6 ddq[1], and likewise at the end, which moves that term to the left side: it makes
  // 6 of the 4 in its own row, and takes ddq[1] out of the next one.
  std::vector<JointVector> ddq(n + 1, JointVector::Zero());
  std::vector<double> upper(n + 1, 0.0);
  for (std::size_t i = 1; i < n; ++i) {
    const bool first = i == 1, last = i == n - 1;
    const JointVector& before = i <= 2 ? q[0] : q[i - 1];
    const JointVector& after = i + 2 >= n ? q[n] : q[i + 1];
    const JointVector bend = first  ? JointVector(q[2] - q[0])
                             : last ? JointVector(q[n - 2] - q[n])
                                    : JointVector(after - 2.0 * q[i] + before);
    const double to_previous = i == 2 ? 0.0 : 1.0, to_next = i == n - 2 ? 0.0 : 1.0;
    const double pivot = (first || last ? 6.0 : 4.0) - to_previous * upper[i - 1];
    upper[i] = to_next / pivot;
    ddq[i] = ((6.0 / (h * h)) * bend - to_previous * ddq[i - 1]) / pivot;
  }
  for (std::size_t i = n - 1; i-- > 1;) ddq[i] -= upper[i] * ddq[i + 1];

  JointSample state{q[0], JointVector::Zero(), JointVector::Zero()};
  for (std::size_t i = 0; i < n; ++i) {
    maker.append(h, state, (ddq[i + 1] - ddq[i]) / h);
    state = maker.end();
    // rounding does not add up
    state.ddq_rad_s2 = ddq[i + 1];
    if (i >= 1 && i + 3 <= n) state.q_rad = q[i + 1];
  }
}

}  // namespace

hal::Result<Trajectory> make_trajectory_along(std::span<const JointVector> path, const MotionLimits& limits,
                                              double at_least_s) {
  if (auto ok = check_path(path, limits); !ok) return tl::unexpected(ok.error());
  if (!(at_least_s >= 0.0 && std::isfinite(at_least_s))) {
    return hal::failure(hal::ErrorCode::BadInput, "trajectory", "the shortest duration is not 0 s or more");
  }
  std::vector<double> s;
  std::vector<JointVector> points;
  for (const JointVector& q : path) {
    const double step =
        points.empty() ? 0.0 : (q - points.back()).cwiseQuotient(limits.velocity_rad_s).norm();
    // nearer than that is the same point
    if (!points.empty() && step < 1e-9) continue;
    s.push_back(points.empty() ? 0.0 : s.back() + step);
    points.push_back(q);
  }
  TrajectoryMaker maker(path.front());
  if (points.size() < 2) return std::move(maker).finish(path.back());
  points.back() = path.back();

  // pieces of the trajectory: enough that each way point has several, few enough to stay quick
  constexpr std::size_t kStepsPerPoint = 4, kFewest = 100, kMost = 1000;
  const std::size_t steps = std::clamp(kStepsPerPoint * points.size(), kFewest, kMost);
  const Curve curve(std::move(s), std::move(points));
  JointVector steepest = JointVector::Constant(1e-300);
  for (std::size_t i = 0; i <= steps; ++i) {
    const double at = curve.length() * static_cast<double>(i) / static_cast<double>(steps);
    steepest = steepest.cwiseMax(curve.slope(at).cwiseAbs());
  }
  const SpeedProfile profile = fastest_profile(curve.length(), 0.0, 0.0,
                                               {limits.velocity_rad_s.cwiseQuotient(steepest).minCoeff(),
                                                limits.acceleration_rad_s2.cwiseQuotient(steepest).minCoeff(),
                                                limits.jerk_rad_s3.cwiseQuotient(steepest).minCoeff()});
  std::vector<JointVector> q;
  q.reserve(steps + 1);
  for (const double at : travelled(profile, steps)) q.push_back(curve.at(at));
  q.front() = path.front();
  q.back() = path.back();
  append_through(maker, q, profile.duration_s() / static_cast<double>(steps));
  maker.scale_time(std::max(maker.stretch(limits), at_least_s / profile.duration_s()));
  return std::move(maker).finish(path.back());
}

}  // namespace colift::planner
