#include "tools/run/report/run_pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/types/units.hpp"
#include "tools/run/run_text.hpp"
#include "tools/visualization/palette.hpp"
#include "tools/visualization/scene/side_view.hpp"

namespace colift::tools {
namespace {

using control::Task;
using hal::Vec3;
using picture::Colour;
using picture::PlotLine;
using picture::PlotPanel;
using picture::Solid;
using picture::SolidRole;
using picture::SolidScene;

constexpr Colour kLimit = picture::rgb(0xD55E00);
constexpr Colour kFloor = picture::rgb(0x8A949E);
constexpr double kHandClosed_rad = 1.0;  // of the inner joints, where nothing tells how far they closed

const planner::GraspCandidate* chosen(const RunView& view) {
  const auto& decision = view.record.decision;
  if (!decision || !decision->decision.chosen) return nullptr;
  return &decision->candidates[*decision->decision.chosen];
}

std::optional<Vec3> partner(const RunView& view) {
  const auto& decision = view.record.decision;
  if (!decision || !decision->partner) return std::nullopt;
  return decision->partner->position;
}

Solid capsule(const Vec3& from, const Vec3& to, double radius, SolidRole role) {
  return {sim_hal::capsule(from, to, radius, sim_hal::Label::Nothing), role};
}

// What was seen and planned, raised by `rise_m`.
SolidScene scene_as_seen(const RunView& view, const hal::JointVector& q_rad, double rise_m) {
  SolidScene scene;
  const control::RunRecord& r = view.record;
  if (r.analysis && r.analysis->scene.ground) {
    const hal::Plane& plane = r.analysis->scene.ground->plane;
    scene.solids.push_back(
        {sim_hal::half_space(-plane.offset * plane.normal, plane.normal, sim_hal::Label::Ground),
         SolidRole::Ground});
  }
  const Vec3 rise = rise_m * Vec3::UnitZ();
  Vec3 outwards = Vec3::UnitX();
  if (r.analysis && r.analysis->scene.target) {
    const hal::OrientedBox& box = r.analysis->scene.target->shape;
    Solid object;
    object.X_WS.linear() = box.axes;
    object.X_WS.translation() = box.center + rise;
    object.size = box.size;
    object.role = SolidRole::Target;
    scene.solids.push_back(object);
    if (const auto p = partner(view)) outwards = *p - box.center;
  }
  if (const auto p = partner(view)) {
    outwards.z() = 0;
    outwards = outwards.norm() > 1e-6 ? outwards.normalized() : Vec3::UnitX();
    scene.solids.push_back(capsule(*p + rise, *p + rise + 0.07 * outwards, 0.035, SolidRole::Partner));
    scene.solids.push_back(capsule(*p + rise + 0.07 * outwards,
                                   *p + rise + 0.35 * outwards + 0.12 * Vec3::UnitZ(), 0.04,
                                   SolidRole::Partner));
  }
  if (view.setting.model) {
    const double inner = r.plan ? kHandClosed_rad : 0.0;
    const auto robot = picture::robot_solids(*view.setting.model, q_rad, hal::coupled_posture(inner));
    scene.solids.insert(scene.solids.end(), robot.begin(), robot.end());
  }
  return scene;
}

std::vector<double> times(const std::vector<TruthSample>& curve) {
  std::vector<double> t;
  for (const TruthSample& s : curve) t.push_back(s.t_s);
  return t;
}

// Values of a curve: a member, or a function of a sample, times a factor.
template <class Sample, class Of>
std::vector<double> values(const std::vector<Sample>& curve, Of of) {
  std::vector<double> y;
  for (const Sample& s : curve) y.push_back(of(s));
  return y;
}

Colour band_colour(Task state) {
  switch (state) {
    case Task::TestLift:
      return picture::rgb(0xEAE4F5);
    case Task::Lift:
      return picture::rgb(0xE0F2EA);
    case Task::Hold:
      return picture::rgb(0xF8F1DC);
    case Task::Lower:
      return picture::rgb(0xE3EEF7);
    case Task::Stopped:
    case Task::Aborted:
      return picture::rgb(0xF8E3DC);
    default:
      return picture::rgb(0xF1F3F6);
  }
}

std::vector<picture::PlotBand> bands(const RunView& view, double from, double to) {
  std::vector<picture::PlotBand> all;
  const auto& states = view.record.states;
  for (std::size_t i = 0; i < states.size(); ++i) {
    const double begin = hal::seconds(states[i].at);
    const double end = i + 1 < states.size() ? hal::seconds(states[i + 1].at) : to;
    if (end <= from || begin >= to || !(end > begin)) continue;
    all.push_back({std::string(control::word(states[i].state)), std::max(begin, from), std::min(end, to),
                   band_colour(states[i].state)});
  }
  // neighbours of one colour are still told apart
  for (std::size_t i = 1; i < all.size(); i += 2) all[i].colour = all[i].colour.towards(picture::kInk, 0.035);
  return all;
}

}  // namespace

DrawnScenes drawn_scenes(const RunView& view) {
  DrawnScenes drawn;
  if (view.scenes) {
    drawn.before = view.scenes->before;
    drawn.lifted = view.scenes->lifted;
  }
  if (drawn.before || drawn.lifted || !view.record.analysis || !view.record.analysis->scene.target)
    return drawn;
  const auto& plan = view.record.plan;
  drawn.seen_only = true;
  drawn.before = scene_as_seen(view, plan ? plan->reach.grasp_rad : view.setting.home_rad, 0.0);
  if (plan && view.record.lift)
    drawn.lifted =
        scene_as_seen(view, plan->reach.lifted_rad,
                      std::isfinite(view.record.lift->height_m) ? view.record.lift->height_m : 0.0);
  return drawn;
}

Vec3 space_direction(const RunView& view) {
  const planner::GraspCandidate* grasp = chosen(view);
  const auto p = partner(view);
  Vec3 from = view.setting.X_WC.translation();
  if (grasp && p) {
    Vec3 across = *p - grasp->position;
    across.z() = 0;
    if (across.norm() > 0.05) {
      across.normalize();
      Vec3 side = across.cross(Vec3::UnitZ());
      if (side.dot(from - 0.5 * (*p + grasp->position)) < 0) side = -side;
      from = 2.6 * side - 0.9 * across;
    }
  }
  if (from.head<2>().norm() < 1e-3) from = {1.0, -2.0, 0.0};
  from.z() = 0.42 * from.head<2>().norm();
  return from;
}

picture::Canvas space_picture(const RunView& view, const SolidScene& scene, int width, int height) {
  SolidScene shown = scene;
  // a wall between the eye and the scene hides all of it
  std::erase_if(shown.solids, [](const Solid& s) { return s.role == SolidRole::Wall; });
  return picture::draw_solids(shown, picture::view_of(shown, space_direction(view), width, height));
}

std::optional<picture::Canvas> side_picture(const RunView& view, const DrawnScenes& scenes) {
  const planner::GraspCandidate* grasp = chosen(view);
  const auto p = partner(view);
  if (!scenes.before || !scenes.lifted || !grasp || !p) return std::nullopt;
  picture::SideView side;
  side.before = *scenes.before;
  side.lifted = *scenes.lifted;
  side.partner = *p;
  side.robot = grasp->position;
  side.seen_from = view.setting.X_WC.translation();
  if (view.record.lift) {
    side.height_m = view.record.lift->height_m;
    side.tilt_rad = view.record.lift->tilt_rad;
    side.share = view.record.lift->share_robot;
  }
  return picture::draw_side_view(side);
}

std::optional<picture::LinePlot> separation_plot(const RunView& view) {
  const control::MonitorRecord& monitor = view.record.monitor;
  const std::vector<control::SeparationSample>& seen = monitor.curve;
  const bool anybody = std::any_of(seen.begin(), seen.end(), [](const auto& s) {
    return std::isfinite(s.distance_m) || std::isfinite(s.partner_distance_m);
  });
  if (!anybody) return std::nullopt;
  const std::vector<double> t = values(seen, [](const auto& s) { return s.t_s; });
  const auto line = [&](const char* name, const Colour& colour, auto of) {
    return PlotLine{name, colour, t, values(seen, of)};
  };
  PlotPanel distance{.title = "Distance (m)", .lines = {}, .levels = {}, .y_low = 0};
  distance.lines.push_back(line("nearest person or thing", picture::kRobot,
                                [](const auto& s) { return s.distance_m < 0.0 ? 0.0 : s.distance_m; }));
  distance.lines.push_back(line("the partner", picture::kPartner, [](const auto& s) {
    return s.partner_distance_m < 0.0 ? 0.0 : s.partner_distance_m;
  }));
  // whatever the program saw
  if (view.truth && view.truth->verdict) {
    const auto& judged = view.truth->verdict->distances;
    const bool people =
        std::any_of(judged.begin(), judged.end(), [](const auto& s) { return std::isfinite(s.people_m); });
    if (people)
      distance.lines.push_back({"the scenario's people, as they were", picture::kOptimum,
                                values(judged, [](const auto& s) { return s.t_s; }),
                                values(judged, [](const auto& s) { return std::max(0.0, s.people_m); })});
  }
  const auto level = [&](const char* what, double m, const Colour& colour) {
    distance.levels.push_back({fmt::format("{} {}", what, metres_text(m)), m, colour});
  };
  level("a person stops the arm:", monitor.hold_distance_m, kLimit);
  level("slows it:", monitor.slow_distance_m, picture::kOptimum);
  PlotPanel speed{
      .title = "Part of the planned speed (%)", .lines = {}, .levels = {}, .y_low = 0, .y_high = 100};
  speed.lines.push_back(line("allowed", picture::kCog, [](const auto& s) { return 100 * s.scale; }));

  picture::LinePlot plot;
  plot.x_title = view.setting.simulated ? "simulated time since the start (s)" : "time since the start (s)";
  plot.panel_height = 190;
  plot.bands = bands(view, t.front(), t.back());
  plot.x_low = t.front();
  plot.x_high = t.back();
  plot.panels = {distance, speed};
  return plot;
}

std::optional<picture::LinePlot> curves_plot(const RunView& view) {
  const std::vector<control::LiftSample>& seen = view.record.curve;
  if (seen.size() < 2) return std::nullopt;
  static const std::vector<TruthSample> kNone;
  const std::vector<TruthSample>& truth = view.truth ? view.truth->curve : kNone;
  const std::vector<double> t = values(seen, [](const auto&s) { return s.t_s; }), tt = times(truth);
  const auto line = [&](const char* name, const Colour& colour, std::vector<double> y) {
    return PlotLine{name, colour, t, std::move(y)};
  };
  const auto true_line = [&](PlotPanel& panel, const char* name, const Colour& colour, auto of) {
    if (!truth.empty()) panel.lines.push_back({name, colour, tt, values(truth, of), true, 1.8});
  };
  const Colour dark = picture::kInk;

  PlotPanel load{.title = "Load (N)", .lines = {}, .levels = {}};
  load.lines.push_back(
      line("robot, measured", picture::kRobot, values(seen, [](const auto& s) { return s.load_n; })));
  true_line(load, "robot, true", dark, [](const auto& s) { return s.robot_force_z_n; });
  true_line(load, "partner, true", picture::kPartner, [](const auto& s) { return s.partner_force_z_n; });
  true_line(load, "floor, true", kFloor, [](const auto& s) { return s.floor_force_z_n; });

  PlotPanel share{
      .title = "Robot's share of the load (%)", .lines = {}, .levels = {}, .y_low = 0, .y_high = 100};
  const double weight = view.record.lift && std::isfinite(view.record.lift->mass_kg)
                            ? hal::kGravity_m_s2 * view.record.lift->mass_kg
                            : 0.0;
  const auto in_air = [](Task s) {
    return s == Task::TestLift || s == Task::Lift || s == Task::Hold || s == Task::Lower;
  };
  if (weight > 0)
    share.lines.push_back(
        line("measured, of the estimated weight", picture::kRobot, values(seen, [&](const auto& s) {
               return in_air(s.state) ? 100 * s.load_n / weight : std::nan("");
             })));
  true_line(share, "true", dark, [](const auto& s) { return 100 * true_share(s); });
  if (view.setting.share)
    share.levels.push_back({fmt::format("wanted {}", percent_text(*view.setting.share)),
                            100 * *view.setting.share, picture::kOptimum});
  if (view.record.decision && view.record.decision->decision.chosen) {
    const double predicted = view.record.decision->decision.share;
    if (!view.setting.share || std::abs(predicted - *view.setting.share) > 0.02)
      share.levels.push_back(
          {fmt::format("predicted {}", percent_text(predicted)), 100 * predicted, picture::kPartner});
  }

  PlotPanel tilt{.title = "Tilt (°)", .lines = {}, .levels = {}, .y_low = 0};
  tilt.lines.push_back(
      line("seen", picture::kRobot, values(seen, [](const auto& s) { return hal::rad_to_deg(s.tilt_rad); })));
  true_line(tilt, "true", dark, [](const auto& s) { return hal::rad_to_deg(s.tilt_rad); });
  tilt.levels.push_back({fmt::format("limit {}", degrees_text(view.setting.max_tilt_rad)),
                         hal::rad_to_deg(view.setting.max_tilt_rad), kLimit});

  PlotPanel height{.title = "Height (cm)", .lines = {}, .levels = {}};
  height.lines.push_back(line("object, observed", picture::kRobot,
                              values(seen, [](const auto& s) { return 100 * s.object_rise_m; })));
  height.lines.push_back(
      line("palm", picture::kCog, values(seen, [](const auto& s) { return 100 * s.palm_height_m; })));
  true_line(height, "object, true", dark, [](const auto& s) { return 100 * s.height_m; });
  height.levels.push_back({fmt::format("asked for {}", metres_text(view.setting.lift_height_m)),
                           100 * view.setting.lift_height_m, picture::kOptimum});

  PlotPanel slip{.title = "Slip in the hand (mm)", .lines = {}, .levels = {}, .y_low = 0};
  slip.lines.push_back(
      line("seen", picture::kRobot, values(seen, [](const auto& s) { return 1e3 * s.slip_m; })));
  true_line(slip, "true", dark, [](const auto& s) { return 1e3 * s.slip_m; });
  slip.levels.push_back(
      {fmt::format("limit {}", metres_text(view.setting.max_slip_m)), 1e3 * view.setting.max_slip_m, kLimit});

  picture::LinePlot plot;
  plot.x_title = view.setting.simulated ? "simulated time since the start (s)" : "time since the start (s)";
  plot.panel_height = 190;
  plot.bands = bands(view, t.front(), t.back());
  plot.x_low = t.front();
  plot.x_high = t.back();
  plot.panels = {load, share, tilt, height, slip};
  return plot;
}

}  // namespace colift::tools
