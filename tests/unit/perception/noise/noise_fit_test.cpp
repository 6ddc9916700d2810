// The noise of a camera, measured on what it sees.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "perception/noise_fit.hpp"

using namespace colift;
using namespace colift::perception;

namespace {

// a floor that a camera 1 m above it sees, pitched down by 35 degrees, with the given noise
hal::DepthFrame floor_frame(const NoiseModel& noise, unsigned seed, bool quantised = false) {
  hal::DepthFrame f;
  f.intrinsics = {320, 240, 290.0, 290.0, 159.5, 119.5};
  std::mt19937 random(seed);
  std::normal_distribution<double> gauss;
  const double down = 35.0 * M_PI / 180.0;
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u) {
      const double y = (v - 119.5) / 290.0;
      const double sine = std::sin(down) + y * std::cos(down);
      double z = sine > 0.15 ? 1.0 / sine : std::numeric_limits<double>::quiet_NaN();
      if (z > 4.0) z = std::numeric_limits<double>::quiet_NaN();
      z += noise.sigma(z) * gauss(random);
      if (quantised) {
        const double step = noise.step(z);
        z = std::round(z / step) * step;
      }
      f.depth_m.push_back(static_cast<float>(z));
    }
  }
  return f;
}

}  // namespace

TEST_CASE("the noise that went in comes out", "[noise]") {
  NoiseModel truth;
  SECTION("of a Kinect") {}
  SECTION("three times as large") {
    truth.sigma0_m *= 3, truth.sigma2_per_m *= 3;
  }
  SECTION("constant, as of time of flight") {
    truth.sigma0_m = 0.002, truth.sigma2_per_m = 0.0001;
  }
  NoiseFit fit;
  for (unsigned k = 0; k < 4; ++k) fit.add(floor_frame(truth, k + 1));
  const auto measured = fit.result();
  REQUIRE(measured);
  for (const double z : {1.0, 1.5, 2.5})
    CHECK(measured->model.sigma(z) == Approx(truth.sigma(z)).epsilon(0.08));
  CHECK(measured->flat_fraction > 0.9);
  CHECK(measured->misfit < 0.1);
  CHECK(measured->doubts.empty());
}

TEST_CASE("things on the floor are left out of the noise and named", "[noise]") {
  NoiseFit fit;
  hal::DepthFrame f = floor_frame({}, 3);
  for (int v = 100; v < 220; ++v)
    for (int u = 100; u < 200; u += 7)
      for (int k = 0; k < 3; ++k) f.depth_m[static_cast<std::size_t>(v * 320 + u + k)] *= 0.8f;
  fit.add(f);
  fit.add(f);
  const auto measured = fit.result();
  REQUIRE(measured);
  CHECK(measured->model.sigma(2.0) == Approx(NoiseModel{}.sigma(2.0)).epsilon(0.15));
}

TEST_CASE("without enough to see there is no noise model", "[noise]") {
  NoiseFit fit;
  CHECK_FALSE(fit.result());
  hal::DepthFrame empty;
  empty.depth_m.assign(640 * 480, std::numeric_limits<float>::quiet_NaN());
  fit.add(empty);
  hal::DepthFrame wrong;
  wrong.depth_m.assign(17, 1.0f);
  fit.add(wrong);
  const auto measured = fit.result();
  REQUIRE_FALSE(measured);
  CHECK(measured.error().text().find("empty floor") != std::string::npos);
}

TEST_CASE("a wall straight ahead tells the noise at its distance, and says that it is only there",
          "[noise]") {
  hal::DepthFrame f;
  f.intrinsics = {640, 480, 575.0, 575.0, 320.0, 240.0};
  std::mt19937 random(5);
  std::normal_distribution<double> gauss;
  for (int i = 0; i < 640 * 480; ++i) f.depth_m.push_back(static_cast<float>(2.0 + 0.006 * gauss(random)));
  NoiseFit fit;
  fit.add(f);
  const auto measured = fit.result();
  REQUIRE(measured);
  CHECK(measured->model.sigma(2.0) == Approx(0.006).epsilon(0.05));
  CHECK(measured->doubts.size() == 1);
}
