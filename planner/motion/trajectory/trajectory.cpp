#include "planner/motion/trajectory/trajectory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "planner/motion/trajectory/trajectory_maker.hpp"

namespace colift::planner {

using hal::JointVector;

JointSample Trajectory::after(const Piece& piece, double t) {
  const JointSample& at = piece.at;
  const JointVector& jerk = piece.jerk_rad_s3;
  JointSample out;
  out.q_rad = at.q_rad + t * (at.dq_rad_s + t * (0.5 * at.ddq_rad_s2 + (t / 6.0) * jerk));
  out.dq_rad_s = at.dq_rad_s + t * (at.ddq_rad_s2 + (0.5 * t) * jerk);
  out.ddq_rad_s2 = at.ddq_rad_s2 + t * jerk;
  return out;
}

JointSample Trajectory::sample(double t_s) const {
  if (pieces_.empty() || !(t_s > 0.0)) return {start_, JointVector::Zero(), JointVector::Zero()};
  if (t_s >= duration_s_) return {goal_, JointVector::Zero(), JointVector::Zero()};
  const auto next = std::upper_bound(pieces_.begin(), pieces_.end(), t_s,
                                     [](double t, const Piece& piece) { return t < piece.start_s; });
  const Piece& piece = *(next - 1);
  return after(piece, t_s - piece.start_s);
}

Trajectory Trajectory::reversed() const {
  Trajectory out;
  out.duration_s_ = duration_s_;
  out.start_ = goal_;
  out.goal_ = start_;
  out.pieces_.reserve(pieces_.size());
  double end_s = duration_s_;
  for (auto piece = pieces_.rbegin(); piece != pieces_.rend(); ++piece) {
    Piece back;
    back.start_s = duration_s_ - end_s;
    back.at = after(*piece, end_s - piece->start_s);
    back.at.dq_rad_s = -back.at.dq_rad_s;
    back.jerk_rad_s3 = -piece->jerk_rad_s3;
    out.pieces_.push_back(back);
    end_s = piece->start_s;
  }
  return out;
}

TrajectoryMaker::TrajectoryMaker(const JointVector& start) {
  made_.start_ = start;
}

void TrajectoryMaker::append(double duration_s, const JointSample& at, const JointVector& jerk_rad_s3) {
  if (!(duration_s > 0.0)) return;
  made_.pieces_.push_back({made_.duration_s_, at, jerk_rad_s3});
  made_.duration_s_ += duration_s;
}

JointSample TrajectoryMaker::end() const {
  if (made_.pieces_.empty()) return {made_.start_, JointVector::Zero(), JointVector::Zero()};
  const auto& last = made_.pieces_.back();
  return Trajectory::after(last, made_.duration_s_ - last.start_s);
}

double TrajectoryMaker::stretch(const MotionLimits& limits) const {
  double velocity = 0.0, acceleration = 0.0, jerk = 0.0;
  for (std::size_t i = 0; i < made_.pieces_.size(); ++i) {
    const auto& piece = made_.pieces_[i];
    const double duration =
        (i + 1 < made_.pieces_.size() ? made_.pieces_[i + 1].start_s : made_.duration_s_) - piece.start_s;
    const JointSample end = Trajectory::after(piece, duration);
    for (int j = 0; j < hal::kArmJoints; ++j) {
      const double a = piece.at.ddq_rad_s2[j], b = piece.jerk_rad_s3[j];
      double fastest = std::max(std::abs(piece.at.dq_rad_s[j]), std::abs(end.dq_rad_s[j]));
      // the speed is a parabola: it may be highest where the acceleration passes zero
      if (a * end.ddq_rad_s2[j] < 0.0)
        fastest = std::max(fastest, std::abs(piece.at.dq_rad_s[j] - 0.5 * a * a / b));
      velocity = std::max(velocity, fastest / limits.velocity_rad_s[j]);
      acceleration = std::max(
          acceleration, std::max(std::abs(a), std::abs(end.ddq_rad_s2[j])) / limits.acceleration_rad_s2[j]);
      jerk = std::max(jerk, std::abs(b) / limits.jerk_rad_s3[j]);
    }
  }
  return std::max({velocity, std::sqrt(acceleration), std::cbrt(jerk)});
}

void TrajectoryMaker::scale_time(double factor) {
  for (auto& piece : made_.pieces_) {
    piece.start_s *= factor;
    piece.at.dq_rad_s /= factor;
    piece.at.ddq_rad_s2 /= factor * factor;
    piece.jerk_rad_s3 /= factor * factor * factor;
  }
  made_.duration_s_ *= factor;
}

Trajectory TrajectoryMaker::finish(const JointVector& goal) && {
  made_.goal_ = goal;
  // a way of no length is still a way
  if (made_.pieces_.empty())
    made_.pieces_.push_back(
        {0.0, {made_.start_, JointVector::Zero(), JointVector::Zero()}, JointVector::Zero()});
  return std::move(made_);
}

hal::Result<> check_path(std::span<const JointVector> path, const MotionLimits& limits) {
  const auto refuse = [](std::string text) {
    return hal::failure(hal::ErrorCode::BadInput, "trajectory", std::move(text));
  };
  if (path.empty()) return refuse("the path has no waypoint, expected at least one");
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (!path[i].allFinite()) return refuse(fmt::format("waypoint {} is not finite", i));
  }
  const auto positive = [](const JointVector& v) { return v.allFinite() && (v.array() > 0.0).all(); };
  if (!positive(limits.velocity_rad_s) || !positive(limits.acceleration_rad_s2) ||
      !positive(limits.jerk_rad_s3)) {
    return refuse("a limit of velocity, acceleration or jerk is not more than 0");
  }
  return {};
}

}  // namespace colift::planner
