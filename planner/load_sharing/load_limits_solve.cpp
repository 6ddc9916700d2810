#include <algorithm>
#include <cmath>

#include "planner/load_sharing/load_limits_problem.hpp"

namespace colift::planner {
namespace {

constexpr double kUnreached = std::numeric_limits<double>::infinity();
constexpr int kMaxSteps = 8;
constexpr int kMaxDescents = 30;
constexpr double kFlat = 0.1;  // the line search ends where the slope has fallen to this part

/// Solves the symmetric-pattern 3x3 system by cofactors; false where it is singular to rounding.
bool solve3(const Eigen::Matrix3d& a, const Vec3& b, Vec3& x) {
  const Vec3 c0 = a.row(1).cross(a.row(2)), c1 = a.row(2).cross(a.row(0)), c2 = a.row(0).cross(a.row(1));
  const double det = c0.x() * a(0, 0) + c0.y() * a(0, 1) + c0.z() * a(0, 2);
  const double size = std::abs(c0.x() * a(0, 0)) + std::abs(c0.y() * a(0, 1)) + std::abs(c0.z() * a(0, 2));
  if (!(std::abs(det) > 1e-13 * size)) return false;
  x = (c0 * b.x() + c1 * b.y() + c2 * b.z()) / det;
  return true;
}

/// Gaussian elimination with row pivoting of an n x n system (n <= 6) stored with its right-hand side in
/// column n.
bool eliminate(double (&a)[6][7], int n) {
  for (int k = 0; k < n; ++k) {
    int best = k;
    for (int i = k + 1; i < n; ++i) {
      if (std::abs(a[i][k]) > std::abs(a[best][k])) best = i;
    }
    if (!(std::abs(a[best][k]) > 1e-13)) return false;  // rows and unknowns are scaled to about one
    if (best != k) std::swap_ranges(a[k] + k, a[k] + n + 1, a[best] + k);
    for (int i = 0; i < n; ++i) {
      if (i == k) continue;
      const double factor = a[i][k] / a[k][k];
      if (factor == 0.0) continue;
      for (int j = k; j <= n; ++j) a[i][j] -= factor * a[k][j];
    }
  }
  for (int k = 0; k < n; ++k) a[k][n] /= a[k][k];
  return true;
}

/// [arm]x diag(open) [arm]x^T: torque bought by the forces that may still move.
Eigen::Matrix3d lever_matrix(const Vec3& arm, const Vec3& open) {
  const double x = arm.x(), y = arm.y(), z = arm.z();
  Eigen::Matrix3d a;
  a(0, 0) = open[1] * z * z + open[2] * y * y;
  a(1, 1) = open[0] * z * z + open[2] * x * x;
  a(2, 2) = open[0] * y * y + open[1] * x * x;
  a(0, 1) = a(1, 0) = -open[2] * x * y;
  a(0, 2) = a(2, 0) = -open[1] * x * z;
  a(1, 2) = a(2, 1) = -open[0] * y * z;
  return a;
}

}  // namespace

/// Torque per multiplier that is typical of this problem.
double LimitedSharing::slope_scale(const Problem& q) const {
  const double give = sharing_.give();
  const double scale = sharing_.robot_part() * q.arm.squaredNorm() + (std::isfinite(give) ? give : 0.0);
  return scale > 0.0 ? scale : 1.0;
}

/// Cost of the torque about one axis, split at its cheapest; infinite beyond both limits.
double LimitedSharing::torque_weight(double torque) const {
  const double t = std::abs(torque);
  if (t <= knee_torque_) return t * t / sharing_.give();
  const double over = t - first_limit_;
  return first_limit_ * knee_m_ + over * over / second_give_;
}

// One unknown per axis, u = torque + kappa * multiplier: on the staircase of the torque against its
// multiplier every u names one point, with finite slopes of both even where one of them is stuck. Piecewise
// linear, so a full step that stays on its pieces is the exact answer.
bool LimitedSharing::newton(const Problem& q, Vec3 u, int max_steps, Vec3& force, Vec3& torque) const {
  const double k = sharing_.robot_part(), give = sharing_.give();
  const double kappa = slope_scale(q);
  const double knee_u = knee_torque_ + (knee_m_ == 0.0 ? 0.0 : kappa * knee_m_);
  const double wall_u = torque_sum_ + (wall_m_ == 0.0 ? 0.0 : kappa * wall_m_);
  const double noise = q.noise();

  int pieces = -1;
  for (int step = 0; step < max_steps; ++step) {
    Vec3 m, m_slope, t_slope;
    int now = 0;
    for (int c = 0; c < 3; ++c) {
      const double v = std::abs(u[c]);
      double t, mult;
      int piece;
      if (v <= knee_u) {
        piece = 0;
        m_slope[c] = std::isfinite(give) ? 1.0 / (give + kappa) : 0.0;
        mult = m_slope[c] * v;
        t = std::isfinite(give) ? give * mult : v;
      } else if (v < wall_u) {
        piece = 1;
        m_slope[c] = 1.0 / (second_give_ + kappa);
        mult = (v - first_limit_) * m_slope[c];
        t = first_limit_ + second_give_ * mult;
      } else {
        piece = 2;
        m_slope[c] = 1.0 / kappa;
        mult = (v - torque_sum_) * m_slope[c];
        t = torque_sum_;
      }
      t_slope[c] = piece == 2 ? 0.0 : 1.0 - kappa * m_slope[c];
      m[c] = std::copysign(mult, u[c]);
      torque[c] = std::copysign(t, u[c]);
      now = now * 8 + piece * 2 + (piece != 0 && u[c] < 0.0);
    }
    const Vec3 wanted = q.free + k * m.cross(q.arm);
    force = q.clamp(wanted);
    Vec3 open;
    for (int c = 0; c < 3; ++c) {
      const int state = wanted[c] < q.low[c] ? 1 : (wanted[c] > q.high[c] ? 2 : 0);
      open[c] = state == 0 ? k : 0.0;
      now = now * 4 + state;
    }
    const Vec3 residual = q.need - q.arm.cross(force) - torque;
    const double worst = residual.cwiseAbs().maxCoeff();
    if (worst <= noise || (now == pieces && worst <= 100.0 * noise)) return true;
    pieces = now;

    Eigen::Matrix3d a = lever_matrix(q.arm, open);
    for (int c = 0; c < 3; ++c) {
      a.col(c) *= m_slope[c];
      a(c, c) += t_slope[c];
    }
    Vec3 du;
    if (!solve3(a, residual, du)) return false;
    u += du;
    if (!u.allFinite()) return false;
  }
  return false;
}

// The torque about one axis that a multiplier buys, and how fast it grows. Free torque is given a steep slope
// instead of a jump, which is enough to find the pieces.
double LimitedSharing::torque_at(double multiplier, double free_give, double& slope) const {
  const double m = std::abs(multiplier), steep = std::min(sharing_.give(), free_give);
  double t;
  if (steep * m <= knee_torque_ && (m <= knee_m_ || knee_m_ == 0.0)) {
    t = steep * m;
    slope = steep;
  } else if (m < wall_m_ && first_limit_ + second_give_ * m < torque_sum_) {
    t = first_limit_ + second_give_ * m;
    slope = second_give_;
  } else {
    t = torque_sum_;
    slope = 0.0;
  }
  return std::copysign(t, multiplier);
}

// Minimises the dual, which is convex, smooth and piecewise quadratic in three multipliers, by regularised
// Newton with an exact line search: slower than newton() but it cannot cycle. Ends with newton() on the
// pieces it has found.
bool LimitedSharing::descend(const Problem& q, const AgentWrenches& unlimited, Vec3& force,
                             Vec3& torque) const {
  const double k = sharing_.robot_part(), give = sharing_.give();
  const double kappa = slope_scale(q), free_give = 1e4 * kappa;
  Vec3 slope, open;
  const auto residual_at = [&](const Vec3& m) {
    const Vec3 wanted = q.free + k * m.cross(q.arm);
    force = q.clamp(wanted);
    for (int c = 0; c < 3; ++c) {
      open[c] = wanted[c] >= q.low[c] && wanted[c] <= q.high[c] ? k : 0.0;
      torque[c] = torque_at(m[c], free_give, slope[c]);
    }
    return Vec3(q.need - q.arm.cross(force) - torque);
  };

  Vec3 m = std::isfinite(give) ? Vec3((unlimited.partner.torque + unlimited.robot.torque) / give)
                               : Vec3(Vec3::Zero());
  Vec3 r = residual_at(m);
  const double enough = q.noise();
  double damping = 1e-9;
  for (int step = 0; step < kMaxDescents && r.cwiseAbs().maxCoeff() > enough; ++step) {
    Eigen::Matrix3d h = lever_matrix(q.arm, open);
    h.diagonal() += slope;
    h.diagonal().array() += damping * (h.trace() + 1e-3 * kappa);
    Vec3 direction;
    if (!solve3(h, r, direction)) {
      damping *= 100.0;
      continue;
    }
    // the slope of the dual along the direction, -r.direction, grows from negative: walk to where it crosses
    // zero
    double low = 0.0, high = 1.0, at_low = r.dot(direction);
    if (!(at_low > 0.0)) break;
    const double flat = kFlat * at_low;
    Vec3 r_high = residual_at(m + direction);
    double at_high = r_high.dot(direction);
    for (int grow = 0; at_high > flat && grow < 40; ++grow) {
      low = high;
      at_low = at_high;
      high *= 4.0;
      r_high = residual_at(m + high * direction);
      at_high = r_high.dot(direction);
    }
    double at = high;
    if (at_high < -flat) {
      for (int i = 0; i < 40; ++i) {
        // false position and bisection in turn: the first is exact on the last piece, the second always
        // halves
        at = i % 2 == 0 ? low + (high - low) * at_low / (at_low - at_high) : 0.5 * (low + high);
        r_high = residual_at(m + at * direction);
        const double here = r_high.dot(direction);
        if (std::abs(here) <= flat) break;
        (here > 0.0 ? low : high) = at;
        (here > 0.0 ? at_low : at_high) = here;
      }
    }
    m += at * direction;
    r = r_high;
  }
  return newton(q, torque + kappa * m, kMaxSteps / 2, force, torque);
}

void LimitedSharing::solve(const Problem& q, const AgentWrenches& unlimited, Vec3& force,
                           Vec3& torque) const {
  const double give = sharing_.give();
  const Vec3 total = unlimited.partner.torque + unlimited.robot.torque;
  const Vec3 start = std::isfinite(give) ? Vec3(total + (slope_scale(q) / give) * total) : total;
  if (newton(q, start, kMaxSteps, force, torque)) return;
  if (descend(q, unlimited, force, torque)) return;
  enumerate(q, force, torque);
}

// For every combination of forces at a bound and torques on a piece: the minimum on the affine set where
// those hold. The optimum is among them, and every other one that keeps the limits costs more, so no
// multipliers are needed.
void LimitedSharing::enumerate(const Problem& q, Vec3& force, Vec3& torque) const {
  const double k = sharing_.robot_part();
  const double reach = std::max(1e-300, q.arm.cwiseAbs().maxCoeff());
  const double give = sharing_.give();
  const Vec3 d = q.arm;
  Eigen::Matrix3d cross;
  cross << 0.0, -d.z(), d.y(), d.z(), 0.0, -d.x(), -d.y(), d.x(), 0.0;
  const double torque_scale = q.need.cwiseAbs().maxCoeff() + reach * q.free.cwiseAbs().maxCoeff();

  double best_cost = kUnreached, best_over = kUnreached;
  const auto offer = [&](const Vec3& z) {
    const Vec3 t = q.need - cross * z;
    const double over = std::max(0.0, t.cwiseAbs().maxCoeff() - torque_sum_) / std::max(torque_scale, 1e-300);
    double cost = (z - q.free).squaredNorm() / k;
    for (int c = 0; c < 3; ++c) cost += torque_weight(std::min(std::abs(t[c]), torque_sum_));
    // within the limits first, cheapest next; where rounding leaves nothing within, the nearest
    const double excess = over <= 1e-11 ? 0.0 : over;
    if (!(excess < best_over || (excess == best_over && cost < best_cost))) return;
    best_over = excess;
    best_cost = cost;
    force = z;
    torque = t.cwiseMax(-torque_sum_).cwiseMin(torque_sum_);
  };

  const bool walls = std::isfinite(torque_sum_),
             knees = std::isfinite(knee_torque_) && std::isfinite(second_give_);
  for (int box = 0; box < 27; ++box) {
    Vec3 fixed = Vec3::Zero();
    int open[3], opens = 0;
    bool possible = true;
    for (int c = 0, code = box; c < 3; ++c, code /= 3) {
      if (code % 3 == 0) {
        open[opens++] = c;
      } else {
        fixed[c] = code % 3 == 1 ? q.low[c] : q.high[c];
        possible = possible && std::isfinite(fixed[c]);
      }
    }
    if (!possible) continue;
    if (opens == 0) {
      offer(fixed);
      continue;
    }
    for (int combo = 0; combo < 125; ++combo) {
      // per axis: 0 both share, 1/2 one limited (+/-), 3/4 both limited (+/-)
      const int piece[3] = {combo % 5, combo / 5 % 5, combo / 25};
      int rows = opens;
      possible = true;
      for (const int p : piece) {
        possible = possible && (p == 0 || (p < 3 ? knees : walls));
        rows += p >= 3;
      }
      if (!possible || rows > 2 * opens) continue;
      // unknowns: open forces, then k/reach times the multiplier of each torque at its wall
      double a[6][7] = {};
      for (int i = 0; i < opens; ++i) {
        a[i][i] = 1.0;
        a[i][rows] = q.free[open[i]];
      }
      int row = opens;
      for (int c = 0; c < 3; ++c) {
        const double sign = piece[c] % 2 == 1 ? 1.0 : -1.0;
        const double left = q.need[c] - cross.row(c).dot(fixed);
        if (piece[c] >= 3) {
          for (int i = 0; i < opens; ++i) {
            a[row][i] = cross(c, open[i]) / reach;
            a[i][row] = -cross(c, open[i]) / reach;
          }
          a[row++][rows] = (left - sign * torque_sum_) / reach;
          continue;
        }
        const double slope = piece[c] == 0 ? 1.0 / give : 1.0 / second_give_;
        const double target = piece[c] == 0 ? left : left - sign * first_limit_;
        for (int i = 0; i < opens; ++i) {
          for (int j = 0; j < opens; ++j) a[i][j] += k * slope * cross(c, open[i]) * cross(c, open[j]);
          a[i][rows] += k * slope * cross(c, open[i]) * target;
        }
      }
      for (int i = 0; i < opens; ++i) {  // large where torque is dear
        double size = 0.0;
        for (int j = 0; j < rows; ++j) size = std::max(size, std::abs(a[i][j]));
        for (int j = 0; j <= rows; ++j) a[i][j] /= size;
      }
      if (!eliminate(a, rows)) continue;
      Vec3 z = fixed;
      for (int i = 0; i < opens; ++i) z[open[i]] = a[i][rows];
      const Vec3 inside = q.clamp(z);
      if ((z - inside).cwiseAbs().maxCoeff() >
          1e-11 * (q.free.cwiseAbs().maxCoeff() + z.cwiseAbs().maxCoeff()))
        continue;
      offer(inside);
    }
  }
}

}  // namespace colift::planner
