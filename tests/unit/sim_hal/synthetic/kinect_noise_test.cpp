#include "sim_hal/synthetic/kinect/kinect_noise.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>
#include <vector>

#include "sim_hal/synthetic/kinect/kinect_code.hpp"
#include "sim_hal/synthetic/kinect/kinect_rows.hpp"
#include "sim_hal/synthetic/scenes.hpp"

using namespace colift::sim_hal;
using colift::hal::CameraIntrinsics;
using colift::hal::DepthFrame;

namespace {

const CameraIntrinsics kKinect;

constexpr KinectNoise kNothing{false, false, false, false, false, false};

std::size_t at(int u, int v) {
  return static_cast<std::size_t>(v * kKinect.width + u);
}

double deg(double d) {
  return d * 3.14159265358979323846 / 180.0;
}

/// A plane across the optical axis at distance z, turned about the vertical.
Rendering plane(double z_m, double turn_rad) {
  World world;
  world.shapes.push_back(half_space({0, 0, z_m}, {std::sin(turn_rad), 0, -std::cos(turn_rad)}, Label::Wall));
  return cast_rays(world, kKinect, Pose::Identity());
}

/// Standard deviation of measured minus true depth in the middle of the image.
double sigma_of(const Rendering& truth, const DepthFrame& frame, double z_from, double z_to) {
  double sum = 0, sum2 = 0;
  int n = 0;
  for (int v = 60; v < 420; ++v)
    for (int u = 60; u < 600; ++u) {
      const double z = truth.depth_m[at(u, v)], m = frame.depth_m[at(u, v)];
      if (std::isnan(m) || z < z_from || z > z_to) continue;
      sum += m - z, sum2 += (m - z) * (m - z), ++n;
    }
  REQUIRE(n > 2500);
  return std::sqrt(sum2 / n - sum / n * (sum / n));
}

double model(double z) {
  return 0.0003 + 0.0012 * z * z;
}

bool same_bits(const DepthFrame& a, const DepthFrame& b) {
  return a.depth_m.size() == b.depth_m.size() &&
         std::memcmp(a.depth_m.data(), b.depth_m.data(), a.depth_m.size() * sizeof(float)) == 0;
}

/// A plate at z1 before a wall at z2, its left edge near column 250 and its right edge near column 400.
Rendering plate_before_wall(double z1, double z2) {
  World world;
  const double left = (250.5 - kKinect.cx) * z1 / kKinect.fx, right = (400.5 - kKinect.cx) * z1 / kKinect.fx;
  world.shapes.push_back(half_space({0, 0, z2}, {0, 0, -1}, Label::Wall));
  world.shapes.push_back(
      box({0.5 * (left + right), 0, z1 + 0.005}, {right - left, 3.0, 0.01}, 0.0, Label::Target));
  return cast_rays(world, kKinect, Pose::Identity());
}

}  // namespace

TEST_CASE("noise on a plane has the spread that was measured on real planes", "[kinect_noise]") {
  for (const double z : {1.0, 1.5, 2.3}) {
    // frontal: over one step of the raw code, since few codes are visited from any one distance
    double variance = 0;
    constexpr int kDistances = 5;
    for (int i = 0; i < kDistances; ++i) {
      const Rendering truth = plane(z + z * z / 345.5 * i / kDistances, 0.0);
      variance +=
          std::pow(sigma_of(truth, measure(truth, {}, static_cast<std::uint64_t>(i)), 0, 9), 2) / kDistances;
    }
    CAPTURE(z);
    CHECK(std::sqrt(variance) == Approx(model(z)).epsilon(0.2));

    const Rendering tilted = plane(z, deg(40));
    CHECK(sigma_of(tilted, measure(tilted, {}, 3), z * 0.97, z * 1.03) == Approx(model(z)).epsilon(0.2));
  }
}

TEST_CASE("without rounding to codes the noise has the same spread", "[kinect_noise]") {
  KinectNoise noise = kNothing;
  noise.axial = true;
  const Rendering truth = plane(1.5, deg(20));
  CHECK(sigma_of(truth, measure(truth, noise, 1), 1.45, 1.55) == Approx(model(1.5)).epsilon(0.1));
}

