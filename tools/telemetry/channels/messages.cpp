#include "tools/telemetry/channels/messages.hpp"

#include "hal/health_text.hpp"
#include "hal/robot.hpp"
#include "hal/types/units.hpp"
#include "planner/verdict_word.hpp"
#include "tools/telemetry/channels/json_parts.hpp"

namespace colift::telemetry {
namespace {

constexpr int kPostures = 25;

Json point(const std::optional<hal::Vec3>& p) {
  return p ? list_of(*p) : Json(nullptr);
}

Json transform(const Json& time, const std::string& child, const hal::Pose& X_WF) {
  return {{"timestamp", time},
          {"parent_frame_id", kWorldFrame},
          {"child_frame_id", child},
          {"translation", xyz(X_WF.translation())},
          {"rotation", quaternion_json(X_WF.linear())}};
}

}  // namespace

std::string base64(std::string_view bytes) {
  static constexpr char kLetters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    const std::size_t have = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t b = 0; b < 3; ++b)
      three = (three << 8) | (b < have ? static_cast<unsigned char>(bytes[i + b]) : 0u);
    for (std::size_t c = 0; c < 4; ++c)
      out.push_back(c <= have ? kLetters[(three >> (18 - 6 * c)) & 63] : '=');
  }
  return out;
}

std::string transforms_message(hal::Timestamp at, const hal::RobotModel& model, const hal::JointVector& q_rad,
                               const hal::HandPosture& hand, const hal::Pose& X_WC,
                               std::span<const hal::Pose> X_WC_more) {
  std::vector<hal::Pose> X_WL;
  hal::link_poses(model, q_rad, hand, X_WL);
  Json all = Json::array();
  const Json time = time_json(at);
  for (std::size_t i = 0; i < model.links.size(); ++i)
    if (model.links[i].name != kWorldFrame) all.push_back(transform(time, model.links[i].name, X_WL[i]));
  all.push_back(transform(time, kCameraFrame, X_WC));
  for (std::size_t n = 0; n < X_WC_more.size(); ++n)
    all.push_back(transform(time, hal::camera_name(n + 1), X_WC_more[n]));
  return dumped({{"transforms", std::move(all)}});
}

std::string tracked_message(const control::TrackedPoses& tracked) {
  Json all = Json::array();
  const Json time = time_json(tracked.at);
  // whoever draws frames has no word for "unknown" but silence
  if (tracked.X_WO && tracked.X_WO->matrix().allFinite())
    all.push_back(transform(time, kObjectFrame, *tracked.X_WO));
  if (tracked.partner_W && tracked.partner_W->allFinite()) {
    hal::Pose at = hal::Pose::Identity();
    at.translation() = *tracked.partner_W;
    all.push_back(transform(time, kPartnerFrame, at));
  }
  return dumped({{"transforms", std::move(all)}});
}

std::string joints_message(hal::Timestamp at, const hal::RobotModel& model, const hal::ArmState& arm,
                           const hal::HandState& hand) {
  Json all = Json::array();
  const auto add = [&](int link, double position, double effort) {
    Json j = {{"name", model.links[static_cast<std::size_t>(link)].joint}, {"position", position}};
    if (std::isfinite(effort)) j["effort"] = effort;
    if (std::isfinite(position)) all.push_back(std::move(j));
  };
  for (int i = 0; i < hal::kArmJoints; ++i)
    add(model.arm[static_cast<std::size_t>(i)], arm.q_rad[i], arm.tau_nm[i]);
  for (std::size_t f = 0; f < hal::kFingers; ++f) {
    add(model.inner[f], hand.finger_rad[f], hand.torque_nm[f]);
    add(model.outer[f], hand.outer_rad[f], NAN);
  }
  for (const int link : model.spread) add(link, hand.spread_rad, NAN);
  return dumped({{"timestamp", time_json(at)}, {"joints", std::move(all)}});
}

std::string tactile_message(const hal::HandState& hand) {
  static constexpr std::array<const char*, hal::kTactileArrays> kNames{"F1", "F2", "F3", "palm"};
  constexpr double kTouch_n = 0.3;
  Json arrays = Json::array();
  for (std::size_t i = 0; i < kNames.size(); ++i)
    arrays.push_back(
        {{"name", kNames[i]},
         {"at", hand.tactile[i].measured_at.count()},
         {"force_n", number_json(i == hal::kPalmArray ? hand.palm_force_n : hand.tip_force_n[i])},
         {"cells", numbers_json(hand.tactile[i].pressure_n_cm2)}});
  return dumped({{"arrays", std::move(arrays)}, {"palm_touches", hand.palm_force_n > kTouch_n}});
}

