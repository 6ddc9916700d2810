#include "planner/load_sharing/load_limits.hpp"

#include <catch2/catch.hpp>

#include <cmath>

#include "reference.hpp"

using namespace colift::planner;
using reference::Dice;
using reference::Real;

namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

struct Case {
  SharingWeights weights;
  SharingLimits limits;
  Vec3 p1, p2;
  Wrench task;

  [[nodiscard]] LimitedSharing model() const {
    return LimitedSharing::create(LoadSharing::create(weights).value(), limits).value();
  }
  [[nodiscard]] reference::Program program() const {
    return reference::make_program(weights, limits, p1, p2, task);
  }
};

/// Limits of the size of the unlimited answer, so that most problems have several active and some none.
Case random_case(Dice& dice, double zero_omega = 0.0) {
  Case c;
  c.weights.epsilon = dice.log_uniform(0.3, 3.0);
  c.weights.omega1_per_m = dice.uniform(0, 1) < zero_omega ? 0.0 : dice.log_uniform(0.5, 30.0);
  c.weights.omega2_per_m = dice.uniform(0, 1) < zero_omega ? 0.0 : dice.log_uniform(0.5, 30.0);
  c.p1 = dice.vector(0.8);
  c.p2 = dice.vector(0.8);
  c.task = dice.wrench(60.0, 10.0);
  if (dice.below(4) == 0) {  // a pure lift between hands on the axes
    c.task = {{0, 0, dice.uniform(10, 60)}, Vec3::Zero()};
    c.p1 = {-dice.uniform(0.1, 0.8), 0, 0};
    c.p2 = {dice.uniform(0.1, 0.8), dice.below(2) ? 0.0 : dice.uniform(-0.2, 0.2), 0};
  }
  if (dice.below(20) == 0) c.p2 = c.p1;
  const double f = c.task.force.cwiseAbs().maxCoeff(), t = c.task.torque.norm() + 0.3 * f;
  c.limits.partner = {f * dice.uniform(0.3, 1.2), t * dice.log_uniform(0.05, 2.0)};
  c.limits.robot = {f * dice.uniform(0.3, 1.2), t * dice.log_uniform(0.05, 2.0)};
  for (double* limit : {&c.limits.partner.force_n, &c.limits.partner.torque_nm, &c.limits.robot.force_n,
                        &c.limits.robot.torque_nm}) {
    if (dice.below(8) == 0) *limit = kInf;
  }
  return c;
}

int active(const AgentWrenches& w, const SharingLimits& l) {
  int n = 0;
  for (int k = 0; k < 3; ++k) {
    n += std::abs(w.partner.force[k]) > l.partner.force_n * (1 - 1e-9);
    n += std::abs(w.robot.force[k]) > l.robot.force_n * (1 - 1e-9);
    n += std::abs(w.partner.torque[k]) > l.partner.torque_nm * (1 - 1e-9);
    n += std::abs(w.robot.torque[k]) > l.robot.torque_nm * (1 - 1e-9);
  }
  return n;
}

double over_limit(const AgentWrenches& w, const SharingLimits& l) {
  return std::max({w.partner.force.cwiseAbs().maxCoeff() - l.partner.force_n,
                   w.robot.force.cwiseAbs().maxCoeff() - l.robot.force_n,
                   w.partner.torque.cwiseAbs().maxCoeff() - l.partner.torque_nm,
                   w.robot.torque.cwiseAbs().maxCoeff() - l.robot.torque_nm});
}

double off_balance(const AgentWrenches& w, const Case& c) {
  const Vec3 force = w.partner.force + w.robot.force - c.task.force;
  const Vec3 torque = c.p1.cross(w.partner.force) + w.partner.torque + c.p2.cross(w.robot.force) +
                      w.robot.torque - c.task.torque;
  return std::max(force.norm(), torque.norm()) / (c.task.force.norm() + c.task.torque.norm());
}

struct Tally {
  int compared = 0, several = 0, infeasible = 0, unsettled = 0;
  double worst_cost = 0, worst_slow = 0, worst_balance = 0, worst_over = 0;
};

