#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>

#include "planner/load_sharing/load_sharing.hpp"

namespace colift::planner {

/// Largest magnitude of any component of what one agent can exert; infinite where nothing is known.
struct AgentLimits {
  double force_n = std::numeric_limits<double>::infinity();
  double torque_nm = std::numeric_limits<double>::infinity();

  template <class Visitor>
  void visit(Visitor& v) {
    v("force_n", force_n, hal::kNotNegative, "Max force along any axis (N).");
    v("torque_nm", torque_nm, hal::kNotNegative, "Max torque about any axis (Nm).");
  }
};

/// What both agents can exert.
struct SharingLimits {
  AgentLimits partner;
  AgentLimits robot;

  template <class Visitor>
  void visit(Visitor& v) {
    v("partner", partner, "What the partner can exert.");
    v("robot", robot, "What the robot can exert.");
  }
};

/// Why two agents at their limits cannot exert a task wrench: one direction in which it takes more than they
/// have.
struct Shortfall {
  enum class Kind {
    Force,   ///< Along `direction`, an axis.
    Torque,  ///< About `direction`, any line; what the hands' forces can contribute is already subtracted.
    TorqueOfHands,  ///< About `direction`, the line through both hands, where forces contribute nothing.
  };
  Kind kind;
  Vec3 direction;  ///< Unit vector.
  double needed;   ///< N or N m.
  double partner;  ///< Most that the partner gives.
  double robot;    ///< Most that the robot gives.

  /// One sentence: "needs 40 N along z; partner 15 N and robot 20 N give 35 N".
  [[nodiscard]] std::string text() const;
};

/// Load sharing where each component of each agent's wrench is limited.
///
/// With the robot's force as the rest of the task force, and torque split per axis at its cheapest, the
/// twelve unknowns of thesis 4.4 become three: the partner's force, in a box, with a convex piecewise
/// quadratic price on the torque about each axis. Semismooth Newton finds the active pieces, and its last
/// step is exact on them; where it does not settle, all combinations of pieces are tried. Feasibility is
/// decided beforehand by the 14 inequalities that are the extreme rays of Farkas' cone of this problem.
/// Derivation: docs/decisions/0002.
class LimitedSharing {
 public:
  /// Limits that miss what a task needs by this much (relative to the terms of the balance) count as enough.
  static constexpr double kTouch = 1e-12;

  /// Errors: BadInput for a limit that is negative or NaN.
  [[nodiscard]] static hal::Result<LimitedSharing> create(const LoadSharing& sharing,
                                                          const SharingLimits& limits);

  /// The best wrenches within the limits, nothing if there are none (shortfall() says why; it finds nothing
  /// only where the numbers are too far apart to be balanced in doubles). Equal to LoadSharing::wrenches
  /// where no limit is reached. Exact to rounding; typically 0.1 us, a rare degenerate case 0.1 ms.
  [[nodiscard]] std::optional<AgentWrenches> wrenches(const Vec3& p_partner, const Vec3& p_robot,
                                                      const Wrench& task) const;

  /// What is missing most, or nothing if the task can be done.
  [[nodiscard]] std::optional<Shortfall> shortfall(const Vec3& p_partner, const Vec3& p_robot,
                                                   const Wrench& task) const;

  /// Whether given wrenches keep all limits.
  [[nodiscard]] bool within(const AgentWrenches& w) const;

  [[nodiscard]] const LoadSharing& sharing() const { return sharing_; }
  [[nodiscard]] const SharingLimits& limits() const { return limits_; }

  /// The slow path alone, for tests: tries every combination of active limits.
  [[nodiscard]] AgentWrenches wrenches_by_enumeration(const Vec3& p_partner, const Vec3& p_robot,
                                                      const Wrench& task) const;

 private:
  struct Problem;

  LimitedSharing(const LoadSharing& sharing, const SharingLimits& limits);

  void solve(const Problem& q, const AgentWrenches& unlimited, Vec3& force, Vec3& torque) const;
  [[nodiscard]] bool newton(const Problem& q, Vec3 u, int max_steps, Vec3& force, Vec3& torque) const;
  [[nodiscard]] bool descend(const Problem& q, const AgentWrenches& unlimited, Vec3& force,
                             Vec3& torque) const;
  void enumerate(const Problem& q, Vec3& force, Vec3& torque) const;
  [[nodiscard]] double slope_scale(const Problem& q) const;
  [[nodiscard]] double torque_at(double multiplier, double free_give, double& slope) const;
  [[nodiscard]] double torque_weight(double torque) const;
  [[nodiscard]] AgentWrenches split(const Wrench& task, const Vec3& partner_force, const Vec3& torque) const;

  LoadSharing sharing_;
  SharingLimits limits_;
  double torque_sum_;  // both agents' torque limits together
  // The torque about one axis as a function of its multiplier m >= 0 (odd for m < 0):
  // give * m up to (knee_m_, knee_torque_), then first limit + second give * m up to (wall_m_, torque_sum_),
  // then flat.
  double knee_m_, knee_torque_, wall_m_;
  double first_limit_, second_give_;
};

}  // namespace colift::planner
