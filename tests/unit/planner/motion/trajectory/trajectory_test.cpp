#include "planner/motion/trajectory/trajectory.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "planner/motion/joint_random.hpp"
#include "planner/motion/trajectory/joint_path.hpp"

using namespace colift;
using hal::JointVector;
using planner::JointPath;
using planner::MotionLimits;
using planner::Trajectory;

namespace {

constexpr double kStep_s = 0.001;

/// Most that the samples of a trajectory use of the limits; jerk by differences of the acceleration.
struct Used {
  double velocity = 0.0, acceleration = 0.0, jerk = 0.0;
};

Used used(const Trajectory& trajectory, const MotionLimits& limits) {
  Used most;
  auto last = trajectory.sample(0.0);
  for (double t = kStep_s;; t += kStep_s) {
    const auto now = trajectory.sample(t);
    const auto ratio = [](const JointVector& value, const JointVector& limit) {
      return value.cwiseAbs().cwiseQuotient(limit).maxCoeff();
    };
    most.velocity = std::max(most.velocity, ratio(now.dq_rad_s, limits.velocity_rad_s));
    most.acceleration = std::max(most.acceleration, ratio(now.ddq_rad_s2, limits.acceleration_rad_s2));
    most.jerk = std::max(most.jerk, ratio((now.ddq_rad_s2 - last.ddq_rad_s2) / kStep_s, limits.jerk_rad_s3));
    last = now;
    if (t > trajectory.duration_s() + 2 * kStep_s) return most;
  }
}

void check_within(const Trajectory& trajectory, const MotionLimits& limits) {
  const Used u = used(trajectory, limits);
  REQUIRE(u.velocity <= 1.0 + 1e-6);
  REQUIRE(u.acceleration <= 1.0 + 1e-6);
  REQUIRE(u.jerk <= 1.0 + 1e-6);
}

/// Positions and velocities are the integrals of velocities and accelerations: nothing jumps anywhere.
void check_continuous(const Trajectory& trajectory, const MotionLimits& limits) {
  const double jerk = limits.jerk_rad_s3.maxCoeff();
  auto last = trajectory.sample(-kStep_s);
  for (double t = 0.0; t < trajectory.duration_s() + 2 * kStep_s; t += kStep_s) {
    const auto now = trajectory.sample(t);
    const JointVector dq = 0.5 * kStep_s * (now.dq_rad_s + last.dq_rad_s);
    const JointVector ddq = 0.5 * kStep_s * (now.ddq_rad_s2 + last.ddq_rad_s2);
    REQUIRE((now.q_rad - last.q_rad - dq).cwiseAbs().maxCoeff() < jerk * std::pow(kStep_s, 3) + 1e-9);
    REQUIRE((now.dq_rad_s - last.dq_rad_s - ddq).cwiseAbs().maxCoeff() < jerk * std::pow(kStep_s, 2) + 1e-9);
    last = now;
  }
}

void check_ends(const Trajectory& trajectory, const JointVector& start, const JointVector& goal) {
  const double T = trajectory.duration_s();
  CHECK(trajectory.start() == start);
  CHECK(trajectory.goal() == goal);
  for (const double t : {-1.0, 0.0, 1e-9, T - 1e-9, T, T + 1.0}) {
    const auto s = trajectory.sample(t);
    REQUIRE((s.q_rad - (t < 0.5 * T ? start : goal)).norm() < 1e-9);
    REQUIRE(s.dq_rad_s.norm() < 1e-6);
    REQUIRE(s.ddq_rad_s2.norm() < 1e-6);
  }
}

/// Largest distance in any joint of the trajectory from the polyline, at its nearest point.
double deviation(const Trajectory& trajectory, const JointPath& path) {
  double worst = 0.0;
  for (double t = 0.0; t < trajectory.duration_s(); t += 0.004) {
    const JointVector q = trajectory.sample(t).q_rad;
    double nearest = 1e9;
    for (std::size_t i = 1; i < path.size(); ++i) {
      const JointVector d = path[i] - path[i - 1];
      const double n = d.squaredNorm();
      const double foot = n > 0.0 ? std::clamp(d.dot(q - path[i - 1]) / n, 0.0, 1.0) : 0.0;
      // the foot is nearest in the Euclidean norm; a few points around it for the largest joint
      for (int k = -10; k <= 10; ++k) {
        const double x = std::clamp(foot + 0.01 * k, 0.0, 1.0);
        nearest = std::min(nearest, planner::joint_distance(q, path[i - 1] + x * d));
      }
    }
    worst = std::max(worst, nearest);
  }
  return worst;
}

JointPath random_path(planner::JointRandom& random, int points, double size) {
  const planner::JointBox box{JointVector::Constant(-2.0), JointVector::Constant(2.0)};
  JointPath path{random.in(box)};
  for (int i = 1; i < points; ++i) path.push_back(random.near(path.back(), size, box));
  return path;
}

MotionLimits random_limits(planner::JointRandom& random) {
  MotionLimits limits;
  for (int j = 0; j < 7; ++j) {
    limits.velocity_rad_s[j] = random.between(0.1, 3.0);
    limits.acceleration_rad_s2[j] = random.between(0.5, 10.0);
    limits.jerk_rad_s3[j] = random.between(3.0, 200.0);
  }
  return limits;
}

/// Shortest time from rest to rest over a distance, by the textbook cases of the double S profile (Biagiotti
/// and Melchiorri, Trajectory Planning, ch. 3.4).
double double_s_duration(double h, double v, double a, double j) {
  const double Tj = v * j >= a * a ? a / j : std::sqrt(v / j);
  const double Ta = v * j >= a * a ? Tj + v / a : 2 * Tj;
  if (h / v >= Ta) return h / v + Ta;
  const double tj = a / j;
  const double ta = (a * a / j + std::sqrt(std::pow(a, 4) / (j * j) + 4 * a * h)) / (2 * a);
  if (ta >= 2 * tj) return 2 * ta;
  return 4 * std::cbrt(h / (2 * j));
}

}  // namespace