std::string log_message(hal::Timestamp at, Level level, const std::string& name, const std::string& text) {
  return dumped({{"timestamp", time_json(at)},
                 {"level", static_cast<int>(level)},
                 {"message", text},
                 {"name", name},
                 {"file", ""},
                 {"line", 0}});
}

Json separation(const control::SeparationStatus& s) {
  Json bodies = Json::array();
  for (const auto& b : s.bodies)
    bodies.push_back({{"id", b.id},
                      {"partner", b.partner},
                      {"center", point(b.center_W)},
                      {"min", point(hal::Vec3(b.box.min()))},
                      {"max", point(hal::Vec3(b.box.max()))},
                      {"velocity", point(b.velocity_m_s)},
                      {"distance_m", number_json(b.distance_m)}});
  Json j = {{"on", s.on},
            {"speed_scale", s.scale},
            {"waits", s.waits},
            {"because", s.reason},
            {"distance_m", number_json(s.distance_m)},
            {"hold_distance_m", s.hold_distance_m},
            {"slow_distance_m", s.slow_distance_m},
            {"bodies", std::move(bodies)}};
  if (s.may_confirm) j["may_confirm"] = true;
  return j;
}

Json force(const control::ForceStatus& f) {
  Json j = {{"on", f.on}, {"felt", list_of(f.felt_W)}, {"exceeded", f.exceeded}};
  j["sideways_limit_n"] = f.limits ? Json(f.limits->sideways_n) : Json(nullptr);
  j["up_limit_n"] = f.limits ? Json(f.limits->up_n) : Json(nullptr);
  j["down_limit_n"] = f.limits ? Json(f.limits->down_n) : Json(nullptr);
  return j;
}

std::string status_message(const control::JobStatus& s) {
  return dumped({{"t", hal::seconds(s.now)},
                 {"state", control::word(s.state)},
                 {"in_state_s", hal::seconds(s.now - s.since)},
                 {"because", s.reason},
                 {"waits_for", control::waits_for(s.state)},
                 {"doing", s.doing},
                 {"done", number_json(s.done)},
                 {"partner", point(s.partner_W)},
                 {"partner_note", s.partner_note},
                 {"separation", separation(s.separation)},
                 {"force", force(s.force)}});
}

std::string intent_message(const control::Intent& intent) {
  return dumped({{"t", hal::seconds(intent.at)},
                 {"motion", intent.motion ? Json(control::to_string(*intent.motion)) : Json(nullptr)},
                 {"in_s", intent.in_s},
                 {"says", intent.says}});
}

std::string change_message(const control::StateChange& c) {
  return dumped({{"t", hal::seconds(c.at)}, {"state", control::word(c.state)}, {"because", c.reason}});
}

std::string devices_message(const std::vector<NamedHealth>& devices) {
  Json all = Json::array();
  for (const NamedHealth& d : devices)
    all.push_back({{"name", d.name},
                   {"state", hal::to_string(d.health.state)},
                   {"accepted", d.health.accepted},
                   {"rejected", d.health.rejected},
                   {"last_error", d.health.last_error}});
  return dumped({{"devices", std::move(all)}});
}

std::string timing_message(const CycleSummary& s) {
  return dumped({{"cycles", s.cycles},
                 {"missed", s.missed},
                 {"period_ms_max", number_json(s.period_ms_max)},
                 {"answer_us_mean", number_json(s.answer_us_mean)},
                 {"answer_us_max", number_json(s.answer_us_max)},
                 {"lost_samples", s.lost_samples}});
}

std::string stages_message(const control::StageTimes& analysis, double decision_ms,
                           const control::RunTiming& timing) {
  return dumped({{"look_ms",
                  {{"ground", analysis.ground},
                   {"target", analysis.target},
                   {"surfaces", analysis.surfaces},
                   {"candidates", analysis.candidates},
                   {"total", analysis.total}}},
                 {"decision_ms", decision_ms},
                 {"decision_compute_ms", timing.decision_compute_ms},
                 {"plan_ms", timing.plan_ms},
                 {"grasp_to_decision_s", number_json(timing.grasp_to_decision_s)}});
}

