#include "sim_hal/synthetic/ray_caster.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>

#include "sim_hal/synthetic/hash_random.hpp"

using namespace colift::sim_hal;
using colift::hal::CameraIntrinsics;

namespace {

// a width that is no multiple of four, so that the last columns are tested too
const CameraIntrinsics kSmall{79, 60, 70.0, 72.0, 38.3, 30.7};

Vec3 ray_C(const CameraIntrinsics& k, int u, int v) {
  return {(u - k.cx) / k.fx, (v - k.cy) / k.fy, 1.0};
}

struct Traced {
  double depth_m = std::numeric_limits<double>::infinity();
  double closest_miss_m = std::numeric_limits<double>::infinity();  // of what the ray passed by
  Vec3 at = Vec3::Zero();
};

double nearest(const World& world, const Vec3& p) {
  double d = std::numeric_limits<double>::infinity();
  for (const Shape& s : world.shapes) d = std::min(d, distance(s, p));
  return d;
}

// sphere tracing in double precision: steps as long as the nearest surface is far
Traced trace(const World& world, const Pose& X_WC, const Vec3& direction_C) {
  const Vec3 direction = X_WC.linear() * direction_C;
  const double length = direction.norm();
  Traced result;
  double t = 0.0, before = std::numeric_limits<double>::infinity();
  bool approaching = true;
  for (int i = 0; i < 20000 && t * length < 12.0; ++i) {
    result.at = X_WC.translation() + t * direction;
    const double d = nearest(world, result.at);
    if (d < 1e-9) {
      result.depth_m = t;
      return result;
    }
    if (approaching && d > before) result.closest_miss_m = std::min(result.closest_miss_m, before);
    approaching = d < before;
    before = d;
    t += std::min(d, 0.3) / length;
  }
  return result;
}

World random_world(std::uint64_t seed, int shapes) {
  Draws d(seed, 7);
  World world;
  const auto point = [&] { return Vec3(d.between(-1.2, 1.2), d.between(-1.0, 1.0), d.between(-0.5, 1.5)); };
  for (int i = 0; i < shapes; ++i) {
    const Vec3 p = point(), q = p + Vec3(d.between(-0.6, 0.6), d.between(-0.6, 0.6), d.between(0.1, 0.6));
    switch (d.below(5)) {
      case 0: {
        Shape b =
            box(p, {d.between(0.02, 0.8), d.between(0.02, 0.8), d.between(0.02, 0.8)}, 0.0, Label::Target);
        b.X_WS.linear() = Eigen::AngleAxisd(d.between(0, 3), (q - p).normalized()).toRotationMatrix();
        world.shapes.push_back(b);
        break;
      }
      case 1:
        world.shapes.push_back(cylinder(p, q - p, d.between(0.01, 0.3), d.between(0.1, 1.2), Label::Clutter));
        break;
      case 2:
        world.shapes.push_back(capsule(p, q, d.between(0.01, 0.2), Label::Partner));
        break;
      case 3:
        world.shapes.push_back(sphere(p, d.between(0.02, 0.3), Label::Robot));
        break;
      default:
        world.shapes.push_back(half_space(point() - Vec3(0, 0, 2), q - p, Label::Ground));
        break;
    }
  }
  return world;
}

}  // namespace

TEST_CASE("every pixel shows what sphere tracing finds along its ray", "[ray_caster]") {
  int compared = 0, skipped = 0, inside = 0;
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    const World world = random_world(seed, 3 + static_cast<int>(seed % 10));
    Draws d(seed, 8);
    const Vec3 eye(d.between(-2.5, 2.5), d.between(-2.5, 2.5), d.between(0.2, 2.0));
    const Pose X_WC = look_at(eye, Vec3(d.between(-0.3, 0.3), d.between(-0.3, 0.3), 0.3));
    if (nearest(world, eye) < 0.01) {
      ++inside;
      continue;
    }
    const Rendering image = cast_rays(world, kSmall, X_WC);
    for (int v = 0; v < kSmall.height; ++v)
      for (int u = v % 3; u < kSmall.width; u += 3) {
        const Traced truth = trace(world, X_WC, ray_C(kSmall, u, v));
        const auto i = static_cast<std::size_t>(v * kSmall.width + u);
        const double depth = image.depth_m[i];
        if (std::isinf(truth.depth_m)) {
          // the far end of a half space is out of the tracer's reach
          if (!(depth > 10.0) && truth.closest_miss_m > 1e-4 && !std::isnan(depth)) {
            CAPTURE(seed, u, v, depth, truth.closest_miss_m);
            FAIL("a surface where there is none");
          }
          continue;
        }
        if (std::abs(depth - truth.depth_m) < 2e-5 * (1.0 + truth.depth_m * truth.depth_m)) {
          ++compared;
          REQUIRE(std::abs(distance(world.shapes.at(static_cast<std::size_t>(image.shape[i])), truth.at)) <
                  1e-4);
          REQUIRE(image.label[i] == world.shapes[static_cast<std::size_t>(image.shape[i])].label);
          continue;
        }
        // a ray that touches an edge may go to either side of it; then both answers are right
        const Vec3 p = X_WC * Vec3(ray_C(kSmall, u, v) * depth);
        const bool grazes = truth.closest_miss_m < 2e-4 || image.cos_incidence[i] < 0.02f;
        CAPTURE(seed, u, v, depth, truth.depth_m, truth.closest_miss_m, image.cos_incidence[i]);
        REQUIRE((grazes || std::abs(nearest(world, p)) < 1e-4));
        ++skipped;
      }
  }
  CHECK(compared > 12000);
  CHECK(skipped < compared / 200);
  CHECK(inside < 12);
}

