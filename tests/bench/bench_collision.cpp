// Is the arm free: FCL primitives against OctoMap's octree, spheres against distance fields. Every joint
// position is judged by both first; one that only FCL finds touching ends the program. CPU time of one
// thread.
#include <fmt/format.h>

#include <cstdlib>
#include <vector>

#include "bench_timing.hpp"
#include "tests/unit/planner/motion/collision/collision_world.hpp"

namespace {

using namespace colift;
using hal::JointVector;
using planner::Contacts;
using planner::Touch;

struct Verdicts {
  int fast_free = 0, exact_free = 0, missed = 0;
};

Verdicts judge(planner::FastChecker& fast, planner::ExactChecker& exact, const std::vector<JointVector>& qs) {
  Verdicts v;
  for (const JointVector& q : qs) {
    const bool free = fast.is_free(q), truly = exact.what_touches(q).with == Touch::With::Nothing;
    v.fast_free += free && truly;
    v.exact_free += truly;
    v.missed += free && !truly;
  }
  return v;
}

double us_each(std::size_t count, double ms) {
  return 1e3 * ms / static_cast<double>(count);
}

}  // namespace

int main(int argc, char** argv) {
  bench::keep_memory();
  const std::size_t states = argc > 1 ? static_cast<std::size_t>(std::atoll(argv[1])) : 100000;
  const test::CollisionWorld world;
  const hal::RobotModel& robot = hal::built_in_robot();
  const planner::SphereModel spheres = planner::cover_with_spheres(robot);
  planner::ExactChecker exact(robot, world.map, world.ground);

  std::vector<JointVector> random, near;
  sim_hal::Draws draws(21, 1);
  test::NearTable near_table(22);
  for (std::size_t i = 0; i < states; ++i) {
    random.push_back(test::draw_joints(draws));
    near.push_back(near_table.next());
  }

  fmt::print("{} spheres, {} pairs of links, {} occupied cells, {} of the target\n\n", spheres.spheres.size(),
             spheres.self_pairs.size(), world.map.occupied_cells(), world.map.target_cells().size());
  fmt::print(
      "| joint positions | contacts | margin mm | free by FCL | of these free by spheres | missed |\n"
      "| --- | --- | ---: | ---: | ---: | ---: |\n");
  planner::SceneConfig bare;
  bare.margin_m = bare.ground_clearance_m = 0.0;
  bare.hidden_is_obstacle = false;
  planner::SceneConfig usual;
  usual.hidden_is_obstacle = false;  // which FCL's octree does not have
  bool agree = true;
  for (const auto& [name, qs] : {std::pair{"random", &random}, {"near the table", &near}}) {
    for (const Contacts contacts : {Contacts::None, Contacts::FingersOnTarget}) {
      for (const planner::SceneConfig& config : {bare, usual}) {
        if (&qs[0] == &random && contacts != Contacts::None) continue;
        planner::FastChecker fast(robot, spheres, world.scene(config));
        fast.allow(contacts);
        exact.allow(contacts);
        const Verdicts v = judge(fast, exact, *qs);
        fmt::print("| {} {} | {} | {:.0f} | {} | {:.1f} % | {} |\n", qs->size(), name,
                   contacts == Contacts::None ? "none" : "fingers on target", 1e3 * config.margin_m,
                   v.exact_free, 100.0 * v.fast_free / std::max(1, v.exact_free), v.missed);
        agree = agree && v.missed == 0;
      }
    }
  }
  if (!agree) {
    fmt::print(stderr, "the spheres missed a collision; nothing is timed\n");
    return 1;
  }

  exact.allow(Contacts::None);
  const planner::SceneConfig config;
  planner::FastChecker fast(robot, spheres, world.scene(config));
  fmt::print(
      "\n| per state, us | FCL and OctoMap | spheres, one by one | in motions | ratio | ratio |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: |\n");
  for (const auto& [name, qs] : {std::pair{"random", &random}, {"near the table", &near}}) {
    const std::size_t few = std::min<std::size_t>(5000, qs->size());
    int found = 0;
    const double fcl = us_each(few, bench::time_ms(5, [&] {
                                 for (std::size_t i = 0; i < few; ++i)
                                   found += exact.what_touches((*qs)[i]).with == Touch::With::Nothing;
                               }));
    const double single = us_each(few, bench::time_ms(21, [&] {
                                    for (std::size_t i = 0; i < few; ++i) found += fast.is_free((*qs)[i]);
                                  }));
    // motions that are free, so that every state of them is looked at
    std::vector<std::pair<JointVector, JointVector>> motions;
    constexpr double kStep = 0.02;
    for (std::size_t i = 0; i < qs->size() && motions.size() < 500; ++i) {
      const JointVector a = (*qs)[i], b = a + 0.2 * (JointVector::Zero() - a);
      if (fast.is_free(a, b, kStep)) motions.emplace_back(a, b);
    }
    const std::size_t before = fast.checks();
    for (const auto& [a, b] : motions) found += fast.is_free(a, b, kStep);
    const std::size_t in_motions = fast.checks() - before;
    const double batched = us_each(in_motions, bench::time_ms(21, [&] {
                                     for (const auto& [a, b] : motions) found += fast.is_free(a, b, kStep);
                                   }));
    fmt::print("| {} | {:.1f} | {:.2f} | {:.2f} ({} states) | {:.0f} | {:.0f} |\n", name, fcl, single,
               batched, in_motions, fcl / single, fcl / batched);
    if (found < 0) return 1;
  }

  const double insert = bench::time_ms(11, [&] {
    perception::WorldMap map{perception::WorldMapConfig{}};
    map.insert(world.cloud, world.target_pixels);
  });
  perception::WorldMap map{perception::WorldMapConfig{}};
  const double again = bench::time_ms(11, [&] { map.insert(world.cloud, world.target_pixels); });
  const double tree = bench::time_ms(11, [&] {
    map.carve({hal::Vec3(9, 9, 9), hal::Vec3(9, 9, 9)});
    (void)map.tree();
  });
  const double fields = bench::time_ms(11, [&] { (void)world.scene(config); });
  const double exact_made =
      bench::time_ms(11, [&] { const planner::ExactChecker made(robot, world.map, world.ground); });
  const double cover = bench::time_ms(5, [&] { (void)planner::cover_with_spheres(robot); });
  fmt::print(
      "\n| once, ms | |\n| --- | ---: |\n| first frame into the map | {:.1f} |\n| another frame | {:.1f} |\n"
      "| octree of the map | {:.1f} |\n| collision scene: three distance fields | {:.1f} |\n"
      "| exact checker of a map | {:.1f} |\n| spheres and self pairs of the robot | {:.1f} |\n",
      insert, again, tree, fields, exact_made, cover);
}
