// Inverse kinematics of the LWR 4+: the closed form against KDL's Levenberg-Marquardt with restarts. Both get
// the same poses, have to stay within the joint limits, and are checked before they are timed.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <ctime>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolverpos_lma.hpp>
#include <numbers>
#include <optional>
#include <vector>

#include "../unit/planner/kdl/kdl_chain.hpp"
#include "planner/motion/inverse_kinematics/arm_ik.hpp"
#include "planner/motion/joint_random.hpp"

namespace {

using namespace colift;
using hal::JointVector;
using hal::Pose;

constexpr int kPoses = 1000;
constexpr int kMostRestarts = 100;
/// What KDL's default accuracy and weights give (m, entries of the rotation matrix).
constexpr double kExact_m = 2e-5, kExactRotation = 2e-3;

const planner::ArmGeometry& arm() {
  static const planner::ArmGeometry geometry = planner::arm_geometry(hal::built_in_robot()).value();
  return geometry;
}

planner::JointBox limits() {
  return {arm().lower_rad, arm().upper_rad};
}

const std::vector<Pose>& poses() {
  static const std::vector<Pose> all = [] {
    planner::JointRandom random(42);
    std::vector<Pose> out;
    for (int i = 0; i < kPoses; ++i) out.push_back(planner::flange_pose(arm(), random.in(limits())));
    return out;
  }();
  return all;
}

/// KDL from random starts until a solution lies within the limits. KDL knows no limits: what it finds is
/// brought into one turn first.
class Kdl {
 public:
  std::optional<JointVector> solve(const Pose& X_WF) {
    const KDL::Frame goal = test::to_kdl(X_WF);
    for (int i = 0; i < kMostRestarts; ++i) {
      KDL::JntArray found(hal::kArmJoints);
      if (solver_.CartToJnt(test::to_kdl(random_.in(limits())), goal, found) < 0) continue;
      JointVector q = found.data;
      for (int j = 0; j < hal::kArmJoints; ++j) q[j] = std::remainder(q[j], 2.0 * std::numbers::pi);
      if (limits().contains(q)) return q;
    }
    return std::nullopt;
  }

 private:
  KDL::Chain chain_ = test::lwr_chain();
  KDL::ChainIkSolverPos_LMA solver_{chain_};
  planner::JointRandom random_{7};
};

/// First solution over 36 elbow angles: the same question that KDL answers.
std::optional<JointVector> first_closed_form(const Pose& X_WF) {
  std::array<planner::IkSolution, 8> found;
  for (int i = 0; i < 36; ++i) {
    if (planner::solve_ik(arm(), X_WF, i * 2.0 * std::numbers::pi / 36, 0.0, found) > 0)
      return found[0].q_rad;
  }
  const auto all = planner::all_ik(arm(), X_WF, 0.0);
  return all.empty() ? std::nullopt : std::optional(all.front().q_rad);
}

struct Outcome {
  int solved = 0;
  double us_per_pose = 0.0;
};

template <class Solve>
Outcome run(Solve solve) {
  Outcome out;
  std::vector<std::optional<JointVector>> answers;
  const std::clock_t start = std::clock();
  for (const Pose& X_WF : poses()) answers.push_back(solve(X_WF));
  out.us_per_pose = 1e6 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC / kPoses;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (!answers[i]) continue;
    const Pose X = planner::flange_pose(arm(), *answers[i]);
    const double off_m = (X.translation() - poses()[i].translation()).norm();
    const double turned = (X.linear() - poses()[i].linear()).cwiseAbs().maxCoeff();
    if (off_m > kExact_m || turned > kExactRotation || !limits().contains(*answers[i])) {
      fmt::print(stderr, "pose {}: a solution is {} m and {} in rotation off, or outside the limits\n", i,
                 off_m, turned);
      std::exit(1);
    }
    ++out.solved;
  }
  return out;
}

std::optional<JointVector> best_of_all(const Pose& X_WF) {
  const auto all = planner::all_ik(arm(), X_WF, 0.0);
  return all.empty() ? std::nullopt : std::optional(all.front().q_rad);
}

void compare() {
  Kdl kdl;
  const Outcome theirs = run([&](const Pose& X) { return kdl.solve(X); });
  const Outcome first = run(first_closed_form), all = run(best_of_all);
  fmt::print("{} reachable poses          solved   us per pose   ratio\n", kPoses);
  const auto row = [&](const char* name, const Outcome& o) {
    fmt::print("{:<30} {:>4.1f} %   {:>10.2f}   {:>6.1f}\n", name, 100.0 * o.solved / kPoses, o.us_per_pose,
               theirs.us_per_pose / o.us_per_pose);
  };
  row("KDL LMA, restarts, one answer", theirs);
  row("closed form, one answer", first);
  row("closed form, all, best first", all);
  if (first.solved != kPoses || all.solved != kPoses) std::exit(1);
}

void closed_form_one_elbow_angle(benchmark::State& state) {
  std::array<planner::IkSolution, 8> found;
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(planner::solve_ik(arm(), poses()[i], 0.3, 0.0, found));
    i = (i + 1) % poses().size();
  }
}
BENCHMARK(closed_form_one_elbow_angle);

void closed_form_all(benchmark::State& state) {
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(planner::all_ik(arm(), poses()[i], 0.0));
    i = (i + 1) % poses().size();
  }
}
BENCHMARK(closed_form_all);

void kdl_lma_with_restarts(benchmark::State& state) {
  Kdl kdl;
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(kdl.solve(poses()[i]));
    i = (i + 1) % poses().size();
  }
}
BENCHMARK(kdl_lma_with_restarts);

}  // namespace

int main(int argc, char** argv) {
  compare();
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