Tally compare(Dice& dice, int count, double zero_omega) {
  Tally t;
  for (int i = 0; i < count; ++i) {
    const Case c = random_case(dice, zero_omega);
    const auto model = c.model();
    const auto w = model.wrenches(c.p1, c.p2, c.task);
    const auto program = c.program();
    if (!w) {
      ++t.infeasible;
      continue;
    }
    const double cost_weight = model.sharing().cost_weight(*w);
    t.worst_balance = std::max(t.worst_balance, off_balance(*w, c));
    t.worst_over = std::max(t.worst_over, over_limit(*w, c.limits));
    if (i % 4 == 0) {
      const double slow = model.sharing().cost_weight(model.wrenches_by_enumeration(c.p1, c.p2, c.task));
      t.worst_slow = std::max(t.worst_slow, std::abs(slow - cost_weight) / cost_weight);
    }
    const auto r = reference::solve_limited(program);
    if (!r.converged) {
      ++t.unsettled;
      continue;
    }
    ++t.compared;
    t.several += active(*w, c.limits) >= 3;
    const double expected = static_cast<double>(reference::cost(program, r.x));
    const double error = std::abs(cost_weight - expected) / expected;
    if (error > 1e-6) {
      CAPTURE(i, cost_weight, expected, c.weights.epsilon, c.weights.omega1_per_m, c.weights.omega2_per_m);
      CHECK(error <= 1e-6);
    }
    t.worst_cost = std::max(t.worst_cost, error);
  }
  return t;
}

}  // namespace

TEST_CASE("the best wrenches within limits are those of an interior point method", "[load_limits]") {
  Dice dice(11);
  const Tally t = compare(dice, 4000, 0.0);
  CAPTURE(t.compared, t.several, t.infeasible, t.unsettled);
  CHECK(t.compared > 2000);
  CHECK(t.several > 400);
  CHECK(t.unsettled < 40);
  CHECK(t.worst_cost < 1e-8);
  CHECK(t.worst_slow < 1e-9);
  CHECK(t.worst_balance < 1e-12);
  CHECK(t.worst_over <= 0.0);
}

TEST_CASE("limits hold where torque costs nothing", "[load_limits]") {
  Dice dice(12);
  const Tally t = compare(dice, 1500, 0.6);
  CAPTURE(t.compared, t.several, t.infeasible, t.unsettled);
  CHECK(t.compared > 700);
  CHECK(t.unsettled < 40);
  CHECK(t.worst_cost < 1e-8);
  CHECK(t.worst_slow < 1e-9);
  CHECK(t.worst_balance < 1e-12);
  CHECK(t.worst_over <= 0.0);
}

TEST_CASE("what is possible changes exactly where a linear program says", "[load_limits]") {
  Dice dice(13);
  int compared = 0;
  for (int i = 0; i < 1500; ++i) {
    Case c = random_case(dice);
    const auto factor = reference::needed_factor(c.program());
    if (!factor || *factor < 1e-6L) continue;
    ++compared;
    const auto scaled = [&](double by) {
      Case s = c;
      for (double* limit : {&s.limits.partner.force_n, &s.limits.partner.torque_nm, &s.limits.robot.force_n,
                            &s.limits.robot.torque_nm}) {
        *limit *= by * static_cast<double>(*factor);
      }
      return s;
    };
    CAPTURE(i, static_cast<double>(*factor));
    const Case roomy = scaled(1 + 1e-8), tight = scaled(1 - 1e-8);
    const auto w = roomy.model().wrenches(c.p1, c.p2, c.task);
    REQUIRE(w);
    CHECK(off_balance(*w, roomy) < 1e-11);
    CHECK(over_limit(*w, roomy.limits) <= 0.0);
    const auto missing = tight.model().shortfall(c.p1, c.p2, c.task);
    REQUIRE(missing);
    CHECK(missing->needed > missing->partner + missing->robot);
    CHECK_FALSE(tight.model().wrenches(c.p1, c.p2, c.task));
  }
  CHECK(compared > 1000);
}

TEST_CASE("limits that nothing reaches change nothing", "[load_limits]") {
  Dice dice(14);
  for (int i = 0; i < 200; ++i) {
    Case c = random_case(dice);
    c.limits = i % 2 ? SharingLimits{} : SharingLimits{{1e6, 1e6}, {1e6, 1e6}};
    const auto w = c.model().wrenches(c.p1, c.p2, c.task);
    REQUIRE(w);
    const auto plain = LoadSharing::create(c.weights)->wrenches(c.p1, c.p2, c.task);
    CHECK(w->partner.force == plain.partner.force);
    CHECK(w->robot.torque == plain.robot.torque);
  }
}

