#include "planner/motion/inverse_kinematics/arm_ik_circle.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace colift::planner {
namespace {

using hal::JointVector;
using hal::Vec3;

constexpr double kPi = std::numbers::pi;
/// Beyond reach by less than this is rounding (m); so is beyond a limit (rad).
constexpr double kRounding = 1e-10;
/// Sine below which two axes count as one line.
constexpr double kSingular = 1e-10;
/// Sine of the angle to the vertical below which a line has no up.
constexpr double kVertical = 1e-9;

double wrapped(double angle_rad) {
  if (angle_rad > kPi) return angle_rad - 2.0 * kPi;
  if (angle_rad <= -kPi) return angle_rad + 2.0 * kPi;
  return angle_rad;
}

/// Three joints z, -y, z that together make one rotation.
struct Triple {
  double first, middle, last;
};

/// Both triples (middle >= 0, then < 0) for the rotation with columns x, y, z; one where middle = 0 makes
/// them the same, with `first` at `hint` or else both half.
int triples(const Vec3& x, const Vec3& y, const Vec3& z, const double* hint, std::array<Triple, 2>& out) {
  const double sine = std::hypot(z.x(), z.y());
  if (sine < kSingular && z.z() > 0.0) {
    const double sum = std::atan2(x.y() - y.x(), x.x() + y.y());
    const double first = hint ? *hint : 0.5 * sum;
    out[0] = {first, 0.0, wrapped(std::remainder(sum - first, 2.0 * kPi))};
    return 1;
  }
  if (sine < kSingular) return 0;  // folded back on itself; no joint can
  const double first = std::atan2(-z.y(), -z.x()), middle = std::atan2(sine, z.z());
  // from the axis of the middle joint, which is well defined however small the sine
  const double c = -z.x() / sine, s = -z.y() / sine;
  const double last = std::atan2(-s * x.x() + c * x.y(), -s * y.x() + c * y.y());
  out[0] = {first, middle, last};
  out[1] = {wrapped(first + kPi), -middle, wrapped(last + kPi)};
  return 2;
}

/// Whether a joint is in its range; rounding is taken off.
bool fit(double& q_rad, int joint, const JointRange& range) {
  if (q_rad < range.lower_rad[joint] - kRounding || q_rad > range.upper_rad[joint] + kRounding) return false;
  if (!(range.lower_rad[joint] <= range.upper_rad[joint])) return false;
  q_rad = std::clamp(q_rad, range.lower_rad[joint], range.upper_rad[joint]);
  return true;
}

/// The triples of which all three joints are in range.
int fitting(std::array<Triple, 2>& all, int count, int first_joint, const JointRange& range) {
  int kept = 0;
  for (int i = 0; i < count; ++i) {
    Triple t = all[static_cast<std::size_t>(i)];
    if (fit(t.first, first_joint, range) && fit(t.middle, first_joint + 1, range) &&
        fit(t.last, first_joint + 2, range)) {
      all[static_cast<std::size_t>(kept++)] = t;
    }
  }
  return kept;
}

/// a + b cos(psi) + c sin(psi).
struct Wave {
  double a = 0.0, b = 0.0, c = 0.0;
};

/// A vector of the arm as a function of psi.
struct VectorWave {
  Vec3 a, b, c;
  [[nodiscard]] Wave along(const Vec3& d) const { return {a.dot(d), b.dot(d), c.dot(d)}; }
};

/// Appends where the wave is zero.
void zeros(const Wave& wave, std::array<double, kMaxElbowEnds>& out, std::size_t& count) {
  const double amplitude = std::hypot(wave.b, wave.c);
  if (amplitude < 1e-14 || std::abs(wave.a) > amplitude * (1.0 + 1e-9)) return;
  const double middle = std::atan2(wave.c, wave.b),
               to_each_side = std::acos(std::clamp(-wave.a / amplitude, -1.0, 1.0));
  for (const double psi : {middle - to_each_side, middle + to_each_side}) {
    if (count < out.size()) out[count++] = wrapped(psi);
  }
}

Wave mixed(const Wave& p, double s, const Wave& q, double t) {
  return {p.a * s + q.a * t, p.b * s + q.b * t, p.c * s + q.c * t};
}

}  // namespace

Vec3 up_across(const Vec3& n) {
  // Wz less its part along n, written without the difference of nearly equal numbers
  const Vec3 across(-n.x() * n.z(), -n.y() * n.z(), n.x() * n.x() + n.y() * n.y());
  if (across.norm() > kVertical) return across.normalized();
  return (Vec3::UnitX() - n.x() * n).normalized();
}

std::optional<ElbowCircle> elbow_circle(const ArmGeometry& arm, const hal::Pose& X_WF) {
  if (!X_WF.matrix().allFinite()) return std::nullopt;
  const Vec3 to_wrist = X_WF.translation() - arm.wrist_to_flange_m * X_WF.linear().col(2) -
                        Vec3(0.0, 0.0, arm.base_to_shoulder_m);
  const double a = arm.upper_arm_m, b = arm.forearm_m, length = to_wrist.norm();
  if (length > a + b + kRounding || length < std::abs(a - b) - kRounding || length < 1e-6)
    return std::nullopt;
  ElbowCircle circle;
  circle.R_WF = X_WF.linear();
  circle.n = to_wrist / length;
  circle.u = up_across(circle.n);
  circle.v = circle.n.cross(circle.u);
  // law of cosines, by the half angle: exact near the straight arm
  circle.bend_rad = 2.0 * std::atan2(std::sqrt(std::max(0.0, (a + b - length) * (a + b + length))),
                                     std::sqrt(std::max(0.0, (length - a + b) * (length + a - b))));
  circle.sin_bend = std::sin(circle.bend_rad);
  circle.cos_bend = std::cos(circle.bend_rad);
  const double lean = std::atan2(b * circle.sin_bend, a + b * circle.cos_bend);
  circle.sin_lean = std::sin(lean);
  circle.cos_lean = std::cos(lean);
  return circle;
}