TEST_CASE("a straight way takes the shortest time that the limits allow") {
  planner::JointRandom random(1);
  for (int i = 0; i < 500; ++i) {
    const MotionLimits limits = random_limits(random);
    const JointPath path = random_path(random, 2, std::pow(10.0, random.between(-4.0, 0.6)));
    const JointVector d = (path[1] - path[0]).cwiseAbs();
    const double expected = double_s_duration(1.0, limits.velocity_rad_s.cwiseQuotient(d).minCoeff(),
                                              limits.acceleration_rad_s2.cwiseQuotient(d).minCoeff(),
                                              limits.jerk_rad_s3.cwiseQuotient(d).minCoeff());
    const auto trajectory = planner::make_trajectory(path, limits, 0.0);
    REQUIRE(trajectory);
    REQUIRE(trajectory->duration_s() == Approx(expected).epsilon(1e-9));
    check_within(*trajectory, limits);
    check_ends(*trajectory, path[0], path[1]);
    REQUIRE(deviation(*trajectory, path) < 1e-9);
  }
}

TEST_CASE("points on a straight way make no difference") {
  const JointVector a = JointVector::Constant(0.3), b = JointVector::LinSpaced(-1.0, 1.5);
  const JointPath two{a, b}, many{a, a + 0.2 * (b - a), a + 0.2 * (b - a), a + 0.7 * (b - a), b, b};
  const auto short_one = planner::make_trajectory(two, MotionLimits{}, 0.05);
  const auto long_one = planner::make_trajectory(many, MotionLimits{}, 0.05);
  REQUIRE(short_one);
  REQUIRE(long_one);
  CHECK(long_one->duration_s() == Approx(short_one->duration_s()).epsilon(1e-9));
}

