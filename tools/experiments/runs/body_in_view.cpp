#include "tools/experiments/runs/body_in_view.hpp"

#include <algorithm>
#include <cmath>

#include "sim_hal/synthetic/person.hpp"

namespace colift::experiments {
namespace {

constexpr int kCoarse = 4;  // of the camera's pixels in a row and column: one is cast
constexpr double kOnePush_s = 0.5;
// as the judge has it: slow, or, where commands have ended, swaying with what it holds
constexpr double kAtRest_rad_s = 0.02, kSways_rad_s = 0.05, kEnded_s = 0.1, kStill_rad = 1e-5;

hal::CameraIntrinsics coarse() {
  hal::CameraIntrinsics k;
  k.width /= kCoarse;
  k.height /= kCoarse;
  for (double* of : {&k.fx, &k.fy, &k.cx, &k.cy}) *of /= kCoarse;
  return k;
}

int parts_of_a_person() {
  sim_hal::World one;
  sim_hal::Posture posture;
  posture.toes = true;
  sim_hal::add_person(one, posture);
  return static_cast<int>(one.shapes.size());
}

}  // namespace

BodyInView::BodyInView(const sim_hal::SimWorld& world)
    : camera_(coarse(), sim_hal::look_at(world.scenario().camera.xyz, world.scenario().camera.look_at)) {}

void BodyInView::frame(const sim_hal::SimWorld& world) {
  if (touched_s_ || !std::isfinite(world.people_distance_m())) return;
  // people of the scenario come before the partner who carries, one after the other
  static const int parts = parts_of_a_person();
  const sim_hal::World shapes = world.shapes();
  const auto first = std::find_if(shapes.shapes.begin(), shapes.shapes.end(),
                                  [](const sim_hal::Shape& s) { return s.label == sim_hal::Label::Partner; });
  const auto begin = static_cast<int>(first - shapes.shapes.begin());
  const auto& hit = camera_.cast(shapes).shape;
  const auto pixels = std::count_if(
      hit.begin(), hit.end(), [&](std::int16_t shape) { return shape >= begin && shape < begin + parts; });
  counts_.push_back({hal::seconds(world.elapsed()), static_cast<int>(pixels)});
}

void BodyInView::tick(const sim_hal::TickReport& report) {
  if (touched_s_) return;
  using By = sim_hal::BodyContact::By;
  const auto touches = [&](By what) {
    return std::any_of(report.contacts.begin(), report.contacts.end(),
                       [&](const sim_hal::BodyContact& c) { return c.person >= 0 && c.by == what; });
  };
  const bool robot = touches(By::Robot), held = report.truth.robot_touches_object && touches(By::Object);
  const bool ended = report.t_s - driven_s_ > kEnded_s;
  if (robot || held) {
    if (!(report.t_s - pushed_s_ < kOnePush_s)) {
      before_rad_s_ = last_rad_s_;
      rested_ = last_rad_s_ < (ended ? kSways_rad_s : kAtRest_rad_s);
    }
    pushed_s_ = report.t_s;
  }
  if (robot) {
    touched_s_ = report.t_s;
    joint_rad_s_ = before_rad_s_;
  }
  last_rad_s_ = report.dq_rad_s.cwiseAbs().maxCoeff();
  const bool driven = (report.set_point_rad - set_point_rad_).cwiseAbs().maxCoeff() > kStill_rad;
  if (driven) driven_s_ = report.t_s;
  set_point_rad_ = report.set_point_rad;
}

int BodyInView::pixels_at(double t_s) const {
  const auto after =
      std::find_if(counts_.begin(), counts_.end(), [&](const Count& c) { return c.t_s > t_s; });
  return after == counts_.begin() ? 0 : std::prev(after)->pixels;
}

}  // namespace colift::experiments
