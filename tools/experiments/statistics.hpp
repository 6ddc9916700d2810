#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace colift::experiments {

/// A figure with its 95 % interval.
struct Estimate {
  double value = 0.0, low = 0.0, high = 0.0;
  int n = 0;  ///< Trials that it rests on; 0: there is no figure, and the others are NaN.
};

/// Value below which the part `p` of the numbers lies (linear between order statistics); NaN is left out; NaN
/// of none.
[[nodiscard]] double quantile(std::vector<double> values, double p);

/// A rate with Wilson's score interval (Wilson 1927), which holds for small counts and near 0 and 1.
[[nodiscard]] Estimate rate(int successes, int trials);

/// A quantile with the interval between the order statistics that the binomial distribution gives (Conover
/// 1999, 3.2): no assumption on the distribution. With too few numbers for 95 % it ends at the extremes.
[[nodiscard]] Estimate quantile_estimate(const std::vector<double>& values, double p);

/// Mean with a percentile bootstrap (Efron 1979) of 2000 resamples. The seed is fixed: same numbers in the
/// same order, same interval.
[[nodiscard]] Estimate mean_estimate(const std::vector<double>& values, std::uint64_t seed = 1);

/// Area under the receiver operating characteristic: chance that a random bad case scores lower than a random
/// good one, ties counted half. Interval by Hanley and McNeil (1982). n is 0 without both kinds.
[[nodiscard]] Estimate area_under_curve(const std::vector<double>& good, const std::vector<double>& bad);

}  // namespace colift::experiments
