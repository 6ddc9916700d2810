#pragma once

#include <Eigen/Dense>
#include <optional>
#include <random>

#include "planner/load_sharing/load_limits.hpp"
#include "planner/load_sharing/load_sharing.hpp"

// Independent answers to the program of thesis 4.4, straight from its matrices: nothing here knows the closed
// form.
namespace reference {

using colift::hal::Vec3;
using colift::hal::Wrench;
using colift::planner::AgentWrenches;
using colift::planner::SharingLimits;
using colift::planner::SharingWeights;
using Real = long double;
using Matrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic>;
using Vector = Eigen::Matrix<Real, Eigen::Dynamic, 1>;

struct Program {
  Vector q;       ///< Diagonal of Q, order f1, tau1, f2, tau2 (12).
  Matrix e;       ///< Equilibrium (6 x 12).
  Vector w;       ///< Task wrench (6).
  Vector limits;  ///< Largest magnitude of each unknown, may be infinite (12).
};

Program make_program(const SharingWeights& weights, const SharingLimits& limits, const Vec3& p1,
                     const Vec3& p2, const Wrench& task);

/// Stationarity and equilibrium as one 18 x 18 system, by LU with full pivoting. Ignores limits.
Vector solve_kkt(const Program& program);

/// Smallest cost by the same system in 113-bit floating point, for problems whose scales overwhelm the LU
/// above.
double cost_by_quad_kkt(const Program& program);

/// Interior point method (primal-dual, Mehrotra) for min 1/2 x'diag(q)x + c'x, E x = w, G x <= h.
struct Interior {
  Vector x;
  bool converged = false;
};
Interior interior_point(const Vector& q, const Vector& c, const Matrix& e, const Vector& w, const Matrix& g,
                        const Vector& h);

/// The cheapest unknowns within the limits.
Interior solve_limited(const Program& program);

/// The factor on all (finite, positive) limits at which the task becomes possible.
std::optional<Real> needed_factor(const Program& program);

Real cost(const Program& program, const Vector& x);

/// Repeatable random problems.
class Dice {
 public:
  explicit Dice(unsigned seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_()) / 4294967296.0);
  }
  double log_uniform(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }
  int below(int n) { return static_cast<int>(engine_() % static_cast<unsigned>(n)); }
  Vec3 vector(double reach) {
    return {uniform(-reach, reach), uniform(-reach, reach), uniform(-reach, reach)};
  }
  Wrench wrench(double force_n, double torque_nm) { return {vector(force_n), vector(torque_nm)}; }

 private:
  std::mt19937 engine_;
};

}  // namespace reference
