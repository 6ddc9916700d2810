#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <vector>

#include "../unit/perception/self_filter/robot_view.hpp"
#include "bench_timing.hpp"

// The robot's pixels of a frame: every point against every link shape, as stock filters do it, and the self
// filter's rows. Both have to agree on frames without noise before they are timed on noisy ones.

namespace {

using namespace colift;
using hal::Vec3;
using perception::test::RobotView;

constexpr std::uint64_t kFirstView = 1, kViews = 12;

/// Every point into the frame of every shape, its distance against the padding; ends at the first hit.
class PerPoint {
 public:
  PerPoint(const RobotView& view, double padding_m) : view_(view), padding_(padding_m) {}

  std::size_t remove(hal::DepthFrame& frame) {
    hal::link_poses(view_.model, view_.q_rad, view_.hand, X_WL_);
    shapes_.clear();
    for (std::size_t i = 0; i < view_.model.links.size(); ++i)
      for (const auto& shape : view_.model.links[i].shapes) {
        const hal::Pose X_CS = view_.scene.X_WC.inverse() * X_WL_[i] * shape.X_LS;
        shapes_.push_back({X_CS.inverse().cast<float>(), shape.kind, shape.size.cast<float>()});
      }
    const auto& k = frame.intrinsics;
    std::size_t removed = 0;
    for (int v = 0; v < k.height; ++v)
      for (int u = 0; u < k.width; ++u) {
        float& z = frame.depth_m[static_cast<std::size_t>(v * k.width + u)];
        if (!(z > 0)) continue;
        const Eigen::Vector3f p(
            (static_cast<float>(u) - static_cast<float>(k.cx)) / static_cast<float>(k.fx) * z,
            (static_cast<float>(v) - static_cast<float>(k.cy)) / static_cast<float>(k.fy) * z, z);
        const bool robot = std::any_of(shapes_.begin(), shapes_.end(), [&](const Solid& s) {
          return distance(s, p) < static_cast<float>(padding_);
        });
        if (!robot) continue;
        z = std::numeric_limits<float>::quiet_NaN();
        ++removed;
      }
    return removed;
  }

 private:
  struct Solid {
    Eigen::Isometry3f X_SC;
    hal::LinkShape::Kind kind;
    Eigen::Vector3f size;
  };
  static float distance(const Solid& s, const Eigen::Vector3f& p_C) {
    const Eigen::Vector3f p = s.X_SC * p_C;
    if (s.kind == hal::LinkShape::Kind::Sphere) return p.norm() - s.size[0];
    if (s.kind == hal::LinkShape::Kind::Box) return (p.cwiseAbs() - 0.5f * s.size).cwiseMax(0.0f).norm();
    const float across = std::max(0.0f, p.head<2>().norm() - s.size[0]);
    const float along = std::max(0.0f, std::abs(p.z()) - 0.5f * s.size[1]);
    return std::sqrt(across * across + along * along);
  }

  const RobotView& view_;
  double padding_;
  std::vector<hal::Pose> X_WL_;
  std::vector<Solid> shapes_;
};

const std::vector<RobotView>& views() {
  static const auto made = [] {
    std::vector<RobotView> v;
    for (std::uint64_t seed = kFirstView; seed < kFirstView + kViews; ++seed) v.emplace_back(seed);
    return v;
  }();
  return made;
}

/// Without noise: what lies within the padding has to go in both, what lies beyond the padded corners in
/// none.
void agree() {
  std::size_t robot = 0, corners = 0;
  perception::NoiseModel exact;
  exact.sigma0_m = exact.sigma2_per_m = exact.step2_per_m = 0.0;
  perception::SelfFilterConfig config;
  config.shadow_padding_px = 0.0;
  for (const RobotView& view : views()) {
    const hal::DepthFrame ideal = sim_hal::measure_ideal(view.truth);
    hal::DepthFrame ours = ideal, inner = ideal, outer = ideal;
    perception::SelfFilter(view.model, view.scene.intrinsics, view.scene.X_WC, exact, config)
        .remove(ours, view.q_rad, view.hand);
    robot += PerPoint(view, config.padding_m - 2e-4).remove(inner);
    PerPoint(view, std::sqrt(3.0) * config.padding_m + 2e-4).remove(outer);
    for (std::size_t i = 0; i < ideal.depth_m.size(); ++i) {
      if (!(ideal.depth_m[i] > 0)) continue;
      const bool ours_gone = !(ours.depth_m[i] > 0), inner_gone = !(inner.depth_m[i] > 0);
      const bool outer_gone = !(outer.depth_m[i] > 0);
      corners += ours_gone && !inner_gone ? 1 : 0;
      if ((inner_gone && !ours_gone) || (ours_gone && !outer_gone)) {
        std::fprintf(stderr, "the filters disagree\n");
        std::exit(1);
      }
    }
  }
  std::printf("%d views, %zu pixels of the robot: all verdicts agree (%zu pixels at padded corners)\n",
              static_cast<int>(kViews), robot, corners);
}

void per_point(benchmark::State& state) {
  std::vector<PerPoint> filters;
  for (const RobotView& view : views()) filters.emplace_back(view, 0.015);
  hal::DepthFrame frame = views().front().frame;
  std::size_t i = 0;
  for (auto _ : state) {
    const RobotView& view = views()[i % kViews];
    frame.depth_m = view.frame.depth_m;
    benchmark::DoNotOptimize(filters[i % kViews].remove(frame));
    ++i;
  }
}

void self_filter(benchmark::State& state) {
  std::vector<perception::SelfFilter> filters;
  for (const RobotView& view : views()) filters.push_back(view.filter());
  hal::DepthFrame frame = views().front().frame;
  std::size_t i = 0;
  for (auto _ : state) {
    const RobotView& view = views()[i % kViews];
    frame.depth_m = view.frame.depth_m;
    benchmark::DoNotOptimize(filters[i % kViews].remove(frame, view.q_rad, view.hand).size());
    ++i;
  }
}

/// What both pay for: the frame has to be put back.
void copy_alone(benchmark::State& state) {
  hal::DepthFrame frame = views().front().frame;
  std::size_t i = 0;
  for (auto _ : state) {
    frame.depth_m = views()[i++ % kViews].frame.depth_m;
    benchmark::DoNotOptimize(frame.depth_m.data());
  }
}

}  // namespace

int main(int argc, char** argv) {
  bench::keep_memory();
  agree();
  const auto ms = benchmark::kMillisecond;
  // as many iterations as there are views, so that both sides meet the same ones
  benchmark::RegisterBenchmark("self_filter/per_point", per_point)->Iterations(2 * kViews)->Unit(ms);
  benchmark::RegisterBenchmark("self_filter/rows", self_filter)->Iterations(50 * kViews)->Unit(ms);
  benchmark::RegisterBenchmark("self_filter/copy_of_the_frame", copy_alone)
      ->Iterations(50 * kViews)
      ->Unit(ms);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
