// Load sharing of one candidate and pose: a dense KKT solve against the closed form, and the price of limits.
// Agreement of all is checked before anything is timed; a disagreement ends the program.
#include <benchmark/benchmark.h>

#include <Eigen/LU>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "planner/load_sharing/load_limits.hpp"
#include "planner/load_sharing/load_sharing.hpp"

using namespace colift::planner;

namespace {

constexpr std::size_t kCandidates = 1024;
const SharingWeights kWeights{0.8, 20.0, 15.0};
const SharingLimits kSomeActive{{26.0, 2.0}, {30.0, 3.0}};
const SharingLimits kMostActive{{19.0, 1.5}, {24.0, 2.5}};

struct Scene {
  Vec3 partner{-0.45, 0.05, 0.02};
  Wrench task{{1.0, -2.0, 40.0}, {0.3, -0.2, 0.1}};
  std::vector<Vec3> robot;
  std::vector<double> x, y, z;
};

const Scene& scene() {
  static const Scene made = [] {
    Scene s;
    std::mt19937 engine(7);
    const auto uniform = [&](double low, double high) {
      return low + (high - low) * (engine() / 4294967296.0);
    };
    for (std::size_t i = 0; i < kCandidates; ++i) {
      s.robot.emplace_back(uniform(0.1, 0.7), uniform(-0.3, 0.3), uniform(-0.1, 0.1));
      s.x.push_back(s.robot.back().x());
      s.y.push_back(s.robot.back().y());
      s.z.push_back(s.robot.back().z());
    }
    return s;
  }();
  return made;
}

const LoadSharing& model() {
  static const LoadSharing made = LoadSharing::create(kWeights).value();
  return made;
}

LimitedSharing limited(const SharingLimits& limits) {
  return LimitedSharing::create(model(), limits).value();
}

template <class Matrix, class Vector>
double kkt_cost(const Vec3& p1, const Vec3& p2, const Wrench& task) {
  const double e2 = kWeights.epsilon * kWeights.epsilon;
  const double w1 = kWeights.omega1_per_m * kWeights.omega1_per_m,
               w2 = kWeights.omega2_per_m * kWeights.omega2_per_m;
  Matrix kkt = Matrix::Zero(18, 18);
  for (int i = 0; i < 3; ++i) {
    kkt(i, i) = 1.0;
    kkt(3 + i, 3 + i) = w1;
    kkt(6 + i, 6 + i) = e2;
    kkt(9 + i, 9 + i) = e2 * w2;
    kkt(12 + i, i) = kkt(12 + i, 6 + i) = kkt(15 + i, 3 + i) = kkt(15 + i, 9 + i) = 1.0;
  }
  const auto cross = [&](int col, const Vec3& p) {
    kkt(15, col + 1) = -p.z(), kkt(15, col + 2) = p.y(), kkt(16, col) = p.z();
    kkt(16, col + 2) = -p.x(), kkt(17, col) = -p.y(), kkt(17, col + 1) = p.x();
  };
  cross(0, p1);
  cross(6, p2);
  for (int i = 0; i < 12; ++i) {
    for (int j = 12; j < 18; ++j) kkt(i, j) = kkt(j, i);
  }
  Vector right = Vector::Zero(18);
  right.template segment<3>(12) = task.force;
  right.template segment<3>(15) = task.torque;
  const Vector x = kkt.partialPivLu().solve(right);
  return x.template segment<3>(0).squaredNorm() + w1 * x.template segment<3>(3).squaredNorm() +
         e2 * (x.template segment<3>(6).squaredNorm() + w2 * x.template segment<3>(9).squaredNorm());
}

double dense(std::size_t i) {
  return kkt_cost<Eigen::MatrixXd, Eigen::VectorXd>(scene().partner, scene().robot[i], scene().task);
}
double fixed(std::size_t i) {
  return kkt_cost<Eigen::Matrix<double, 18, 18>, Eigen::Matrix<double, 18, 1>>(
      scene().partner, scene().robot[i], scene().task);
}

bool close(double a, double b, double tolerance) {
  return std::abs(a - b) <= tolerance * std::abs(b);
}

bool closed_form_agrees() {
  const Scene& s = scene();
  std::vector<double> flat(kCandidates);
  model().costs(s.partner, s.x, s.y, s.z, {&s.task, 1}, flat);
  for (std::size_t i = 0; i < kCandidates; ++i) {
    const double expected = dense(i), cost = model().cost(s.partner, s.robot[i], s.task);
    const bool same =
        close(cost, expected, 1e-12) && close(fixed(i), expected, 1e-12) && close(flat[i], expected, 1e-12) &&
        close(model().cost_weight(model().wrenches(s.partner, s.robot[i], s.task)), expected, 1e-12);
    if (same) continue;
    std::fprintf(stderr, "candidate %zu: closed form %.17g, KKT %.17g\n", i, cost, expected);
    return false;
  }
  std::printf("closed form and KKT agree on %zu candidates\n", kCandidates);
  return true;
}

bool limits_agree(const char* name, const SharingLimits& limits) {
  const Scene& s = scene();
  const LimitedSharing m = limited(limits);
  int active = 0, infeasible = 0;
  for (std::size_t i = 0; i < kCandidates; ++i) {
    const auto w = m.wrenches(s.partner, s.robot[i], s.task);
    if (!w) {
      ++infeasible;
      continue;
    }
    const double within = model().cost_weight(*w);
    const double slow = model().cost_weight(m.wrenches_by_enumeration(s.partner, s.robot[i], s.task));
    active += within > model().cost(s.partner, s.robot[i], s.task) * (1 + 1e-12);
    if (close(within, slow, 1e-9)) continue;
    std::fprintf(stderr, "candidate %zu: Newton %.17g, enumeration %.17g\n", i, within, slow);
    return false;
  }
  std::printf("%s: Newton and enumeration agree; limits active on %d of %zu, infeasible %d\n", name, active,
              kCandidates, infeasible);
  return true;
}

template <class Work>
void per_candidate(benchmark::State& state, Work work) {
  for (auto _ : state) {
    double sum = 0.0;
    for (std::size_t i = 0; i < kCandidates; ++i) sum += work(i);
    benchmark::DoNotOptimize(sum);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(kCandidates));
  state.counters["per_candidate"] =
      benchmark::Counter(static_cast<double>(kCandidates),
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void kkt_dynamic(benchmark::State& state) {
  per_candidate(state, dense);
}
void kkt_fixed_size(benchmark::State& state) {
  per_candidate(state, fixed);
}
void closed_form_cost(benchmark::State& state) {
  const Scene& s = scene();
  const LoadSharing m = model();
  per_candidate(state, [&](std::size_t i) { return m.cost(s.partner, s.robot[i], s.task); });
}
void closed_form_cost_arrays(benchmark::State& state) {
  const Scene& s = scene();
  std::vector<double> out(kCandidates);
  for (auto _ : state) {
    model().costs(s.partner, s.x, s.y, s.z, {&s.task, 1}, out);
    benchmark::DoNotOptimize(out.data());
    benchmark::ClobberMemory();
  }
  state.counters["per_candidate"] =
      benchmark::Counter(static_cast<double>(kCandidates),
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
void closed_form_wrenches(benchmark::State& state) {
  const Scene& s = scene();
  const LoadSharing m = model();
  per_candidate(state, [&](std::size_t i) {
    AgentWrenches w = m.wrenches(s.partner, s.robot[i], s.task);
    benchmark::DoNotOptimize(w);
    return w.robot.force.z();
  });
}
void limits(benchmark::State& state, const SharingLimits& given) {
  const Scene& s = scene();
  const LimitedSharing m = limited(given);
  per_candidate(state, [&](std::size_t i) {
    auto w = m.wrenches(s.partner, s.robot[i], s.task);
    benchmark::DoNotOptimize(w);
    return w ? w->robot.force.z() : 0.0;
  });
}
void limits_some_active(benchmark::State& state) {
  limits(state, kSomeActive);
}
void limits_most_active(benchmark::State& state) {
  limits(state, kMostActive);
}

BENCHMARK(kkt_dynamic);
BENCHMARK(kkt_fixed_size);
BENCHMARK(closed_form_cost);
BENCHMARK(closed_form_cost_arrays);
BENCHMARK(closed_form_wrenches);
BENCHMARK(limits_some_active);
BENCHMARK(limits_most_active);

}  // namespace

int main(int argc, char** argv) {
  if (!closed_form_agrees() || !limits_agree("some active", kSomeActive) ||
      !limits_agree("most active", kMostActive)) {
    return 1;
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