Json leader(const std::optional<control::LiftController::Role>& role) {
  if (!role) return nullptr;
  return *role == control::LiftController::Role::Lead ? "robot" : "partner";
}

std::string load_message(const LoadNow& l) {
  std::optional<double> tilt_deg;
  if (l.tilt_rad) tilt_deg = hal::kDegPerRad * *l.tilt_rad;
  return dumped({{"force", l.wrench_W ? list_of(l.wrench_W->force) : Json(nullptr)},
                 {"torque", l.wrench_W ? list_of(l.wrench_W->torque) : Json(nullptr)},
                 {"load_n", number_json(l.load_n)},
                 {"share", number_json(l.share)},
                 {"share_predicted", number_json(l.share_predicted)},
                 {"height_m", number_json(l.height_m)},
                 {"tilt_deg", number_json(tilt_deg)},
                 {"slip_m", number_json(l.slip_m)},
                 {"energy_j", number_json(l.energy_j)},
                 {"leads", leader(l.role)}});
}

std::string decision_message(const DecisionView& view) {
  const control::Outcome& o = view.outcome;
  const planner::Decision& d = o.decision;
  Json all = Json::array();
  for (std::size_t i = 0; i < o.candidates.size(); ++i) {
    const planner::GraspCandidate& c = o.candidates[i];
    Json j = {{"id", c.id},
              {"kind", planner::name_of(c.kind)},
              {"position", list_of(c.position)},
              {"approach", list_of(c.approach)},
              {"closing", list_of(c.closing)},
              {"width", number_json(c.width)},
              {"verdict", planner::verdict_word(c.verdict)},
              {"because", c.reason},
              {"stability", number_json(c.stability)},
              {"share", nullptr},
              {"cost", nullptr}};
    if (i < d.scores.size() && d.scores[i]) {
      j["share"] = number_json(d.scores[i]->share);
      j["cost"] = number_json(d.scores[i]->cost);
    }
    all.push_back(std::move(j));
  }
  std::optional<hal::Vec3> partner, sigma;
  if (o.partner) {
    partner = o.partner->position;
    sigma = o.partner->covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  }
  return dumped({{"t", view.t_s},
                 {"chosen", d.chosen ? Json(o.candidates[*d.chosen].id) : Json(nullptr)},
                 {"share", d.chosen ? number_json(d.share) : Json(nullptr)},
                 {"cost", d.chosen ? number_json(d.cost) : Json(nullptr)},
                 {"because", d.reason},
                 {"share_text", o.share.text},
                 {"optimum", list_of(d.optimum)},
                 {"partner", point(partner)},
                 {"partner_sigma", point(sigma)},
                 {"partner_points", o.partner ? o.partner->points : 0},
                 {"partner_because", o.partner_reason},
                 {"cog", point(view.cog)},
                 {"candidates", std::move(all)}});
}

PlanView plan_view(double t_s, const planner::MotionPlan& plan, const hal::RobotModel& model) {
  PlanView view;
  view.t_s = t_s;
  view.transit_s = plan.transit.duration_s();
  view.approach_s = plan.approach.duration_s();
  const double whole = view.transit_s + view.approach_s;
  for (int i = 0; i < kPostures; ++i) {
    const double t = whole * i / (kPostures - 1);
    const auto sample =
        t <= view.transit_s ? plan.transit.sample(t) : plan.approach.sample(t - view.transit_s);
    view.postures.push_back(sample.q_rad);
    view.palm_W.push_back(hal::hand_pose(model, sample.q_rad).translation());
  }
  return view;
}

std::string plan_message(const PlanView& plan) {
  Json postures = Json::array(), palm = Json::array();
  for (const hal::JointVector& q : plan.postures) postures.push_back(numbers_json(q));
  for (const hal::Vec3& p : plan.palm_W) palm.push_back(list_of(p));
  return dumped({{"t", plan.t_s},
                 {"transit_s", plan.transit_s},
                 {"approach_s", plan.approach_s},
                 {"postures", std::move(postures)},
                 {"palm", std::move(palm)}});
}

}  // namespace colift::telemetry
