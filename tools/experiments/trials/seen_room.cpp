#include "tools/experiments/trials/seen_room.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "control/config/resolve_config.hpp"
#include "hal/types/units.hpp"
#include "planner/hand/hand_model.hpp"

namespace colift::experiments {
namespace {

using sim_hal::Label;

constexpr double kPure = 0.85, kCovered = 0.6;
constexpr double kGroundTilt_deg = 3.0, kGroundHeight_m = 0.1;

RoomVerdict judge(const SeenRoom& seen) {
  const auto& target = seen.analysis.scene.target;
  if (!target || target->points.empty()) return RoomVerdict::Nothing;
  const perception::OrganisedCloud& cloud = seen.analysis.cloud;
  std::size_t own = 0, person = 0;
  std::vector<bool> covered(seen.truth.label.size(), false);
  for (const Eigen::Vector3f& p : target->points) {
    const auto at = cloud.project(p.cast<double>());
    const int u = static_cast<int>(std::lround(at.u)), v = static_cast<int>(std::lround(at.v));
    if (u < 0 || v < 0 || u >= cloud.width() || v >= cloud.height()) continue;
    const auto i = static_cast<std::size_t>(v * cloud.width() + u);
    own += seen.truth.label[i] == Label::Target ? 1 : 0;
    person += seen.truth.label[i] == Label::Partner ? 1 : 0;
    covered[i] = true;
  }
  const auto all = static_cast<double>(target->points.size());
  if (2 * person > target->points.size()) return RoomVerdict::Person;
  if (static_cast<double>(own) < 0.5 * all) return RoomVerdict::Wrong;
  std::size_t there = 0, found = 0;
  for (std::size_t i = 0; i < covered.size(); ++i) {
    if (seen.truth.label[i] != Label::Target || !cloud.seen(i)) continue;
    ++there;
    found += covered[i] ? 1 : 0;
  }
  const bool whole = static_cast<double>(found) >= kCovered * static_cast<double>(there);
  return whole && static_cast<double>(own) >= kPure * all ? RoomVerdict::Right : RoomVerdict::Partly;
}

}  // namespace

std::string word(RoomVerdict verdict) {
  switch (verdict) {
    case RoomVerdict::Right:
      return "right";
    case RoomVerdict::Partly:
      return "partly";
    case RoomVerdict::Nothing:
      return "nothing";
    case RoomVerdict::Wrong:
      return "wrong";
    case RoomVerdict::Person:
      return "person";
  }
  return "?";
}

bool SeenRoom::solvable() const {
  return room.has_object && object.pixels >= 1500 && object.hidden_fraction < 0.3 && !object.cut;
}

std::string SeenRoom::object_class() const {
  if (!room.has_object) return "empty";
  return solvable() ? "solvable" : "hard";
}

SeenRoom see_room(sim_hal::RandomRoom room, std::uint64_t seed, control::Method method) {
  SeenRoom seen;
  seen.room = std::move(room);
  seen.truth = sim_hal::cast_rays(seen.room.world, seen.room.intrinsics, seen.room.X_WC);
  seen.object = sim_hal::object_in_view(seen.room, seen.truth);
  seen.person_pixels =
      static_cast<std::size_t>(std::count(seen.truth.label.begin(), seen.truth.label.end(), Label::Partner));
  control::SceneAnalysisInput input;  // in the camera's own frame, as `colift look` without a camera pose
  input.frame = sim_hal::measure_with(seen.room.sensor, seen.truth, seed);
  control::ConfigRequest request;
  request.command = control::Command::SceneAnalysis;
  request.options.push_back({"method", control::to_string(method), "--method"});
  const auto resolved = control::resolve_config(request);
  if (!resolved) throw std::logic_error(resolved.error().text());  // nobody else had a say
  auto analysis = control::analyse_scene(std::move(input), method, resolved->config, planner::HandModel{},
                                         hal::SteadyClock());
  if (!analysis) {
    seen.analysis.reason = analysis.error().text();
    return seen;
  }
  seen.analysis = std::move(*analysis);
  if (const auto& ground = seen.analysis.scene.ground) {
    const hal::Vec3 up = seen.room.X_WC.linear() * ground->plane.normal;
    const double tilt = std::acos(std::clamp(up.z(), -1.0, 1.0)) / hal::kRadPerDeg;
    const double height = ground->plane.offset - seen.room.X_WC.translation().z();
    seen.ground_right = tilt < kGroundTilt_deg && std::abs(height) < kGroundHeight_m;
  }
  seen.verdict = judge(seen);
  return seen;
}

}  // namespace colift::experiments
