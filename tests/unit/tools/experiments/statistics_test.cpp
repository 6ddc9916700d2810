// Figures are only as good as their intervals.

#include <catch2/catch.hpp>
#include <cmath>

#include "tools/experiments/statistics.hpp"

using namespace colift::experiments;

TEST_CASE("a rate has Wilson's interval, also where all went well", "[statistics]") {
  // values of the closed form with z = 1.959964
  const Estimate ninety = rate(90, 100);
  CHECK(ninety.value == Approx(0.9));
  CHECK(ninety.low == Approx(0.82563).margin(1e-4));
  CHECK(ninety.high == Approx(0.94477).margin(1e-4));
  const Estimate all = rate(10, 10);
  CHECK(all.high == Approx(1.0));
  CHECK(all.low == Approx(0.72247).margin(1e-4));
  CHECK(rate(0, 0).n == 0);
  CHECK(std::isnan(rate(0, 0).value));
}

TEST_CASE("a quantile's interval lies between order statistics", "[statistics]") {
  std::vector<double> v;
  for (int i = 1; i <= 100; ++i) v.push_back(i);
  const Estimate median = quantile_estimate(v, 0.5);
  CHECK(median.value == Approx(50.5));
  CHECK(median.low == Approx(40.0).margin(1.0));
  CHECK(median.high == Approx(61.0).margin(1.0));
  const Estimate few = quantile_estimate({3.0, 1.0, NAN, 2.0}, 0.95);
  CHECK(few.n == 3);
  CHECK(few.high == 3.0);
  CHECK(quantile_estimate({}, 0.5).n == 0);
  CHECK(quantile({4.0, 1.0, 3.0, 2.0}, 0.5) == Approx(2.5));
}

TEST_CASE("a bootstrap gives the same interval again, and one that shrinks", "[statistics]") {
  std::vector<double> few, many;
  for (int i = 0; i < 20; ++i) few.push_back(i % 5);
  for (int i = 0; i < 2000; ++i) many.push_back(i % 5);
  const Estimate a = mean_estimate(few), b = mean_estimate(few), c = mean_estimate(many);
  CHECK(a.low == b.low);
  CHECK(a.value == Approx(2.0));
  CHECK(a.low < 2.0);
  CHECK(a.high > 2.0);
  CHECK(c.high - c.low < 0.2 * (a.high - a.low));
}

TEST_CASE("the area under the curve is 1 where margins tell, one half where they do not", "[statistics]") {
  CHECK(area_under_curve({2.0, 3.0}, {0.5, 1.0}).value == Approx(1.0));
  CHECK(area_under_curve({1.0, 2.0}, {1.0, 2.0}).value == Approx(0.5));
  CHECK(area_under_curve({0.5}, {1.0}).value == Approx(0.0));
  CHECK(area_under_curve({}, {1.0}).n == 0);
}
