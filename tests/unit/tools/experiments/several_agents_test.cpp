#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <random>

#include "hal/types/units.hpp"
#include "planner/grasp/task_choice.hpp"
#include "planner/load_sharing/several_agents.hpp"

using namespace colift::planner;

namespace {

Eigen::Matrix3d skew(const Vec3& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// the quadratic program as it stands: all unknowns and multipliers in one dense system
double dense_cost(const std::vector<CarryingAgent>& agents, const Wrench& task, std::vector<Wrench>& out) {
  const auto n = static_cast<Eigen::Index>(agents.size());
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(6 * n + 6, 6 * n + 6);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(6 * n + 6);
  for (Eigen::Index i = 0; i < n; ++i) {
    const CarryingAgent& a = agents[static_cast<std::size_t>(i)];
    K.block<3, 3>(6 * i, 6 * i) = 2 * a.force_weight * Eigen::Matrix3d::Identity();
    K.block<3, 3>(6 * i + 3, 6 * i + 3) =
        2 * a.force_weight * a.omega_per_m * a.omega_per_m * Eigen::Matrix3d::Identity();
    Eigen::Matrix<double, 6, 6> G = Eigen::Matrix<double, 6, 6>::Identity();
    G.block<3, 3>(3, 0) = skew(a.position);
    K.block<6, 6>(6 * n, 6 * i) = G;
    K.block<6, 6>(6 * i, 6 * n) = G.transpose();
  }
  b.segment<3>(6 * n) = task.force;
  b.segment<3>(6 * n + 3) = task.torque;
  const Eigen::VectorXd x = K.fullPivLu().solve(b);
  double cost = 0.0;
  out.resize(agents.size());
  for (Eigen::Index i = 0; i < n; ++i) {
    const CarryingAgent& a = agents[static_cast<std::size_t>(i)];
    Wrench& w = out[static_cast<std::size_t>(i)];
    w.force = x.segment<3>(6 * i);
    w.torque = x.segment<3>(6 * i + 3);
    cost += a.force_weight * (w.force.squaredNorm() + a.omega_per_m * a.omega_per_m * w.torque.squaredNorm());
  }
  return cost;
}

}  // namespace

TEST_CASE("any number of agents: the closed form is the dense solution", "[agents]") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-1.0, 1.0), cost_weight(0.3, 3.0), omega(1.0, 25.0);
  for (int n = 1; n <= 6; ++n)
    for (int repeat = 0; repeat < 20; ++repeat) {
      std::vector<CarryingAgent> agents;
      for (int i = 0; i < n; ++i)
        agents.push_back({{place(random), place(random), place(random)}, cost_weight(random), omega(random)});
      const Wrench task{{place(random), place(random), 40.0}, {place(random), place(random), place(random)}};
      const auto made = SeveralAgents::create(agents);
      REQUIRE(made);
      std::vector<Wrench> dense, closed(agents.size());
      const double cost = dense_cost(agents, task, dense);
      CHECK(made->cost(std::vector<Wrench>{task}) == Approx(cost).epsilon(1e-9));
      made->wrenches(task, closed);
      double shares = 0.0;
      for (std::size_t i = 0; i < agents.size(); ++i) {
        CHECK((closed[i].force - dense[i].force).norm() < 1e-8);
        CHECK((closed[i].torque - dense[i].torque).norm() < 1e-8);
        shares += made->share(i, task);
      }
      CHECK(shares == Approx(1.0));
    }
}

TEST_CASE("for two agents it is the load sharing of the thesis", "[agents]") {
  const SharingWeights weights{0.8, 12.0, 20.0};
  const auto two = LoadSharing::create(weights);
  const Vec3 p1(0.4, 0.1, 0.0), p2(-0.3, 0.2, 0.1);
  const Wrench task{{1.0, 2.0, 30.0}, {0.5, -0.2, 0.1}};
  const auto made = SeveralAgents::create({{p1, 1.0, 12.0}, {p2, 0.64, 20.0}});
  REQUIRE(made);
  CHECK(made->cost(std::vector<Wrench>{task}) == Approx(two->cost(p1, p2, task)).epsilon(1e-12));
}