Vec3 elbow_direction(const ArmGeometry& arm, const JointVector& q) {
  const auto about_z = [](double angle) { return Eigen::AngleAxisd(angle, Vec3::UnitZ()); };
  const Eigen::Matrix3d R =
      (about_z(q[0]) * Eigen::AngleAxisd(-q[1], Vec3::UnitY()) * about_z(q[2])).toRotationMatrix();
  const double sine = std::sin(q[3]);
  const Vec3 to_wrist =
      arm.forearm_m * sine * R.col(0) + (arm.upper_arm_m + arm.forearm_m * std::cos(q[3])) * R.col(2);
  // the axis of A4 stands on the arm's plane
  return (sine < 0.0 ? -1.0 : 1.0) * to_wrist.normalized().cross(R.col(1));
}

int solve_on_circle(const ElbowCircle& circle, double psi_rad, const JointRange& range,
                    const JointVector* near, std::array<IkSolution, 8>& out) {
  const Vec3 e = std::cos(psi_rad) * circle.u + std::sin(psi_rad) * circle.v;
  const Vec3 z3 = circle.cos_lean * circle.n + circle.sin_lean * e;
  const Vec3 x3_bent = circle.sin_lean * circle.n - circle.cos_lean * e, y3_bent = e.cross(circle.n);
  const Vec3 x4_bent = circle.cos_bend * x3_bent - circle.sin_bend * z3;
  const Vec3 z4 = circle.sin_bend * x3_bent + circle.cos_bend * z3;
  int count = 0;
  for (const double sign : {1.0, -1.0}) {
    double a4 = sign * circle.bend_rad;
    if (!fit(a4, 3, range)) continue;
    std::array<Triple, 2> shoulder{}, wrist{};
    const int s =
        fitting(shoulder, triples(sign * x3_bent, sign * y3_bent, z3, near ? &(*near)[0] : nullptr, shoulder),
                0, range);
    if (s == 0) continue;
    Eigen::Matrix3d R_W4;
    R_W4 << sign * x4_bent, sign * y3_bent, z4;
    const Eigen::Matrix3d R_4F = R_W4.transpose() * circle.R_WF;
    const int w = fitting(
        wrist, triples(R_4F.col(0), R_4F.col(1), R_4F.col(2), near ? &(*near)[4] : nullptr, wrist), 4, range);
    for (int i = 0; i < s; ++i) {
      for (int j = 0; j < w; ++j) {
        const Triple& a = shoulder[static_cast<std::size_t>(i)];
        const Triple& b = wrist[static_cast<std::size_t>(j)];
        IkSolution& ik = out[static_cast<std::size_t>(count++)];
        ik.q_rad << a.first, a.middle, a.last, a4, b.first, b.middle, b.last;
        ik.elbow_rad = psi_rad;
        ik.branch = (a.middle < 0.0 ? 1 : 0) | (sign < 0.0 ? 2 : 0) | (b.middle < 0.0 ? 4 : 0);
      }
    }
    // a straight arm is the same with both signs but for A3 and A5, which turn by pi; both are solutions
  }
  return count;
}

std::size_t elbow_ends(const ElbowCircle& circle, const JointRange& range,
                       std::array<double, kMaxElbowEnds>& ends) {
  // x3, y3, x4 change their sign with A4, which moves no zero below
  const Vec3 zero = Vec3::Zero();
  const VectorWave z3{circle.cos_lean * circle.n, circle.sin_lean * circle.u, circle.sin_lean * circle.v};
  const VectorWave x3{circle.sin_lean * circle.n, -circle.cos_lean * circle.u, -circle.cos_lean * circle.v};
  const VectorWave y3{zero, -circle.v, circle.u};
  const auto turned = [&](double s, double c) {
    return VectorWave{s * x3.a + c * z3.a, s * x3.b + c * z3.b, s * x3.c + c * z3.c};
  };
  const VectorWave x4 = turned(circle.cos_bend, -circle.sin_bend),
                   z4 = turned(circle.sin_bend, circle.cos_bend);
  const Vec3 Fx = circle.R_WF.col(0), Fy = circle.R_WF.col(1), Fz = circle.R_WF.col(2);

  std::size_t count = 0;
  for (const JointVector* limit : {&range.lower_rad, &range.upper_rad}) {
    const auto sine = [&](int i) { return std::sin((*limit)[i]); };
    const auto cosine = [&](int i) { return std::cos((*limit)[i]); };
    zeros(mixed(z3.along(Vec3::UnitX()), sine(0), z3.along(Vec3::UnitY()), -cosine(0)), ends, count);
    zeros(mixed(z3.along(Vec3::UnitZ()), 1.0, Wave{cosine(1)}, -1.0), ends, count);
    zeros(mixed(x3.along(Vec3::UnitZ()), sine(2), y3.along(Vec3::UnitZ()), cosine(2)), ends, count);
    zeros(mixed(x4.along(Fz), sine(4), y3.along(Fz), -cosine(4)), ends, count);
    zeros(mixed(z4.along(Fz), 1.0, Wave{cosine(5)}, -1.0), ends, count);
    zeros(mixed(z4.along(Fx), sine(6), z4.along(Fy), cosine(6)), ends, count);
  }
  std::sort(ends.begin(), ends.begin() + static_cast<std::ptrdiff_t>(count));
  return count;
}

}  // namespace colift::planner
