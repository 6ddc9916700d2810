// How cost grows with what there is: pixels, candidates, points of people, poses, agents. Each stage is timed
// over at least a tenfold of its size; the exponent is the slope of log time over log size by least squares,
// 1 for linear. With a file's name after the program's: the curves as a picture. CPU time of one thread,
// medians.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench_timing.hpp"
#include "control/session/decide.hpp"
#include "perception/ground/ground.hpp"
#include "perception/map/world_map.hpp"
#include "perception/surfaces/find_surfaces.hpp"
#include "perception/target/target.hpp"
#include "planner/load_sharing/several_agents.hpp"
#include "planner/motion/motion_planner.hpp"
#include "sim_hal/synthetic/kinect/kinect_noise.hpp"
#include "sim_hal/synthetic/scenes.hpp"
#include "tests/unit/planner/motion/collision/collision_world.hpp"
#include "tools/visualization/line_plot.hpp"
#include "tools/visualization/palette.hpp"

using namespace colift;

namespace {

constexpr int kRounds = 9;
constexpr std::uint64_t kSeed = 1;

struct Point {
  double size = 0.0, ms = 0.0;
};
struct Curve {
  std::string stage, unit;
  std::vector<Point> points;

  [[nodiscard]] double exponent() const {
    double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
    for (const Point& p : points) {
      const double x = std::log(p.size), y = std::log(p.ms);
      sx += x, sy += y, sxx += x * x, sxy += x * y;
    }
    const auto n = static_cast<double>(points.size());
    return (n * sxy - sx * sy) / (n * sxx - sx * sx);
  }
};

/// The same room through lenses of other resolutions.
struct Room {
  control::Config config;
  planner::HandModel hand;
  hal::SteadyClock clock;
  std::shared_ptr<const planner::HandCollision> tables =
      std::make_shared<const planner::HandCollision>(hand, config.candidates.collision);
  sim_hal::SyntheticScene scene = sim_hal::make_scene(sim_hal::ObjectKind::Table, kSeed);
  hal::DepthFrame frame;
  std::optional<control::SceneAnalysis> analysis;

