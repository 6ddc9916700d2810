#include "tools/experiments/runs/body_in_view.hpp"

#include <algorithm>
#include <cmath>

#include "sim_hal/synthetic/person.hpp"

namespace colift::experiments {
namespace {

constexpr int kCoarse = 4;  // of the camera's pixels in a row and column: one is cast

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
  const bool touched = std::any_of(
      report.contacts.begin(), report.contacts.end(),
      [](const sim_hal::BodyContact& c) { return c.person >= 0 && c.by == sim_hal::BodyContact::By::Robot; });
  if (touched) {
    touched_s_ = report.t_s;
    joint_rad_s_ = last_rad_s_;
  }
  last_rad_s_ = report.dq_rad_s.cwiseAbs().maxCoeff();
}

int BodyInView::pixels_at(double t_s) const {
  const auto after =
      std::find_if(counts_.begin(), counts_.end(), [&](const Count& c) { return c.t_s > t_s; });
  return after == counts_.begin() ? 0 : std::prev(after)->pixels;
}

}  // namespace colift::experiments
