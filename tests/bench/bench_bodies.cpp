#include <benchmark/benchmark.h>

#include <vector>

#include "../unit/perception/bodies/room.hpp"
#include "control/monitor/swept_volume.hpp"
#include "perception/bodies/body_distance.hpp"
#include "perception/bodies/body_tracker.hpp"

// One frame of separation monitoring, stage by stage: a room with the arm before a table, a person and a
// second one. Goal: at most 3 ms for all of it on one core.

namespace {

using namespace colift;
using hal::Vec3;
using perception::test::Room;

struct Stage {
  Room room{sim_hal::ObjectKind::Table, 3};
  perception::BodyFinder finder = room.finder();
  hal::DepthFrame image;
  control::SweptVolume arm{room.model};
  perception::SphereSet links, path;

  Stage() {
    sim_hal::World world = room.scene.world;
    const Vec3 eye = room.scene.X_WC.translation();
    const Vec3 side = (room.object_at - eye).cross(Vec3::UnitZ()).normalized();
    for (const double off : {0.7, -0.9}) {
      sim_hal::Posture p;
      p.facing = off > 0 ? Vec3(-side) : side;
      p.right_shoulder = Vec3(0, 0, 1.42) + room.object_at + off * side;
      p.right_shoulder.z() = 1.42;
      p.left_shoulder = p.right_shoulder - 0.36 * p.facing.cross(Vec3::UnitZ());
      sim_hal::add_person(world, p);
    }
    image = room.frame(world, 0.3);
    for (int i = 0; i <= 24; ++i) arm.add_links(room.posture(0.3 + 0.7 * i / 24.0), room.hand, path);
    arm.add_links(room.posture(0.3), room.hand, links);
  }
  static Stage& get() {
    static Stage stage;
    return stage;
  }
};

void remove_robot(benchmark::State& state) {
  Stage& s = Stage::get();
  hal::DepthFrame frame;
  for (auto _ : state) {
    frame = s.image;
    benchmark::DoNotOptimize(s.room.filter[0].remove(frame, s.room.posture(0.3), s.room.hand).size());
  }
}

void find_bodies(benchmark::State& state) {
  Stage& s = Stage::get();
  hal::DepthFrame frame = s.image;
  const auto robot = s.room.filter[0].remove(frame, s.room.posture(0.3), s.room.hand);
  for (auto _ : state) benchmark::DoNotOptimize(s.finder.find(frame, robot).size());
}

void distances(benchmark::State& state) {
  Stage& s = Stage::get();
  const auto& bodies = s.room.bodies(s.finder, s.image, 0.3);
  for (auto _ : state)
    for (const auto& body : bodies) {
      perception::Approach near;
      benchmark::DoNotOptimize(nearest_approach(s.finder.points(body), s.links, 1.5, near));
      benchmark::DoNotOptimize(nearest_approach(s.finder.points(body), s.path, 1.5, near));
    }
}

void place_arm(benchmark::State& state) {
  Stage& s = Stage::get();
  perception::SphereSet out;
  for (auto _ : state) {
    out.clear();
    for (int i = 0; i <= 24; ++i) s.arm.add_links(s.room.posture(i / 24.0), s.room.hand, out);
    benchmark::DoNotOptimize(out.size());
  }
}

void whole_frame(benchmark::State& state) {
  Stage& s = Stage::get();
  hal::DepthFrame frame;
  perception::SphereSet links, path;
  perception::BodyTracker tracker;
  hal::Timestamp at{0};
  for (auto _ : state) {
    frame.intrinsics = s.image.intrinsics;
    frame.depth_m.assign(s.image.depth_m.begin(), s.image.depth_m.end());
    const auto& robot = s.room.filter[0].remove(frame, s.room.posture(0.3), s.room.hand);
    const auto& bodies = s.finder.find(frame, robot);
    benchmark::DoNotOptimize(tracker.update(at += std::chrono::milliseconds(33), bodies).size());
    path.clear();
    for (int i = 0; i <= 24; ++i) s.arm.add_links(s.room.posture(0.3 + 0.7 * i / 24.0), s.room.hand, path);
    links.clear();
    s.arm.add_links(s.room.posture(0.3), s.room.hand, links);
    perception::Approach near;
    for (const auto& body : bodies) {
      benchmark::DoNotOptimize(nearest_approach(s.finder.points(body), links, 1.5, near));
      benchmark::DoNotOptimize(nearest_approach(s.finder.points(body), path, 1.5, near));
    }
  }
}

BENCHMARK(remove_robot)->Unit(benchmark::kMillisecond);
BENCHMARK(find_bodies)->Unit(benchmark::kMillisecond);
BENCHMARK(distances)->Unit(benchmark::kMillisecond);
BENCHMARK(place_arm)->Unit(benchmark::kMillisecond);
BENCHMARK(whole_frame)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
