#include "planner/load_sharing/load_sharing.hpp"

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>
#include <vector>

#include "reference.hpp"

using namespace colift::planner;
using reference::Dice;
using reference::Real;

namespace {

LoadSharing sharing(double epsilon, double omega1, double omega2) {
  return LoadSharing::create({epsilon, omega1, omega2}).value();
}

double off_balance(const AgentWrenches& w, const Vec3& p1, const Vec3& p2, const Wrench& task) {
  const Vec3 force = w.partner.force + w.robot.force - task.force;
  const Vec3 torque =
      p1.cross(w.partner.force) + w.partner.torque + p2.cross(w.robot.force) + w.robot.torque - task.torque;
  return std::max(force.norm(), torque.norm()) /
         (task.force.norm() * (1.0 + p1.norm() + p2.norm()) + task.torque.norm());
}

double relative(double a, double b) {
  return std::abs(a - b) / std::max(std::abs(a), std::abs(b));
}

double relative(const AgentWrenches& a, const reference::Vector& x) {
  reference::Vector y(12);
  y << a.partner.force.cast<Real>(), a.partner.torque.cast<Real>(), a.robot.force.cast<Real>(),
      a.robot.torque.cast<Real>();
  return static_cast<double>((x - y).norm() / x.norm());
}

}  // namespace

TEST_CASE("the closed form is the solution of the thesis's program", "[load_sharing]") {
  Dice dice(1);
  double worst_cost = 0, worst_wrench = 0, worst_balance = 0, worst_weight = 0;
  for (int i = 0; i < 10000; ++i) {
    const SharingWeights weights{dice.log_uniform(0.2, 5.0), dice.log_uniform(0.5, 30.0),
                                 dice.log_uniform(0.5, 30.0)};
    const Vec3 p1 = dice.vector(1.0), p2 = dice.vector(1.0);
    const Wrench task = dice.wrench(100.0, 20.0);
    const auto model = LoadSharing::create(weights).value();
    const auto program = reference::make_program(weights, {}, p1, p2, task);
    const auto x = reference::solve_kkt(program);
    const auto w = model.wrenches(p1, p2, task);
    worst_cost = std::max(
        worst_cost, relative(model.cost(p1, p2, task), static_cast<double>(reference::cost(program, x))));
    worst_weight = std::max(worst_weight, relative(model.cost(p1, p2, task), model.cost_weight(w)));
    worst_wrench = std::max(worst_wrench, relative(w, x));
    worst_balance = std::max(worst_balance, off_balance(w, p1, p2, task));
  }
  CHECK(worst_cost < 1e-12);
  CHECK(worst_weight < 1e-12);
  CHECK(worst_wrench < 1e-12);
  CHECK(worst_balance < 1e-14);
}

TEST_CASE("the closed form keeps nine digits where scales are nasty", "[load_sharing]") {
  // epsilon over 8 decades, omega over 8, hands from a millimetre to 100 m apart and far from the centre of
  // gravity
  Dice dice(2);
  double worst_cost = 0;
  for (int i = 0; i < 2000; ++i) {
    const SharingWeights weights{dice.log_uniform(1e-4, 1e4), dice.log_uniform(1e-4, 1e4),
                                 dice.log_uniform(1e-4, 1e4)};
    const Vec3 p1 = dice.vector(dice.log_uniform(0.01, 100.0));
    const Vec3 p2 = dice.below(2) ? Vec3(p1 + dice.vector(1e-3)) : dice.vector(dice.log_uniform(0.01, 100.0));
    const Wrench task = dice.wrench(dice.log_uniform(1e-3, 1e5), dice.log_uniform(1e-3, 1e5));
    const auto model = LoadSharing::create(weights).value();
    const double expected = reference::cost_by_quad_kkt(reference::make_program(weights, {}, p1, p2, task));
    worst_cost = std::max(worst_cost, relative(model.cost(p1, p2, task), expected));
  }
  CHECK(worst_cost < 1e-10);
}

TEST_CASE("a lift of 40 N between equal agents costs 800 and is shared by half", "[load_sharing]") {
  const auto model = sharing(1, 1, 1);
  const Wrench lift{{0, 0, 40}, Vec3::Zero()};
  CHECK(model.cost({-0.4, 0, 0}, {0.4, 0, 0}, lift) == Approx(800.0).epsilon(1e-14));
  const auto w = model.wrenches({-0.4, 0, 0}, {0.4, 0, 0}, lift);
  CHECK(w.robot.force.isApprox(Vec3(0, 0, 20), 1e-14));
  CHECK(w.robot.torque.norm() < 1e-13);
}