TEST_CASE("random paths are followed within all limits and near their corners") {
  planner::JointRandom random(2);
  for (int i = 0; i < 150; ++i) {
    const MotionLimits limits = i % 3 == 0 ? MotionLimits{} : random_limits(random);
    const JointPath path = random_path(random, 2 + static_cast<int>(random.between(0, 7)),
                                       std::pow(10.0, random.between(-2.0, 0.3)));
    const double blend = i % 5 == 0 ? 0.0 : std::pow(10.0, random.between(-3.0, -0.5));
    CAPTURE(i, blend, path.size());
    const auto trajectory = planner::make_trajectory(path, limits, blend);
    REQUIRE(trajectory);
    check_within(*trajectory, limits);
    check_continuous(*trajectory, limits);
    check_ends(*trajectory, path.front(), path.back());
    REQUIRE(deviation(*trajectory, path) <= blend + 1e-9);
  }
}

TEST_CASE("rounded corners save time and are rounded as far as allowed") {
  planner::JointRandom random(3);
  double stopping = 0.0, rounded = 0.0;
  for (int i = 0; i < 50; ++i) {
    const JointPath path = random_path(random, 5, 1.0);
    stopping += planner::make_trajectory(path, MotionLimits{}, 0.0)->duration_s();
    const auto trajectory = planner::make_trajectory(path, MotionLimits{}, 0.1);
    rounded += trajectory->duration_s();
    REQUIRE(deviation(*trajectory, path) > 0.01);
  }
  INFO(rounded / stopping);
  CHECK(rounded < 0.85 * stopping);
}

TEST_CASE("without blending every corner is a stop") {
  const JointPath path{JointVector::Zero(), JointVector::Constant(0.5), JointVector::Unit(2)};
  const auto whole = planner::make_trajectory(path, MotionLimits{}, 0.0);
  const JointPath first{path[0], path[1]}, second{path[1], path[2]};
  const auto a = planner::make_trajectory(first, MotionLimits{}, 0.0);
  const auto b = planner::make_trajectory(second, MotionLimits{}, 0.0);
  REQUIRE(whole);
  CHECK(whole->duration_s() == Approx(a->duration_s() + b->duration_s()));
  const auto corner = whole->sample(a->duration_s());
  CHECK((corner.q_rad - path[1]).norm() < 1e-9);
  CHECK(corner.dq_rad_s.norm() < 1e-9);
}

TEST_CASE("a way there and back stops at its turning point") {
  const JointPath path{JointVector::Zero(), JointVector::Constant(0.5), JointVector::Zero()};
  const auto trajectory = planner::make_trajectory(path, MotionLimits{}, 0.05);
  REQUIRE(trajectory);
  check_within(*trajectory, MotionLimits{});
  check_continuous(*trajectory, MotionLimits{});
  CHECK(deviation(*trajectory, path) < 1e-9);
}

TEST_CASE("the reversed motion is the mirror image") {
  planner::JointRandom random(4);
  for (int i = 0; i < 20; ++i) {
    const JointPath path = random_path(random, 4, 0.8);
    for (const bool along : {false, true}) {
      const auto there = along ? planner::make_trajectory_along(path, MotionLimits{})
                               : planner::make_trajectory(path, MotionLimits{}, 0.05);
      REQUIRE(there);
      const Trajectory back = there->reversed();
      const double T = there->duration_s();
      REQUIRE(back.duration_s() == T);
      check_ends(back, path.back(), path.front());
      for (double t = 0.0; t <= T; t += T / 997) {
        const auto a = there->sample(T - t), b = back.sample(t);
        REQUIRE((a.q_rad - b.q_rad).norm() < 1e-9);
        REQUIRE((a.dq_rad_s + b.dq_rad_s).norm() < 1e-9);
        REQUIRE((a.ddq_rad_s2 - b.ddq_rad_s2).norm() < 1e-7);
      }
    }
  }
}

TEST_CASE("a path of one point is a motion of no duration") {
  const JointPath path{JointVector::Constant(0.4)};
  for (const auto& trajectory : {planner::make_trajectory(path, MotionLimits{}, 0.05),
                                 planner::make_trajectory_along(path, MotionLimits{})}) {
    REQUIRE(trajectory);
    CHECK_FALSE(trajectory->empty());
    CHECK(trajectory->duration_s() == 0.0);
    CHECK(trajectory->sample(0.3).q_rad == path[0]);
    CHECK(trajectory->reversed().sample(0.0).q_rad == path[0]);
  }
  CHECK(Trajectory().empty());
  CHECK(Trajectory().reversed().empty());
}

