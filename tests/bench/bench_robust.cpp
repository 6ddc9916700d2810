// The choice over what is not known: 10 000 what-ifs of centre of gravity and partner for 300 candidates.
// First its mean is compared with that of as many independent draws through LoadSharing; a disagreement ends
// the program.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

#include "planner/grasp/robust_choice.hpp"

using namespace colift::planner;

namespace {

constexpr std::size_t kCandidates = 300;
constexpr double kCogSigma_m = 0.04, kPartnerSigma_m = 0.01;
constexpr double kAgree = 0.02;  // of the mean of 10 000 draws: four of its standard errors and more

UncertainScene scene() {
  UncertainScene s;
  s.cog = {1.1, 0.05, 0.35};
  s.partner = {1.5, 0.1, 0.44};
  s.cog_covariance = kCogSigma_m * kCogSigma_m * Eigen::Matrix3d::Identity();
  s.partner_covariance = kPartnerSigma_m * kPartnerSigma_m * Eigen::Matrix3d::Identity();
  return s;
}

std::vector<Vec3> points() {
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> y(-0.3, 0.3), z(0.3, 0.45);
  std::vector<Vec3> all;
  for (std::size_t i = 0; i < kCandidates; ++i) all.emplace_back(0.7, y(engine), z(engine));
  return all;
}

void agree_or_end() {
  const UncertainScene s = scene();
  const std::vector<Vec3> at = points();
  std::vector<RobustCost> costs(at.size());
  auto robust = RobustChoice::create({}, at.size());
  robust->evaluate(s, at, costs);
  const auto sharing = LoadSharing::create({});
  std::mt19937 engine(11);
  std::normal_distribution<double> normal;
  const auto draw = [&](double sigma) {
    return Vec3(sigma * Vec3(normal(engine), normal(engine), normal(engine)));
  };
  for (std::size_t i = 0; i < at.size(); i += 50) {
    double sum = 0.0;
    for (int k = 0; k < RobustChoice::kWhatIfs; ++k) {
      const Vec3 cog = s.cog + draw(kCogSigma_m), partner = s.partner + draw(kPartnerSigma_m);
      sum += sharing->cost(partner - cog, at[i] - cog, Wrench{s.up, Vec3::Zero()});
    }
    const double mean = sum / RobustChoice::kWhatIfs;
    if (std::abs(costs[i].expected / mean - 1.0) < kAgree) continue;
    std::fprintf(stderr, "candidate %zu: %.6f expected, %.6f by draws\n", i, costs[i].expected, mean);
    std::exit(1);
  }
}

void robust(benchmark::State& state) {
  const UncertainScene s = scene();
  const std::vector<Vec3> at = points();
  std::vector<RobustCost> costs(at.size());
  auto choice = RobustChoice::create({}, at.size());
  const std::vector<double> holds(state.range(0) != 0 ? at.size() : 0, 0.6);
  for (auto _ : state) {
    choice->evaluate(s, at, costs, holds);
    benchmark::DoNotOptimize(costs.data());
  }
}

BENCHMARK(robust)
    ->ArgName("with_grips_that_slip")
    ->Arg(0)
    ->Arg(1)
    ->Unit(benchmark::kMillisecond)
    ->Repetitions(9)
    ->ReportAggregatesOnly();

}  // namespace

int main(int argc, char** argv) {
  agree_or_end();
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