  explicit Room(double scale) {
    hal::CameraIntrinsics k = scene.intrinsics;
    k.width = static_cast<int>(k.width * scale);
    k.height = static_cast<int>(k.height * scale);
    for (double* v : {&k.fx, &k.fy, &k.cx, &k.cy}) *v *= scale;
    frame = sim_hal::measure(sim_hal::cast_rays(scene.world, k, scene.X_WC), {}, kSeed);
    control::SceneAnalysisInput in;
    in.frame = frame;
    in.X_WC = scene.X_WC;
    in.base_frame_known = true;
    auto seen = control::analyse_scene(in, control::Method::Fast, config, hand, clock, tables);
    if (!seen || !seen->scene.target) {
      fmt::print(stderr, "no object is found at {} x {}\n", k.width, k.height);
      std::exit(1);
    }
    analysis = std::move(*seen);
  }
};

void add_pixels(std::vector<Curve>& curves) {
  using namespace perception;
  std::array<Curve, 3> of{Curve{"frame to target", "pixels", {}}, Curve{"surfaces", "pixels", {}},
                          Curve{"map of a frame", "pixels", {}}};
  for (const double scale : {0.5, 1.0, 1.5, 2.0}) {
    const Room r(scale);
    const double pixels = static_cast<double>(r.frame.depth_m.size());
    of[0].points.push_back(
        {pixels, bench::time_ms(kRounds, [&] {
           const OrganisedCloud cloud = deproject(r.frame, r.scene.X_WC);
           const auto blocks = fit_block_planes(cloud, r.config.noise);
           const auto ground =
               find_ground(cloud, blocks, hal::Vec3::UnitZ(), r.config.noise, r.config.ground);
           (void)find_target(cloud, blocks, *ground.ground, r.config.noise, r.config.target);
         })});
    const Scene& scene = r.analysis->scene;
    of[1].points.push_back({pixels, bench::time_ms(kRounds, [&] {
                              (void)find_surfaces(r.analysis->cloud, *scene.target, *scene.ground,
                                                  r.config.noise, r.config.surfaces);
                            })});
    of[2].points.push_back({pixels, bench::time_ms(kRounds, [&] {
                              WorldMap map(r.config.map);
                              map.insert(r.analysis->cloud, scene.target->pixels);
                              (void)map.grid();
                            })});
  }
  curves.insert(curves.end(), of.begin(), of.end());
}

void add_candidates(std::vector<Curve>& curves) {
  const Room r(1.0);
  Curve found{"grasp candidates", "candidates", {}};
  for (const double step_m : {0.4, 0.15, 0.05, 0.015, 0.006}) {
    planner::CandidateConfig config = r.config.candidates;
    config.step_m = step_m;
    std::size_t n = 0;
    const double ms = bench::time_ms(kRounds, [&] {
      n = planner::CandidateFinder(r.analysis->scene, &r.analysis->cloud, r.hand, config, r.tables)
              .find()
              .size();
    });
    found.points.push_back({static_cast<double>(n), ms});
  }
  curves.push_back(found);
}

void add_people(std::vector<Curve>& curves) {
  const test::CollisionWorld world;
  const planner::CollisionScene scene = planner::make_collision_scene(world.map, world.ground, {});
  Curve curve{"people entered before a plan", "points", {}};
  for (const int n : {1000, 4000, 16000, 64000}) {
    std::vector<Eigen::Vector3f> points;
    for (int i = 0; i < n; ++i) {
      const float turn = 0.618034F * static_cast<float>(i),
                  z = 1.7F * static_cast<float>(i) / static_cast<float>(n);
      points.emplace_back(1.3F + 0.2F * std::cos(turn), 0.3F + 0.2F * std::sin(turn), z);
    }
    curve.points.push_back({static_cast<double>(n), bench::time_ms(kRounds, [&] {
                              (void)planner::with_partner(scene, world.map.grid(), points);
                            })});
  }
  curves.push_back(curve);
}

void add_sharing(std::vector<Curve>& curves) {
  constexpr int kCandidates = 1000;
  const auto tasks = [](int n) {
    std::vector<hal::Wrench> all;
    for (int i = 0; i < n; ++i)
      all.push_back(
          {hal::Vec3(std::sin(i), std::cos(i), 40.0), hal::Vec3(0.1 * std::cos(i), 0.2, 0.05 * i / n)});
    return all;
  };
  Curve poses{"1000 candidates ranked, two agents", "poses", {}},
      agents{"1000 candidates ranked, one pose", "agents", {}};
  const auto time_of = [&](int n_agents, int n_poses) {
    std::vector<planner::CarryingAgent> all;
    for (int i = 0; i < n_agents; ++i)
      all.push_back({hal::Vec3(0.6 * std::cos(2.0 * i), 0.6 * std::sin(2.0 * i), 0.0), 1.0 + 0.1 * i});
    auto sharing = planner::SeveralAgents::create(all);
    if (!sharing) std::exit(1);
    const auto wrenches = tasks(n_poses);
    double sum = 0.0;
    const double ms = bench::time_ms(kRounds, [&] {
      for (int c = 0; c < kCandidates; ++c) {
        sharing->move(0, hal::Vec3(0.001 * c, 0.2, 0.1));
        sum += sharing->cost(wrenches);
      }
    });
    return std::isfinite(sum) ? ms : NAN;
  };
  for (const int n : {1, 10, 100, 1000}) poses.points.push_back({static_cast<double>(n), time_of(2, n)});
  for (const int n : {2, 8, 32, 128}) agents.points.push_back({static_cast<double>(n), time_of(n, 1)});
  curves.push_back(poses);
  curves.push_back(agents);
}

void write_picture(const std::vector<Curve>& curves, const std::string& file) {
  picture::LinePlot plot;
  plot.x_title = "size over the smallest one (tens to the power of)";
  // hues of Okabe and Ito
  const std::array colours{picture::kRobot, picture::kPartner, picture::kCog, picture::rgb(0xD55E00)};
  for (const bool of_pixels : {true, false}) {
    picture::PlotPanel panel;
    panel.title = of_pixels ? "Cost over pixels (tens to the power of)" : "Cost over the others";
    for (const Curve& c : curves) {
      if ((c.unit == "pixels") != of_pixels) continue;
      picture::PlotLine line{
          of_pixels ? c.stage : c.unit, colours[panel.lines.size() % colours.size()], {}, {}};
      for (const Point& p : c.points) {
        line.x.push_back(std::log10(p.size / c.points.front().size));
        line.y.push_back(std::log10(p.ms / c.points.front().ms));
      }
      panel.lines.push_back(std::move(line));
    }
    const double most = of_pixels ? 1.5 : 3.0;
    panel.lines.push_back({"linear", picture::kInk, {0.0, most}, {0.0, most}, true});
    plot.panels.push_back(std::move(panel));
  }
  if (auto done = picture::draw_line_plot(plot).write_png(file); !done) {
    fmt::print(stderr, "{}\n", done.error().text());
    std::exit(1);
  }
}

}  // namespace

int main(int argc, char** argv) {
  bench::keep_memory();
  std::vector<Curve> curves;
  add_pixels(curves);
  add_candidates(curves);
  add_people(curves);
  add_sharing(curves);
  fmt::print("| stage | size: ms | exponent |\n| --- | --- | ---: |\n");
  for (const Curve& c : curves) {
    std::string points;
    for (const Point& p : c.points)
      points += fmt::format("{}{:.0f}: {:.3g}", points.empty() ? "" : ", ", p.size, p.ms);
    fmt::print("| {} | {} {} | {:.2f} |\n", c.stage, c.unit, points, c.exponent());
  }
  if (argc > 1) write_picture(curves, argv[1]);
}
