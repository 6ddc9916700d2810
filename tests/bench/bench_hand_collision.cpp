#include <benchmark/benchmark.h>
#include <pcl/filters/crop_box.h>
#include <pcl/point_types.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>

#include "planner/grasp/grasp_candidates.hpp"
#include "sim_hal/synthetic/scenes.hpp"

// The hand against a table's points, as the thesis would do it with PCL (a stock pcl::CropBox for every
// cuboid of the hand) and with buckets and tables. Agreement of the verdicts is checked first; a disagreement
// ends the program. The way of the approach is left out on both sides: a tilted cuboid drawn out along a line
// is not a CropBox.

namespace {

using namespace colift;
using hal::Vec3;
using Cloud = pcl::PointCloud<pcl::PointXYZ>;

struct Setup {
  planner::HandCollision hand{planner::HandModel{}, [] {
                                planner::CollisionConfig config;
                                config.approach_m = 0.0;
                                return config;
                              }()};
  planner::Obstacles obstacles;
  Cloud::Ptr cloud{new Cloud};
  std::vector<planner::HandPlacement> open, closing;
};

const Setup& setup() {
  static const Setup made = [] {
    Setup s;
    const auto truth = sim_hal::make_scene(sim_hal::ObjectKind::Table, 3);
    const auto image = sim_hal::cast_rays(truth.world, truth.intrinsics, truth.X_WC);
    const auto cloud = perception::deproject(sim_hal::measure(image, sim_hal::KinectNoise{}, 1), truth.X_WC);
    hal::Aabb around;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      if (!cloud.seen(i) || image.label[i] != sim_hal::Label::Target) continue;
      const Eigen::Vector3f p = cloud.point(i).cast<float>();
      s.obstacles.add(p, planner::ObstacleKind::Object);
      s.cloud->emplace_back(p.x(), p.y(), p.z());
      around.extend(p.cast<double>());
    }
    s.obstacles.build();

    // hands around the rim of the top, at all angles
    std::uint64_t state = 5;
    const auto next = [&] {
      state = state * 6364136223846793005ULL + 1442695040888963407ULL;
      return static_cast<double>(state >> 11) * 0x1.0p-53;
    };
    for (int i = 0; i < 200; ++i) {
      planner::GraspCandidate c;
      const double turn = 2 * std::numbers::pi * next(), tilt = (next() - 0.5) * 0.6;
      const Vec3 out(std::cos(turn), std::sin(turn), 0.0);
      c.approach = (-std::cos(tilt) * out - std::sin(tilt) * Vec3::UnitZ()).normalized();
      c.closing = (Vec3::UnitZ() - c.approach * c.approach.z()).normalized();
      const Vec3 top(around.center().x(), around.center().y(), around.max().z() - 0.02);
      c.position = top + (0.2 + 0.5 * next()) * out + 0.04 * (next() - 0.5) * Vec3::UnitZ();
      c.width = 0.03;
      s.closing.push_back(s.hand.place(c, nullptr));
      c.width = 1.0;  // nothing is closed: the open hand alone
      s.open.push_back(s.hand.place(c, nullptr));
    }
    return s;
  }();
  return made;
}

bool crop_box_collides(pcl::CropBox<pcl::PointXYZ>& crop, const planner::HandBox& box,
                       const planner::HandPlacement& at, const Cloud& cloud, pcl::Indices& found) {
  // the box's own axes: Hx, its first and its second axis in the plane of the finger
  hal::Pose X_HB = hal::Pose::Identity();
  X_HB.linear() << 1, 0, 0, 0, box.ey, -box.ez, 0, box.ez, box.ey;
  X_HB.translation() = Vec3(box.cx, box.cy, box.cz);
  const Eigen::Affine3f X_BW((at.X_WH * X_HB).inverse().matrix().cast<float>());
  crop.setTransform(X_BW);
  crop.setMin({-static_cast<float>(box.hx), -static_cast<float>(box.h1), -static_cast<float>(box.h2), 1.0f});
  crop.setMax({static_cast<float>(box.hx), static_cast<float>(box.h1), static_cast<float>(box.h2), 1.0f});
  crop.filter(found);
  const hal::Pose X_HW = at.X_WH.inverse();
  for (const auto i : found) {
    const Vec3 p = X_HW * cloud[static_cast<std::size_t>(i)].getVector3fMap().cast<double>();
    const bool feature = std::abs(p.y()) <= 0.5 * at.width_m + at.margin_m && p.z() >= at.gap_m - at.margin_m;
    if (!feature) return true;
  }
  return false;
}

bool stock(const planner::HandPlacement& at) {
  const Setup& s = setup();
  pcl::CropBox<pcl::PointXYZ> crop;
  crop.setInputCloud(s.cloud);
  pcl::Indices found;
  for (const auto& box : s.hand.sweep().fixed_boxes()) {
    if (crop_box_collides(crop, box, at, *s.cloud, found)) return true;
  }
  for (int k = 0; k <= s.hand.sweep().last_step(at.width_m); ++k) {
    for (std::size_t i = 0; i < s.hand.sweep().links(); ++i) {
      if (crop_box_collides(crop, s.hand.sweep().finger_boxes(k)[i], at, *s.cloud, found)) return true;
    }
  }
  return false;
}

void agree() {
  const Setup& s = setup();
  int collisions = 0;
  for (const auto* list : {&s.open, &s.closing}) {
    for (const auto& at : *list) {
      const bool ours = s.hand.check(at, s.obstacles).has_value();
      if (ours != stock(at)) {
        std::fprintf(stderr, "verdicts differ\n");
        std::exit(1);
      }
      collisions += ours;
    }
  }
  std::printf("%zu points, 400 hands, %d collide, all verdicts agree with pcl::CropBox\n", s.obstacles.size(),
              collisions);
}

void crop_box(benchmark::State& state, const std::vector<planner::HandPlacement>& hands) {
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(stock(hands[i++ % hands.size()]));
}
void fast(benchmark::State& state, const std::vector<planner::HandPlacement>& hands) {
  const Setup& s = setup();
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(s.hand.check(hands[i++ % hands.size()], s.obstacles));
}
void build(benchmark::State& state) {
  const Setup& s = setup();
  for (auto _ : state) {
    planner::Obstacles o;
    for (std::size_t i = 0; i < s.obstacles.size(); ++i) o.add(s.obstacles.points()[i], s.obstacles.kind(i));
    o.build();
    benchmark::DoNotOptimize(o.size());
  }
}

}  // namespace

int main(int argc, char** argv) {
  agree();
  const Setup& s = setup();
  // as many iterations as there are hands, so that both sides meet the same ones
  const auto hands = static_cast<benchmark::IterationCount>(s.open.size());
  const auto us = benchmark::kMicrosecond;
  benchmark::RegisterBenchmark("hand_collision/open/pcl_crop_box", crop_box, s.open)
      ->Iterations(hands)
      ->Unit(us);
  benchmark::RegisterBenchmark("hand_collision/open/fast", fast, s.open)->Iterations(50 * hands)->Unit(us);
  benchmark::RegisterBenchmark("hand_collision/closing/pcl_crop_box", crop_box, s.closing)
      ->Iterations(hands)
      ->Unit(us);
  benchmark::RegisterBenchmark("hand_collision/closing/fast", fast, s.closing)
      ->Iterations(50 * hands)
      ->Unit(us);
  benchmark::RegisterBenchmark("hand_collision/build_buckets", build)->Unit(us);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