TEST_CASE("beside several others the robot goes where all together need least", "[agents]") {
  // two people at one end of a table: beside one of them alone the robot would go straight across
  const std::vector<Wrench> lift{{{0.0, 0.0, 40.0}, Vec3::Zero()}};
  std::vector<GraspCandidate> candidates(4);
  candidates[0].position = {-0.4, -0.3, 0.0};
  candidates[1].position = {-0.4, 0.0, 0.0};
  candidates[2].position = {-0.4, 0.3, 0.0};
  candidates[3].position = {0.4, 0.25, 0.0};  // where a person is
  const CarryingAgent first{{0.4, 0.3, 0.0}}, second{{0.4, -0.3, 0.0}}, robot;
  const auto alone = choose_beside(candidates, {&first, 1}, robot, Vec3::Zero(), lift, 0.15);
  REQUIRE(alone);
  CHECK(alone->best == 0u);
  const auto both = choose_beside(candidates, std::vector{first, second}, robot, Vec3::Zero(), lift, 0.15);
  REQUIRE(both);
  CHECK(both->best == 1u);
  for (std::size_t i = 0; i < candidates.size(); ++i) CHECK(both->costs[i] >= both->costs[1] - 1e-12);
  // beside one it is the choice for a task of the thesis
  const SharingWeights weights;
  const auto pair =
      choose_for_task(candidates, first.position, Vec3::Zero(), Vec3::UnitZ(), {TaskPose{}},
                      {4.0 / colift::hal::kGravity_m_s2 * 10.0, Eigen::Matrix3d::Zero()}, weights);
  REQUIRE(pair);
  for (std::size_t i = 0; i < candidates.size(); ++i)
    CHECK(alone->costs[i] == Approx(pair->costs[i]).epsilon(1e-9));
  // who is refused is not chosen, and nobody is put on another's hand
  candidates[0].verdict = Verdict::Unreachable;
  CHECK(choose_beside(candidates, {&first, 1}, robot, Vec3::Zero(), lift, 0.15)->best == 1u);
  for (int i = 0; i < 3; ++i) candidates[static_cast<std::size_t>(i)].verdict = Verdict::Collision;
  CHECK_FALSE(choose_beside(candidates, {&first, 1}, robot, Vec3::Zero(), lift, 0.15)->best);
  CHECK_FALSE(choose_beside(candidates, {&first, 1}, robot, Vec3::Zero(), {}, 0.15));
}

TEST_CASE("prices that mean nothing are refused", "[agents]") {
  CHECK_FALSE(SeveralAgents::create({}));
  CHECK_FALSE(SeveralAgents::create({{Vec3::Zero(), 0.0}}));
  CHECK_FALSE(SeveralAgents::create({{Vec3::Zero(), 1.0, 0.0}}));
  CHECK_FALSE(SeveralAgents::create({{Vec3(NAN, 0, 0)}}));
}

TEST_CASE("the choice for a task beats the choice for its lift alone", "[task]") {
  // the table is lifted, then turned on its side about the line between the hands
  const Vec3 up = Vec3::UnitZ(), cog = Vec3::Zero(), partner(0.4, 0.0, 0.15);
  std::vector<GraspCandidate> candidates(2);
  candidates[0].position = {-0.4, 0.0, 0.15};  // in line seen from above; both hang beside once it is turned
  candidates[1].position = {-0.4, 0.03, -0.15};  // a little beside, but in line through the centre of gravity
  const CarriedBody body{4.0, Eigen::Vector3d(0.1, 0.3, 0.35).asDiagonal()};
  const Task lift = lift_task(up);
  Task whole = lift;
  for (const Task& part :
       {tilt_task(Vec3::UnitX(), 1.2), carry_task(std::vector<Vec3>{{0, 0, 0}, {0.5, 0, 0}}, 2.0),
        yaw_task(up, 0.5), lower_task(up)})
    whole.insert(whole.end(), part.begin(), part.end());
  const auto for_lift = choose_for_task(candidates, partner, cog, up, lift, body, {});
  const auto for_whole = choose_for_task(candidates, partner, cog, up, whole, body, {});
  REQUIRE(for_lift);
  REQUIRE(for_whole);
  REQUIRE(for_lift->best == 0u);
  REQUIRE(for_whole->best == 1u);
  CHECK(for_whole->costs[1] < for_whole->costs[0]);
  CHECK_FALSE(choose_for_task(candidates, partner, cog, up, {}, body, {}));
}

TEST_CASE("a turned object asks for the same weight in its own axes", "[task]") {
  const Task turned = tilt_task(Vec3::UnitX(), 1.5707963267948966, 1);
  const auto w = task_wrenches(turned, {2.0, Eigen::Matrix3d::Zero()}, Vec3::UnitZ());
  REQUIRE(w.size() == 1);
  CHECK(w[0].force.norm() == Approx(2.0 * colift::hal::kGravity_m_s2));
  CHECK(w[0].force.y() == Approx(2.0 * colift::hal::kGravity_m_s2));
}
