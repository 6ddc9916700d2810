#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "hal/drivers/recorded/camera_file.hpp"
#include "hal/lens.hpp"
#include "writers.hpp"

using namespace colift::hal;
using namespace colift::hal::test;

namespace {

const CameraIntrinsics kCamera{160, 120, 140.0, 140.0, 79.5, 59.5};

// depth along Cz of the plane n . p = 1 on the ray (x, y, 1)
double depth_of(double x, double y) {
  return 1.0 / (0.1 * x + 0.25 * y + 0.5);
}

// what a camera with this lens sees of the plane: each ray is imaged where the lens sends it
std::vector<float> seen_through(const LensDistortion& lens) {
  std::vector<float> out(160 * 120, std::nanf(""));
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u) {
      // the ray of a pixel, by fixed-point iteration of the lens
      const double px = (u - kCamera.cx) / kCamera.fx, py = (v - kCamera.cy) / kCamera.fy;
      double x = px, y = py;
      for (int i = 0; i < 60; ++i) {
        const auto [dx, dy] = lens.distort(x, y);
        x += px - dx;
        y += py - dy;
      }
      out[static_cast<std::size_t>(v * 160 + u)] = static_cast<float>(depth_of(x, y));
    }
  }
  return out;
}

Result<CameraFile> camera_with(const std::string& distortion) {
  return parse_camera_json(
      bytes_of(R"({"fx":525,"fy":525,"cx":320,"cy":240,"depth_scale_m":0.001,"distortion":)" + distortion +
               "}"),
      "camera.json");
}

}  // namespace

TEST_CASE("a plane seen through a lens is a plane again", "[lens]") {
  LensDistortion lens;
  SECTION("barrel") {
    lens.k1 = -0.25, lens.k2 = 0.08;
  }
  SECTION("pincushion, tangential") {
    lens.k1 = 0.12, lens.p1 = 0.003, lens.p2 = -0.002;
  }
  SECTION("rational") {
    lens.k1 = 0.4, lens.k2 = 0.1, lens.k4 = 0.6, lens.k5 = 0.1;
  }
  REQUIRE(lens.unique_within(kCamera));
  const std::vector<float> image = seen_through(lens), flat = rectify(image, kCamera, lens);
  double worst = 0.0, worst_before = 0.0;
  int compared = 0;
  for (int v = 20; v < 100; ++v) {
    for (int u = 20; u < 140; ++u) {
      const auto i = static_cast<std::size_t>(v * 160 + u);
      if (std::isnan(flat[i])) continue;
      const double truth = depth_of((u - kCamera.cx) / kCamera.fx, (v - kCamera.cy) / kCamera.fy);
      worst = std::max(worst, std::abs(static_cast<double>(flat[i]) - truth));
      worst_before = std::max(worst_before, std::abs(static_cast<double>(image[i]) - truth));
      ++compared;
    }
  }
  CHECK(compared > 9000);
  CHECK(worst < 0.0005);
  CHECK(worst_before > 0.005);
}

TEST_CASE("rectifying never mixes the depths of two surfaces", "[lens]") {
  LensDistortion lens;
  lens.k1 = -0.2;
  std::vector<float> image(160 * 120, 2.0f);
  for (int v = 30; v < 90; ++v)
    for (int u = 50; u < 110; ++u) image[static_cast<std::size_t>(v * 160 + u)] = 1.0f;
  for (const float d : rectify(image, kCamera, lens)) CHECK((std::isnan(d) || d == 1.0f || d == 2.0f));
}

TEST_CASE("the distortion of a camera file is read in the forms that tools write", "[lens][camera_json]") {
  for (const char* none : {"null", "[]", "[0,0,0,0,0]", R"({"model":"none"})",
                           R"({"model":"Inverse Brown Conrady","coefficients":[0,0,0,0,0]})"}) {
    INFO(none);
    const auto camera = camera_with(none);
    REQUIRE(camera);
    CHECK(camera->lens.none());
  }
  const auto five = camera_with("[0.1,-0.2,0.001,-0.002,0.05]");
  REQUIRE(five);
  CHECK(five->lens.k1 == 0.1);
  CHECK(five->lens.k2 == -0.2);
  CHECK(five->lens.p1 == 0.001);
  CHECK(five->lens.k3 == 0.05);
  const auto eight = camera_with(R"({"model":"rational_polynomial","coefficients":[1,2,0,0,3,4,5,6]})");
  REQUIRE(eight);
  CHECK(eight->lens.k6 == 6);
}

TEST_CASE("a distortion that is not one is refused with what was expected", "[lens][camera_json]") {
  for (const char* bad : {"5", R"("none")", "[0.1]", "[1,2,3,4,5,6]", R"([0.1,"a",0,0])", R"([1e9,0,0,0])",
                          R"({"coefficients":[0.1,0,0,0]})", R"({"model":"brown-conrady"})",
                          R"({"model":"fisheye","coefficients":[0.1,0,0,0]})", R"([[1],2,3,4])"}) {
    INFO(bad);
    const auto camera = camera_with(bad);
    REQUIRE_FALSE(camera);
    CHECK(camera.error().text().find("camera.json: distortion") != std::string::npos);
  }
}

TEST_CASE("a lens that folds the image is known", "[lens]") {
  LensDistortion lens;
  lens.k1 = -2.5;
  CHECK_FALSE(lens.unique_within(kCamera));
}

TEST_CASE("where a ray is imaged leads back to the ray") {
  for (const double k1 : {-0.1, 0.02, 0.15}) {
    const LensDistortion lens{k1, 0.01, 0.002, -0.001};
    for (const double x : {-0.5, 0.0, 0.4}) {
      for (const double y : {-0.4, 0.1}) {
        const auto [u, v] = lens.distort(x, y);
        const auto [a, b] = lens.undistort(u, v);
        CHECK(std::hypot(a - x, b - y) < 1e-6);
      }
    }
  }
}