TEST_CASE("noise grows at grazing angles", "[kinect_noise]") {
  KinectNoise noise = kNothing;
  noise.axial = true;
  // the angle of Nguyen, Izadi and Lovell between ray and normal, at the middle column
  for (const double z : {0.8, 1.2, 2.5}) {
    for (const double angle : {0.0, 30.0, 45.0, 60.0, 70.0, 75.0}) {
      const Rendering truth = plane(z, deg(angle));
      const double theta = deg(angle);
      const double side = 0.0001 / std::sqrt(z) * std::pow(theta / (deg(90) - theta), 2);
      CAPTURE(z, angle);
      CHECK(sigma_of(truth, measure(truth, noise, 5), 0.97 * z, 1.03 * z) ==
            Approx(model(z) + side).epsilon(0.06));
    }
  }
}

TEST_CASE("noise is normal, without bias, and new in every frame and row", "[kinect_noise]") {
  KinectNoise noise = kNothing;
  noise.axial = true;
  const Rendering truth = plane(2.0, 0.0);
  double sum = 0, sum2 = 0, sum4 = 0, between_frames = 0, between_rows = 0;
  int n = 0, beyond_2 = 0, beyond_3 = 0;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const DepthFrame frame = measure(truth, noise, seed), other = measure(truth, noise, seed + 10);
    const auto error = [&](const DepthFrame& f, int u, int v) {
      return (static_cast<double>(f.depth_m[at(u, v)]) - 2.0) / model(2.0);
    };
    for (int v = 0; v < 470; ++v)
      for (int u = 0; u < 632; ++u) {
        const double e = error(frame, u, v);
        sum += e, sum2 += e * e, sum4 += e * e * e * e, ++n;
        beyond_2 += std::abs(e) > 2.0, beyond_3 += std::abs(e) > 3.0;
        between_frames += e * error(other, u, v), between_rows += e * error(frame, u, v + 8);
      }
  }
  CHECK(std::abs(sum / n) < 0.02);
  CHECK(sum2 / n == Approx(1.0).epsilon(0.04));
  CHECK(sum4 / n / (sum2 / n * sum2 / n) == Approx(3.0).epsilon(0.05));
  CHECK(static_cast<double>(beyond_2) / n == Approx(0.0455).epsilon(0.1));
  CHECK(static_cast<double>(beyond_3) / n == Approx(0.0027).epsilon(0.25));
  CHECK(std::abs(between_frames / sum2) < 0.02);
  CHECK(std::abs(between_rows / sum2) < 0.02);
}

TEST_CASE("specks are as frequent as in recordings, half of them two pixels wide", "[kinect_noise]") {
  int missing = 0, one = 0, two = 0, pixels = 0;
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const DepthFrame frame = measure(plane(1.5, 0.0), {}, seed);
    const auto gone = [&](int u, int v) { return std::isnan(frame.depth_m[at(u, v)]); };
    for (int v = 0; v < 480; ++v)
      for (int u = 1; u < 630; ++u) {
        ++pixels, missing += gone(u, v);
        if (gone(u, v) && !gone(u - 1, v)) ++(gone(u + 1, v) ? two : one);
      }
  }
  CHECK(static_cast<double>(missing) / pixels == Approx(0.0015).epsilon(0.1));
  CHECK(static_cast<double>(two) / (one + two) == Approx(0.5).margin(0.06));
}

TEST_CASE("neighbours err alike, as in real frames", "[kinect_noise]") {
  const Rendering truth = plane(1.5, deg(30));
  const DepthFrame frame = measure(truth, {}, 11);
  double own = 0, right = 0, below = 0, far = 0;
  for (int v = 100; v < 380; ++v)
    for (int u = 100; u < 540; ++u) {
      const auto error = [&](int a, int b) {
        const double e = frame.depth_m[at(a, b)] - truth.depth_m[at(a, b)];
        return std::isnan(e) ? 0.0 : e;
      };
      const double e = error(u, v);
      own += e * e, right += e * error(u + 1, v), below += e * error(u, v + 1),
          far += e * error(u + 8, v + 8);
    }
  CHECK(right / own > 0.35);
  CHECK(right / own < 0.7);
  CHECK(below / own > 0.25);
  CHECK(below / own < 0.6);
  CHECK(std::abs(far / own) < 0.12);
}