namespace {

void require_same_image(const Rendering& a, const Rendering& b) {
  const std::size_t bytes = a.depth_m.size() * sizeof(float);
  REQUIRE(a.depth_m.size() == b.depth_m.size());
  REQUIRE(std::memcmp(a.depth_m.data(), b.depth_m.data(), bytes) == 0);
  REQUIRE(std::memcmp(a.cos_incidence.data(), b.cos_incidence.data(), bytes) == 0);
  REQUIRE(a.shape == b.shape);
  REQUIRE(a.label == b.label);
  REQUIRE(a.reflectivity == b.reflectivity);
}

}  // namespace

TEST_CASE("a camera that stands still sees what a new one would see, whatever moves, comes or goes",
          "[ray_caster]") {
  const Pose X_WC = look_at({-2.5, 0.4, 1.1}, {0, 0, 0.3});
  for (const CameraIntrinsics& k : {kSmall, CameraIntrinsics{300, 40, 260.0, 262.0, 151.0, 20.0}}) {
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
      RayCaster caster(k, X_WC);
      World world = random_world(seed, 14);
      Draws d(seed, 8);
      for (int frame = 0; frame < 12; ++frame) {
        CAPTURE(seed, frame);
        require_same_image(caster.cast(world), cast_rays(world, k, X_WC));
        Shape& moved = world.shapes[static_cast<std::size_t>(d.below(static_cast<int>(world.shapes.size())))];
        switch (d.below(6)) {
          case 0:
            moved.X_WS.translation() +=
                Vec3(d.between(-0.2, 0.2), d.between(-0.2, 0.2), d.between(-0.2, 0.2));
            break;
          case 1:
            moved.X_WS.rotate(Eigen::AngleAxisd(d.between(0, 3), Vec3(1, 2, 3).normalized()));
            break;
          case 2:
            moved.label = Label::Partner;
            moved.reflectivity = d.between(0, 1);
            break;
          case 3:
            moved.size *= d.between(0.5, 1.5);
            break;
          case 4:
            world.shapes.pop_back();
            break;
          default:
            world.shapes.push_back(random_world(seed + 100, 1).shapes[0]);
            break;
        }
      }
    }
  }
}

TEST_CASE("what creeps is followed to within a few micrometres", "[ray_caster]") {
  const CameraIntrinsics k{64, 48, 57.6, 57.6, 32, 24};
  World world;
  world.shapes.push_back(box({0, 0, 1.5}, {1, 1, 0.2}, 0.0, Label::Target));
  RayCaster caster(k, Pose::Identity());
  for (int frame = 0; frame < 400; ++frame) {
    const double seen = static_cast<double>(caster.cast(world).depth_m[24 * 64 + 32]);
    REQUIRE(std::abs(seen - (world.shapes[0].X_WS.translation().z() - 0.1)) < 2e-6);
    world.shapes[0].X_WS.translation().z() -= 3e-7;
  }
}

TEST_CASE("incidence is the cosine between ray and surface normal", "[ray_caster]") {
  int compared = 0;
  for (std::uint64_t seed = 100; seed < 108; ++seed) {
    const World world = random_world(seed, 8);
    const Pose X_WC = look_at({2.4, 0.4, 1.9}, {0, 0, 0.3});
    if (nearest(world, X_WC.translation()) < 0.01) continue;
    const Rendering image = cast_rays(world, kSmall, X_WC);
    for (int v = 0; v < kSmall.height; v += 3)
      for (int u = 0; u < kSmall.width; u += 2) {
        const auto i = static_cast<std::size_t>(v * kSmall.width + u);
        if (image.shape[i] < 0 || image.depth_m[i] > 10.0f) continue;
        const Shape& shape = world.shapes[static_cast<std::size_t>(image.shape[i])];
        const Vec3 direction = X_WC.linear() * ray_C(kSmall, u, v).normalized();
        const Vec3 p = X_WC * Vec3(ray_C(kSmall, u, v) * static_cast<double>(image.depth_m[i]));
        constexpr double h = 1e-5;
        Vec3 gradient;
        for (int a = 0; a < 3; ++a)
          gradient[a] =
              (distance(shape, p + h * Vec3::Unit(a)) - distance(shape, p - h * Vec3::Unit(a))) / (2 * h);
        if (std::abs(gradient.norm() - 1.0) > 1e-3) continue;  // on an edge
        ++compared;
        REQUIRE(image.cos_incidence[i] == Approx(std::abs(gradient.dot(direction))).margin(2e-3));
      }
  }
  CHECK(compared > 2000);
}