TEST_CASE("several poses cost the sum of each", "[load_sharing]") {
  Dice dice(3);
  const auto model = sharing(0.7, 12, 20);
  for (int i = 0; i < 100; ++i) {
    const Vec3 p1 = dice.vector(1), p2 = dice.vector(1);
    std::vector<Wrench> tasks;
    double sum = 0;
    for (int k = 0; k < 7; ++k) {
      tasks.push_back(dice.wrench(50, 10));
      sum += model.cost(p1, p2, tasks.back());
    }
    CHECK(model.cost(p1, p2, tasks) == Approx(sum).epsilon(1e-14));
  }
}

TEST_CASE("the flat arrays give what one at a time gives", "[load_sharing]") {
  Dice dice(4);
  for (const auto& model : {sharing(0.7, 12, 20), sharing(1, 0, 3), sharing(2, 0, 0)}) {
    std::vector<double> x, y, z;
    for (int i = 0; i < 101; ++i) {
      const Vec3 p = dice.vector(1);
      x.push_back(p.x());
      y.push_back(p.y());
      z.push_back(p.z());
    }
    const Vec3 p1 = dice.vector(1);
    const std::vector<Wrench> tasks{dice.wrench(50, 10), dice.wrench(50, 10), dice.wrench(5, 0)};
    std::vector<double> out(x.size());
    model.costs(p1, x, y, z, tasks, out);
    for (std::size_t i = 0; i < x.size(); ++i) {
      CHECK(out[i] == Approx(model.cost(p1, {x[i], y[i], z[i]}, tasks)).epsilon(1e-13));
    }
  }
}

TEST_CASE("the cost does not depend on the frame", "[load_sharing]") {
  Dice dice(5);
  double rotated = 0, moved = 0, scaled = 0;
  for (int i = 0; i < 1000; ++i) {
    const auto model =
        sharing(dice.log_uniform(0.3, 3), dice.log_uniform(0.5, 30), dice.log_uniform(0.5, 30));
    const Vec3 p1 = dice.vector(1), p2 = dice.vector(1), shift = dice.vector(2);
    const Wrench task = dice.wrench(100, 20);
    const double cost = model.cost(p1, p2, task);

    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(dice.uniform(-3, 3), dice.vector(1).normalized()).toRotationMatrix();
    rotated = std::max(
        rotated, relative(cost, model.cost(turn * p1, turn * p2, {turn * task.force, turn * task.torque})));

    // the same forces seen from another origin: torque is moved with them
    const Wrench seen{task.force, task.torque + shift.cross(task.force)};
    moved = std::max(moved, relative(cost, model.cost(p1 + shift, p2 + shift, seen)));

    const double k = dice.uniform(-5, 5);
    scaled = std::max(scaled, relative(k * k * cost, model.cost(p1, p2, {k * task.force, k * task.torque})));
  }
  CHECK(rotated < 1e-12);
  CHECK(moved < 1e-12);
  CHECK(scaled < 1e-13);
}

TEST_CASE("exchanging the agents exchanges their wrenches", "[load_sharing]") {
  Dice dice(6);
  for (int i = 0; i < 200; ++i) {
    const double e = dice.log_uniform(0.3, 3), w1 = dice.log_uniform(0.5, 30), w2 = dice.log_uniform(0.5, 30);
    const Vec3 p1 = dice.vector(1), p2 = dice.vector(1);
    const Wrench task = dice.wrench(100, 20);
    const auto a = sharing(e, w1, w2).wrenches(p1, p2, task),
               b = sharing(1 / e, w2, w1).wrenches(p2, p1, task);
    CHECK(a.partner.force.isApprox(b.robot.force, 1e-11));
    CHECK(a.robot.torque.isApprox(b.partner.torque, 1e-11));
    CHECK(sharing(e, w1, w2).cost(p1, p2, task) ==
          Approx(e * e * sharing(1 / e, w2, w1).cost(p2, p1, task)).epsilon(1e-12));
  }
}