TEST_CASE("every depth is a value of the Kinect's code table", "[kinect_noise]") {
  std::set<int> table_mm;
  for (int raw = 0; raw < 1089; ++raw) table_mm.insert(static_cast<int>(345489.4 / (1089.408 - raw)));
  const SyntheticScene scene = make_scene(ObjectKind::Chair, 4);
  const DepthFrame frame = measure(cast_rays(scene.world, scene.intrinsics, scene.X_WC), {}, 4);
  std::set<int> seen_mm;
  for (const float z : frame.depth_m) {
    if (std::isnan(z)) continue;
    const double mm = static_cast<double>(z) * 1000.0;
    REQUIRE(std::abs(mm - std::round(mm)) < 1e-3);
    seen_mm.insert(static_cast<int>(std::round(mm)));
  }
  CHECK(seen_mm.size() > 100);
  for (const int mm : seen_mm) REQUIRE(table_mm.count(mm) == 1);
}

TEST_CASE("the projector's shadow lies left of the near object and is as wide as the baseline says",
          "[kinect_noise]") {
  KinectNoise noise = kNothing;
  noise.shadow = true;
  for (const auto& [z1, z2] :
       {std::pair{1.0, 2.0}, std::pair{0.8, 1.2}, std::pair{1.5, 3.0}, std::pair{1.5, 1.65}}) {
    const Rendering truth = plate_before_wall(z1, z2);
    const DepthFrame frame = measure(truth, noise, 0);
    const double expected = 0.075 * kKinect.fx * (1 / z1 - 1 / z2);
    int left = 0, right = 0;
    for (int u = 0; u < kKinect.width; ++u)
      if (std::isnan(frame.depth_m[at(u, 240)])) ++(u < 325 ? left : right);
    CAPTURE(z1, z2, expected);
    CHECK(std::abs(left - expected) <= 1.5);
    CHECK(right == 0);
    // the strip ends at the plate
    CHECK(std::isnan(frame.depth_m[at(250, 240)]));
    CHECK_FALSE(std::isnan(frame.depth_m[at(251, 240)]));
  }
}

TEST_CASE("a thin pole throws a thin shadow that stands apart from it", "[kinect_noise]") {
  World world;
  world.shapes.push_back(half_space({0, 0, 2}, {0, 0, -1}, Label::Wall));
  world.shapes.push_back(box({0, 0, 1}, {9.0 / kKinect.fx, 3, 0.001}, 0.0, Label::Target));  // 9 px wide
  KinectNoise noise = kNothing;
  noise.shadow = true;
  const DepthFrame frame = measure(cast_rays(world, kKinect, Pose::Identity()), noise, 0);
  int dark = 0, first = 1000, last = 0;
  for (int u = 0; u < kKinect.width; ++u)
    if (std::isnan(frame.depth_m[at(u, 240)])) ++dark, first = std::min(first, u), last = std::max(last, u);
  CHECK(dark == Approx(9).margin(1.5));
  CHECK(last - first + 1 == dark);
  CHECK(last < 316 - 8);  // lit wall between the shadow and the pole
}

TEST_CASE("the shadow is what the projector's columns say, for anything in the picture", "[kinect_noise]") {
  KinectNoise noise = kNothing;
  noise.shadow = true;
  int dark = 0;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    const SyntheticScene scene = make_scene(seed % 2 == 0 ? ObjectKind::Chair : ObjectKind::Table, seed);
    const Rendering truth =
        cast_rays(with_partner(scene.world, make_partner(scene, seed, false)), scene.intrinsics, scene.X_WC);
    const DepthFrame frame = measure(truth, noise, 0);
    const int width = truth.intrinsics.width;
    for (int v = 0; v < truth.intrinsics.height; v += 3) {
      const auto disparity = [&](int u) {
        const double z = truth.depth_m[static_cast<std::size_t>(v * width + u)];
        return z > 0.3 ? 0.075 * truth.intrinsics.fx / z : 0.0;
      };
      for (int u = 0; u < width; ++u) {
        const double d = disparity(u), column = u - d;
        if (d == 0.0) continue;
        // hidden for certain: between the columns of two neighbours on one nearer surface; not hidden for
        // certain: nothing nearer has its column anywhere near
        bool between = false, nearby = false;
        for (int k = u + 1; k + 1 < width; ++k) {
          const double a = disparity(k), b = disparity(k + 1), from = k - a, to = k + 1 - b;
          between |=
              std::min(a, b) > d + 1.2 && std::abs(a - b) < 0.9 && from < column - 1e-3 && to > column + 1e-3;
          nearby |=
              std::max(a, b) > d + 0.8 && std::min(from, to) < column + 2 && std::max(from, to) > column - 2;
        }
        CAPTURE(seed, u, v, d);
        const bool gone = std::isnan(frame.depth_m[static_cast<std::size_t>(v * width + u)]);
        if (between) REQUIRE(gone);
        if (gone) REQUIRE(nearby);
        dark += between;
      }
    }
  }
  CHECK(dark > 1000);
}

