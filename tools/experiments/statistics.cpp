#include "tools/experiments/statistics.hpp"

#include <algorithm>
#include <cmath>

#include "sim_hal/synthetic/hash_random.hpp"

namespace colift::experiments {
namespace {

constexpr double kZ = 1.959963984540054;  // 97.5 % of the normal distribution

std::vector<double> sorted_numbers(std::vector<double> values) {
  std::erase_if(values, [](double v) { return std::isnan(v); });
  std::sort(values.begin(), values.end());
  return values;
}

double quantile_of_sorted(const std::vector<double>& v, double p) {
  if (v.empty()) return NAN;
  const double at = p * static_cast<double>(v.size() - 1);
  const auto low = static_cast<std::size_t>(at);
  const std::size_t high = std::min(low + 1, v.size() - 1);
  return v[low] + (at - std::floor(at)) * (v[high] - v[low]);
}

Estimate none() {
  return {NAN, NAN, NAN, 0};
}

}  // namespace

double quantile(std::vector<double> values, double p) {
  return quantile_of_sorted(sorted_numbers(std::move(values)), p);
}

Estimate rate(int successes, int trials) {
  if (trials <= 0) return none();
  const double n = trials, p = successes / n, z2 = kZ * kZ;
  const double middle = (p + z2 / (2 * n)) / (1 + z2 / n);
  const double half = kZ / (1 + z2 / n) * std::sqrt(p * (1 - p) / n + z2 / (4 * n * n));
  return {p, std::max(0.0, middle - half), std::min(1.0, middle + half), trials};
}

Estimate quantile_estimate(const std::vector<double>& values, double p) {
  const std::vector<double> v = sorted_numbers(values);
  if (v.empty()) return none();
  // largest and smallest rank whose tails of the binomial distribution hold at most 2.5 % each
  const int n = static_cast<int>(v.size());
  double below = 0.0;
  int low = 0, high = n - 1;
  bool low_found = false;
  for (int k = 0; k <= n; ++k) {
    const double log_choose = std::lgamma(n + 1.0) - std::lgamma(k + 1.0) - std::lgamma(n - k + 1.0);
    below += std::exp(log_choose + k * std::log(p) + (n - k) * std::log1p(-p));
    if (!low_found && below > 0.025) low = std::max(0, k - 1), low_found = true;
    if (below >= 0.975) {
      high = std::min(n - 1, k);
      break;
    }
  }
  const double value = quantile_of_sorted(v, p);
  return {value, std::min(value, v[static_cast<std::size_t>(low)]),
          std::max(value, v[static_cast<std::size_t>(high)]), n};
}

Estimate mean_estimate(const std::vector<double>& values, std::uint64_t seed) {
  std::vector<double> v = values;
  std::erase_if(v, [](double x) { return std::isnan(x); });
  if (v.empty()) return none();
  constexpr int kResamples = 2000;
  const auto mean = [](const std::vector<double>& x) {
    double sum = 0.0;
    for (const double y : x) sum += y;
    return sum / static_cast<double>(x.size());
  };
  sim_hal::Draws draws(seed, 6100);
  std::vector<double> means, sample(v.size());
  means.reserve(kResamples);
  for (int i = 0; i < kResamples; ++i) {
    for (double& s : sample) s = v[static_cast<std::size_t>(draws.below(static_cast<int>(v.size())))];
    means.push_back(mean(sample));
  }
  std::sort(means.begin(), means.end());
  return {mean(v), quantile_of_sorted(means, 0.025), quantile_of_sorted(means, 0.975),
          static_cast<int>(v.size())};
}

Estimate area_under_curve(const std::vector<double>& good, const std::vector<double>& bad) {
  if (good.empty() || bad.empty()) return none();
  double wins = 0.0;
  for (const double g : good)
    for (const double b : bad) wins += g > b ? 1.0 : g == b ? 0.5 : 0.0;
  const auto ng = static_cast<double>(good.size()), nb = static_cast<double>(bad.size());
  const double a = wins / (ng * nb), a2 = a * a;
  const double q1 = a / (2 - a), q2 = 2 * a2 / (1 + a);
  const double variance = (a * (1 - a) + (ng - 1) * (q1 - a2) + (nb - 1) * (q2 - a2)) / (ng * nb);
  const double half = kZ * std::sqrt(std::max(0.0, variance));
  return {a, std::max(0.0, a - half), std::min(1.0, a + half), static_cast<int>(good.size() + bad.size())};
}

}  // namespace colift::experiments