TEST_CASE("a box seen from the front lies where the pinhole model puts it", "[ray_caster]") {
  const CameraIntrinsics k;
  World world;
  world.shapes.push_back(box({0, 0, 2.1}, {0.4, 0.3, 0.2}, 0.0, Label::Target));
  const Rendering image = cast_rays(world, k, Pose::Identity());
  int columns = 0, rows = 0;
  for (int u = 0; u < k.width; ++u)
    columns += image.label[static_cast<std::size_t>(240 * k.width + u)] == Label::Target;
  for (int v = 0; v < k.height; ++v)
    rows += image.label[static_cast<std::size_t>(v * k.width + 320)] == Label::Target;
  CHECK(std::abs(columns - 0.4 * k.fx / 2.0) <= 1.0);
  CHECK(std::abs(rows - 0.3 * k.fy / 2.0) <= 1.0);
  CHECK(image.depth_m[240 * 640 + 320] == Approx(2.0f).margin(1e-6));
  CHECK(image.cos_incidence[240 * 640 + 320] == Approx(1.0f).margin(1e-6));
  CHECK(std::isnan(image.depth_m[0]));
  CHECK(image.shape[0] == -1);
  CHECK(image.label[0] == Label::Nothing);
}

TEST_CASE("what is behind the camera, around it, or has no size is not seen", "[ray_caster]") {
  World world;
  world.shapes.push_back(box({0, 0, -2}, {1, 1, 1}, 0.0, Label::Target));
  world.shapes.push_back(sphere({0, 0, 0}, 0.5, Label::Target));
  world.shapes.push_back(cylinder({0, 0, 0}, {0, 0, 1}, 0.5, 1.0, Label::Target));
  world.shapes.push_back(box({0, 0, 0}, {1, 1, 1}, 0.0, Label::Target));
  world.shapes.push_back(half_space({0, 0, 1}, {0, 0, 1}, Label::Target));
  world.shapes.push_back(box({0, 0, 2}, {1, 0, 1}, 0.0, Label::Target));
  world.shapes.push_back(sphere({0, 0, 2}, 0.0, Label::Target));
  const Rendering image = cast_rays(world, kSmall, Pose::Identity());
  for (const Label label : image.label) REQUIRE(label == Label::Nothing);
}

TEST_CASE("a camera beside a long cylinder sees its cap and its side", "[ray_caster]") {
  // the camera stands within the cylinder's radius, before its end: only the cap is in sight
  World world;
  world.shapes.push_back(cylinder({0, 0, 2}, {0, 0, 1}, 0.5, 2.0, Label::Target));
  const Rendering image = cast_rays(world, kSmall, Pose::Identity());
  for (std::size_t i = 0; i < image.depth_m.size(); ++i)
    if (image.shape[i] == 0) REQUIRE(image.depth_m[i] == Approx(1.0f).margin(1e-6));
}

TEST_CASE("image rows are level with the floor", "[ray_caster]") {
  const Pose X_WC = look_at({1.5, -0.7, 1.2}, {0.1, 0.2, 0.3});
  CHECK(X_WC.linear().determinant() == Approx(1.0));
  CHECK((X_WC.linear().transpose() * X_WC.linear()).isApprox(Eigen::Matrix3d::Identity(), 1e-12));
  CHECK(std::abs(X_WC.linear().col(0).z()) < 1e-12);
  CHECK(X_WC.linear().col(1).z() < 0);  // image down is world down
  CHECK((X_WC.inverse() * Vec3(0.1, 0.2, 0.3)).head<2>().norm() < 1e-12);
  CHECK(look_at({0, 0, 2}, {0, 0, 0}).linear().determinant() == Approx(1.0));
}

TEST_CASE("signed distances are those of the plain formulas", "[shapes]") {
  CHECK(distance(box({1, 0, 0}, {2, 2, 2}, 0.0, Label::Target), {3, 0, 0}) == Approx(1.0));
  CHECK(distance(box({0, 0, 0}, {2, 2, 2}, 0.0, Label::Target), {2, 2, 2}) == Approx(std::sqrt(3.0)));
  CHECK(distance(box({0, 0, 0}, {2, 4, 6}, 0.0, Label::Target), {0.9, 0, 0}) == Approx(-0.1));
  CHECK(distance(cylinder({0, 0, 0}, {0, 0, 1}, 0.5, 2.0, Label::Target), {1.5, 0, 1}) == Approx(1.0));
  CHECK(distance(cylinder({0, 0, 0}, {1, 0, 0}, 0.5, 2.0, Label::Target), {1.3, 0.9, 0}) == Approx(0.5));
  CHECK(distance(capsule({0, 0, 0}, {0, 0, 1}, 0.2, Label::Target), {0, 0, 1.5}) == Approx(0.3));
  CHECK(distance(sphere({0, 0, 1}, 0.2, Label::Target), {0, 0, 1}) == Approx(-0.2));
  CHECK(distance(half_space({0, 0, 1}, {0, 0, 2}, Label::Target), {5, 5, 0}) == Approx(-1.0));
}