TEST_CASE("edges are ragged by a pixel or two and the object grows a little", "[kinect_noise]") {
  KinectNoise noise = kNothing;
  noise.lateral = true;
  const Rendering truth = plate_before_wall(1.0, 2.0);
  const DepthFrame frame = measure(truth, noise, 2);
  double sum = 0, sum2 = 0;
  for (int v = 20; v < 460; ++v) {
    int near = 0;
    for (int u = 380; u < 420; ++u) near += frame.depth_m[at(u, v)] < 1.5f;
    const double edge = 380 + near - 401;  // pixels beyond the true edge
    sum += edge, sum2 += edge * edge;
  }
  const double mean = sum / 440, spread = std::sqrt(sum2 / 440 - mean * mean);
  CHECK(mean > 0.0);
  CHECK(mean < 1.2);
  CHECK(spread > 0.4);
  CHECK(spread < 1.6);
  // away from edges nothing moves
  for (int v = 0; v < 480; v += 7)
    for (int u = 260; u < 390; ++u) REQUIRE(frame.depth_m[at(u, v)] == truth.depth_m[at(u, v)]);
}

TEST_CASE("a few edge pixels fly between foreground and background", "[kinect_noise]") {
  KinectNoise noise = kNothing;
  noise.flying_pixels = true;
  const DepthFrame frame = measure(plate_before_wall(1.0, 2.0), noise, 2);
  int flying = 0;
  for (const float z : frame.depth_m) flying += z > 1.02f && z < 1.98f;
  const int edge_pixels = 4 * 480;  // one each side of two upright edges
  CHECK(flying > 0.01 * edge_pixels);
  CHECK(flying < 0.07 * edge_pixels);
}

TEST_CASE("a room misses between 3 and 12 percent of its pixels", "[kinect_noise]") {
  double mean = 0;
  int scenes = 0;
  for (std::uint64_t seed = 0; seed < 6; ++seed)
    for (const ObjectKind kind : {ObjectKind::Table, ObjectKind::OpenBox, ObjectKind::Chair}) {
      const SyntheticScene scene = make_scene(kind, seed);
      const Rendering truth = cast_rays(with_partner(scene.world, make_partner(scene, seed, false)),
                                        scene.intrinsics, scene.X_WC);
      const DepthFrame frame = measure(truth, {}, seed);
      int within_range = 0, missing = 0;
      for (std::size_t i = 0; i < frame.depth_m.size(); ++i) {
        if (!(truth.depth_m[i] > 0.5f && truth.depth_m[i] < 4.0f)) continue;
        ++within_range;
        missing += std::isnan(frame.depth_m[i]);
      }
      const double part = static_cast<double>(missing) / within_range;
      CAPTURE(scene.name, part);
      CHECK(part > 0.015);
      CHECK(part < 0.12);
      mean += part, ++scenes;
    }
  CHECK(mean / scenes > 0.03);
}

TEST_CASE("the last eight columns and what is out of range hold no data", "[kinect_noise]") {
  const DepthFrame frame = measure(plane(1.0, 0.0), {}, 9);
  for (int v = 0; v < 480; ++v)
    for (int u = 632; u < 640; ++u) REQUIRE(std::isnan(frame.depth_m[at(u, v)]));
  int seen = 0;
  for (const double z : {0.45, 9.5})
    for (const float m : measure(plane(z, 0.0), {}, 9).depth_m) seen += !std::isnan(m);
  CHECK(seen == 0);
}