TEST_CASE("bad paths and limits are refused") {
  const JointPath good{JointVector::Zero(), JointVector::Constant(0.5)};
  const auto refused = [](const hal::Result<Trajectory>& result, const std::string& says) {
    REQUIRE_FALSE(result);
    CHECK(result.error().code == hal::ErrorCode::BadInput);
    CHECK_THAT(result.error().detail, Catch::Matchers::Contains(says));
  };
  refused(planner::make_trajectory({}, MotionLimits{}, 0.1), "no waypoint");
  refused(planner::make_trajectory_along({}, MotionLimits{}), "no waypoint");
  JointPath bad = good;
  bad[1][3] = std::numeric_limits<double>::quiet_NaN();
  refused(planner::make_trajectory(bad, MotionLimits{}, 0.1), "waypoint 1");
  refused(planner::make_trajectory_along(bad, MotionLimits{}), "waypoint 1");
  refused(planner::make_trajectory(good, MotionLimits{}, -0.1), "blend");
  refused(planner::make_trajectory(good, MotionLimits{}, std::numeric_limits<double>::quiet_NaN()), "blend");
  MotionLimits still;
  still.jerk_rad_s3[2] = 0.0;
  refused(planner::make_trajectory(good, still, 0.1), "limit");
  refused(planner::make_trajectory_along(good, still), "limit");
  refused(planner::make_trajectory_along(good, MotionLimits{}, -1.0), "duration");
}

TEST_CASE("a dense path is followed smoothly within all limits") {
  planner::JointRandom random(5);
  for (int i = 0; i < 60; ++i) {
    const MotionLimits limits = i % 2 == 0 ? MotionLimits{} : random_limits(random);
    // a smooth curve, sampled
    const planner::JointBox box{JointVector::Constant(-1.0), JointVector::Constant(1.0)};
    const JointVector a = random.in(box), b = random.in(box), c = random.in(box);
    const int points = 2 + static_cast<int>(random.between(0, 39));
    const auto curve = [&](double x) -> JointVector { return a + x * (b + x * c); };
    JointPath path;
    for (int k = 0; k < points; ++k) path.push_back(curve(static_cast<double>(k) / (points - 1)));
    const auto trajectory = planner::make_trajectory_along(path, limits);
    CAPTURE(i, points);
    REQUIRE(trajectory);
    check_within(*trajectory, limits);
    check_continuous(*trajectory, limits);
    check_ends(*trajectory, path.front(), path.back());
    if (points < 10) continue;
    // near the sampled curve, not only near its points
    JointPath fine;
    for (int k = 0; k <= 1000; ++k) fine.push_back(curve(0.001 * k));
    REQUIRE(deviation(*trajectory, fine) < 0.002);
  }
}

TEST_CASE("a dense straight path takes hardly longer than a straight one") {
  const JointVector a = JointVector::Zero(), b = JointVector::LinSpaced(0.1, 0.9);
  JointPath dense;
  for (int k = 0; k <= 40; ++k) dense.push_back(a + (k / 40.0) * (b - a));
  const JointPath two{a, b};
  const double best = planner::make_trajectory(two, MotionLimits{}, 0.0)->duration_s();
  const auto trajectory = planner::make_trajectory_along(dense, MotionLimits{});
  REQUIRE(trajectory);
  CHECK(trajectory->duration_s() < 1.1 * best);
  CHECK(deviation(*trajectory, two) < 1e-9);
}

TEST_CASE("a duration that is asked for is kept") {
  const JointPath path{JointVector::Zero(), JointVector::Constant(0.1), JointVector::Constant(0.3)};
  const auto slow = planner::make_trajectory_along(path, MotionLimits{}, 9.0);
  REQUIRE(slow);
  CHECK(slow->duration_s() == Approx(9.0));
  check_ends(*slow, path.front(), path.back());
  CHECK(used(*slow, MotionLimits{}).velocity < 0.2);
}