TEST_CASE("limits that just suffice are enough", "[load_limits]") {
  const auto sharing = LoadSharing::create(SharingWeights::thesis()).value();
  const Vec3 p1(-0.4, 0, 0), p2(0.4, 0, 0);
  // sums that do not round to themselves
  for (const double part : {0.1, 0.3, 0.7, 20.0, 13.3}) {
    const double load = part + 2 * part;
    const auto model = LimitedSharing::create(sharing, {{part, 50}, {2 * part, 50}}).value();
    const auto w = model.wrenches(p1, p2, {{0, 0, load}, Vec3::Zero()});
    REQUIRE(w);
    CHECK(w->partner.force.z() == Approx(part).epsilon(1e-12));
    CHECK(w->robot.force.z() == Approx(2 * part).epsilon(1e-12));
  }
  // nobody can turn, and nobody has to
  const auto points = LimitedSharing::create(sharing, {{30, 0}, {30, 0}}).value();
  const auto w = points.wrenches(p1, p2, {{0, 0, 40}, Vec3::Zero()});
  REQUIRE(w);
  CHECK(w->partner.force.z() == Approx(20).epsilon(1e-12));
  CHECK(w->partner.torque.norm() < 1e-12);
}

TEST_CASE("one limit alone is enough to ask for", "[load_limits]") {
  const auto sharing = LoadSharing::create(SharingWeights::thesis()).value();
  const Vec3 p1(-0.4, 0, 0), p2(0.4, 0, 0);
  const Wrench lift{{0, 0, 40}, Vec3::Zero()};
  const auto only = [&](SharingLimits limits) {
    return LimitedSharing::create(sharing, limits).value().wrenches(p1, p2, lift).value();
  };
  CHECK(only({{15, kInf}, {}}).partner.force.z() == Approx(15).epsilon(1e-12));
  CHECK(only({{}, {15, kInf}}).robot.force.z() == Approx(15).epsilon(1e-12));
  CHECK(only({{}, {15, kInf}}).partner.force.z() == Approx(25).epsilon(1e-12));
  CHECK(only({{kInf, 0.5}, {}}).partner.force.z() == Approx(20).epsilon(1e-12));
}

TEST_CASE("what is missing is said with numbers", "[load_limits]") {
  const auto sharing = LoadSharing::create(SharingWeights::thesis()).value();
  const Vec3 p1(-0.4, 0, 0), p2(0.4, 0, 0);
  const auto why = [&](SharingLimits limits, const Vec3& a, const Vec3& b, const Wrench& task) {
    const auto missing = LimitedSharing::create(sharing, limits).value().shortfall(a, b, task);
    return missing ? missing->text() : std::string("nothing");
  };
  const Wrench lift{{0, 0, 40}, Vec3::Zero()};
  CHECK(why({{15, 5}, {20, 5}}, p1, p2, lift) == "needs 40 N along z; partner 15 N and robot 20 N give 35 N");
  CHECK(why({{25, 5}, {25, 5}}, p1, p2, lift) == "nothing");
  // both hands on one side, 0.2 m from the centre of gravity: 40 N x 0.2 m
  CHECK(
      why({{60, 2}, {60, 1}}, {0.2, 0, 0}, {0.2, 0, 0}, lift) ==
      "needs 8 N m about y beyond what the forces of both can do; partner 2 N m and robot 1 N m give 3 N m");
  // the load hangs beside the line through both hands, where no force helps
  CHECK(why({{60, 1}, {60, 2}}, {-0.4, 0.1, 0}, {0.4, 0.1, 0}, lift) ==
        "needs 4 N m about the line through both hands; partner 1 N m and robot 2 N m give 3 N m");
  CHECK(why({{60, 1}, {60, 1}}, {-0.4, -0.4, 0.2}, {0.4, 0.4, 0.2}, {Vec3::Zero(), {3, 3, 0}}) ==
        "needs 4.243 N m about the line through both hands; partner 1.414 N m and robot 1.414 N m give 2.828 "
        "N m");
}

TEST_CASE("limits without meaning are refused by name", "[load_limits]") {
  const auto sharing = LoadSharing::create(SharingWeights::thesis()).value();
  const auto refused = LimitedSharing::create(sharing, {{30, 5}, {60, -1}});
  REQUIRE_FALSE(refused);
  CHECK(refused.error().where == "limits.robot.torque");
  CHECK_FALSE(LimitedSharing::create(sharing, {{std::nan(""), 5}, {60, 1}}));
}