TEST_CASE("black surfaces vanish at an angle and stay when they face the camera", "[kinect_noise]") {
  const auto seen_part = [](double angle, double reflectivity) {
    World world;
    const double a = deg(angle);
    world.shapes.push_back(half_space({0, 0, 1.5}, {std::sin(a), 0, -std::cos(a)}, Label::Wall));
    world.shapes.back().reflectivity = reflectivity;
    const DepthFrame frame = measure(cast_rays(world, kKinect, Pose::Identity()), {}, 1);
    int seen = 0;
    for (int v = 200; v < 280; ++v)
      for (int u = 290; u < 350; ++u) seen += !std::isnan(frame.depth_m[at(u, v)]);
    return seen / (80.0 * 60.0);
  };
  CHECK(seen_part(0, 0.06) > 0.9);
  CHECK(seen_part(75, 0.06) < 0.5);
  CHECK(seen_part(75, 0.6) > 0.9);
  CHECK(seen_part(87, 0.6) < 0.3);
}

TEST_CASE("same seed, same bits; another seed, another frame", "[kinect_noise]") {
  const SyntheticScene scene = make_scene(ObjectKind::Table, 1);
  const Rendering truth = cast_rays(scene.world, scene.intrinsics, scene.X_WC);
  CHECK(same_bits(measure(truth, {}, 5), measure(truth, {}, 5)));
  CHECK_FALSE(same_bits(measure(truth, {}, 5), measure(truth, {}, 6)));
}

TEST_CASE("with every effect off the measurement is the rendering", "[kinect_noise]") {
  const SyntheticScene scene = make_scene(ObjectKind::Pipe, 1);
  const Rendering truth = cast_rays(scene.world, scene.intrinsics, scene.X_WC);
  const DepthFrame ideal = measure_ideal(truth);
  CHECK(same_bits(measure(truth, kNothing, 5), ideal));
  REQUIRE(ideal.up_C);
  CHECK((scene.X_WC.linear() * *ideal.up_C).isApprox(Vec3::UnitZ(), 1e-12));
}

TEST_CASE("an empty or tiny picture is measured without complaint", "[kinect_noise]") {
  const Rendering nothing = cast_rays({}, kKinect, Pose::Identity());
  for (const float z : measure(nothing, {}, 0).depth_m) REQUIRE(std::isnan(z));
  CameraIntrinsics one{1, 1, 500, 500, 0, 0};
  World world;
  world.shapes.push_back(half_space({0, 0, 1}, {0, 0, -1}, Label::Wall));
  CHECK(measure(cast_rays(world, one, Pose::Identity()), {}, 0).depth_m.size() == 1);
  CameraIntrinsics none{0, 0, 500, 500, 0, 0};
  CHECK(measure(cast_rays(world, none, Pose::Identity()), {}, 0).depth_m.empty());
}

TEST_CASE("every code is read out as its depth in the table, to the bit") {
  std::vector<float> inverse_depth, expected;
  const auto& table = kinect_depths_m();
  for (int code = 0; code < kKinectCodes; ++code) {
    inverse_depth.push_back(static_cast<float>((kKinectRawAtInfinity - code) / (kKinectK_mm / 1000.0)));
    expected.push_back(table[static_cast<std::size_t>(code) + 1]);
  }
  std::vector<float> depth_m(inverse_depth.size());
  kinect_rows::read_codes(inverse_depth.data(), inverse_depth.size(), depth_m.data());
  CHECK(depth_m == expected);
}

TEST_CASE("what is beyond the codes, or not seen at all, has no depth") {
  const float nearer_than_any = static_cast<float>((kKinectRawAtInfinity + 1.0) / (kKinectK_mm / 1000.0));
  const std::vector<float> inverse_depth{nearer_than_any, 100.0F, 0.0F, -1.0F,
                                         std::numeric_limits<float>::quiet_NaN()};
  std::vector<float> depth_m(inverse_depth.size());
  kinect_rows::read_codes(inverse_depth.data(), inverse_depth.size(), depth_m.data());
  for (const float z : depth_m) CHECK(std::isnan(z));
}