TEST_CASE("no wrenches that balance the task are cheaper", "[load_sharing]") {
  Dice dice(7);
  for (int i = 0; i < 500; ++i) {
    const auto model =
        sharing(dice.log_uniform(0.3, 3), dice.below(3) ? 10.0 : 0.0, dice.below(3) ? 5.0 : 0.0);
    const Vec3 p1 = dice.vector(1), p2 = dice.vector(1);
    const Wrench task = dice.wrench(100, 20);
    auto w = model.wrenches(p1, p2, task);
    const double best = model.cost_weight(w);
    CHECK(best == Approx(model.cost(p1, p2, task)).epsilon(1e-10));
    const Vec3 df = dice.vector(5), dt = dice.vector(2);
    w.partner.force += df;
    w.robot.force -= df;
    w.partner.torque += dt - (p1 - p2).cross(df);
    w.robot.torque -= dt;
    CHECK(off_balance(w, p1, p2, task) < 1e-13);
    CHECK(model.cost_weight(w) >= best * (1 - 1e-12));
  }
}

TEST_CASE("two hands at one place share all torque by their prices", "[load_sharing]") {
  const auto model = sharing(1, 2, 2);
  const Vec3 p(0.3, -0.2, 0.1);
  const Wrench task{{0, 0, 40}, {0, 0, 0}};
  const Vec3 torque = -p.cross(task.force);
  const auto w = model.wrenches(p, p, task);
  CHECK(w.partner.torque.isApprox(0.5 * torque, 1e-14));
  CHECK(w.robot.torque.isApprox(0.5 * torque, 1e-14));
  CHECK(model.cost(p, p, task) == Approx(800 + 0.5 * 4 * torque.squaredNorm()).epsilon(1e-14));
}

TEST_CASE("torque that costs nothing is the limit of torque that costs little", "[load_sharing]") {
  Dice dice(8);
  const double tiny = 1e-7;
  for (int i = 0; i < 300; ++i) {
    const double e = dice.log_uniform(0.3, 3);
    const Vec3 p1 = dice.vector(1), p2 = i % 10 == 0 ? p1 : dice.vector(1);
    const Wrench task = dice.wrench(100, 20);
    for (const auto& [w1, w2] : {std::pair{0.0, 7.0}, std::pair{7.0, 0.0}, std::pair{0.0, 0.0}}) {
      const auto exact = sharing(e, w1, w2), near = sharing(e, w1 > 0 ? w1 : tiny, w2 > 0 ? w2 : tiny);
      CHECK(exact.cost(p1, p2, task) ==
            Approx(e * e / (1 + e * e) * task.force.squaredNorm()).epsilon(1e-14));
      CHECK(near.cost(p1, p2, task) == Approx(exact.cost(p1, p2, task)).epsilon(1e-9));
      const auto a = exact.wrenches(p1, p2, task), b = near.wrenches(p1, p2, task);
      CHECK((a.partner.torque - b.partner.torque).norm() < 1e-8 * 200);
      CHECK((a.robot.torque - b.robot.torque).norm() < 1e-8 * 200);
      CHECK(off_balance(a, p1, p2, task) < 1e-14);
    }
  }
}

TEST_CASE("the asked share is what the robot carries at the best place", "[load_sharing]") {
  for (const double share : {0.001, 0.2, 0.5, 0.75, 0.999}) {
    const auto model = sharing(epsilon_for_share(share).value(), 20, 20);
    const Vec3 partner(-0.4, 0.1, 0.2), best = model.best_robot_position(partner);
    const Wrench lift{{0, 0, 40}, Vec3::Zero()};
    const auto w = model.wrenches(partner, best, lift);
    CHECK(w.robot.force.z() / 40 == Approx(share).epsilon(1e-12));
    CHECK(w.robot.torque.norm() < 1e-12);
    CHECK(model.cost(partner, best, lift) <= model.cost(partner, best + Vec3(0.02, 0, 0), lift));
  }
  for (const double bad : {0.0, 1.0, -0.5, 2.0, std::numeric_limits<double>::quiet_NaN()}) {
    REQUIRE_FALSE(epsilon_for_share(bad));
    CHECK(epsilon_for_share(bad).error().code == colift::hal::ErrorCode::BadInput);
  }
}

TEST_CASE("weights without meaning are refused by name", "[load_sharing]") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const auto& [weights, name] : {std::pair{SharingWeights{0, 1, 1}, "weights.epsilon"},
                                      {SharingWeights{-1, 1, 1}, "weights.epsilon"},
                                      {SharingWeights{1, -2, 1}, "weights.omega1"},
                                      {SharingWeights{1, 1, nan}, "weights.omega2"},
                                      {SharingWeights{inf, 1, 1}, "weights.epsilon"},
                                      {SharingWeights{1, 1e-200, 1}, "weights.omega1"}}) {
    const auto refused = LoadSharing::create(weights);
    REQUIRE_FALSE(refused);
    CHECK(refused.error().where == name);
    CHECK(refused.error().code == colift::hal::ErrorCode::BadInput);
  }
}
