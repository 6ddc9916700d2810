#include "tools/run/run_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "hal/robot.hpp"
#include "hal/types/units.hpp"
#include "tools/analyse/grasp_json.hpp"

namespace colift::tools {
namespace {

using Json = nlohmann::ordered_json;

// What is not finite did not happen or was not seen.
Json number(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}

Json number(const std::optional<double>& value) {
  return value ? number(*value) : Json(nullptr);
}

Json states(const control::RunRecord& record) {
  Json all = Json::array();
  for (const control::StateChange& s : record.states)
    all.push_back({{"t", hal::seconds(s.at)}, {"state", control::word(s.state)}, {"because", s.reason}});
  return all;
}

Json partner(const RunView& view) {
  const auto& decision = view.record.decision;
  if (!decision || !decision->partner) return nullptr;
  return {{"position", json_array(decision->partner->position)},
          {"error_m", number(partner_error_m(view))},
          {"sigma", json_sigma(decision->partner->covariance)},
          {"because", decision->partner_reason}};
}

Json lift(const control::RunRecord& record) {
  if (!record.lift) return nullptr;
  const control::LiftSummary& l = *record.lift;
  const auto interval = [&](control::Interval control::LoadEstimate::*of) {
    return l.load ? Json::array({(*l.load.*of).low, (*l.load.*of).high}) : Json(nullptr);
  };
  return {{"height_m", number(l.height_m)},
          {"tilt_deg", number(hal::kDegPerRad * l.tilt_rad)},
          {"share_robot", number(l.share_robot)},
          {"share_predicted", number(l.share_predicted)},
          {"share_robot_interval", interval(&control::LoadEstimate::share_95)},
          {"load_steady", l.load_steady},
          {"slip_m", number(l.slip_m)},
          {"mass_kg", number(l.mass_kg)},
          {"mass_kg_interval", interval(&control::LoadEstimate::mass_95)},
          {"cog", l.load ? json_array(l.load->cog) : Json(nullptr)},
          {"cog_sigma_m", l.load ? number(l.load->cog_sigma_m) : Json(nullptr)},
          {"mass_source", l.load ? Json(control::word(l.load->source)) : Json(nullptr)},
          {"mass_because", l.load_reason},
          {"control", record.palm_springs ? "cartesian_impedance" : "joint_impedance"},
          {"energy_margin_j", number(record.energy_margin_j)}};
}

Json test_lifts(const control::RunRecord& record) {
  Json all = Json::array();
  for (const control::TestLiftRecord& t : record.test_lifts) {
    Json j = {{"t", hal::seconds(t.at)},
              {"candidate", t.candidate},
              {"height_m", number(t.height_m)},
              {"level", t.known && t.known->next != control::TestLift::Next::Regrasp},
              {"because", t.reason}};
    if (t.known) {
      j["tilt_deg"] = number(hal::kDegPerRad * t.known->seen.tilt_rad);
      j["mass_kg"] = number(t.known->mass_kg);
      j["cog"] = json_array(t.known->cog);
      j["lever_m"] = number(t.known->lever_m);
      j["share_robot"] = number(t.known->share);
    }
    all.push_back(std::move(j));
  }
  return all;
}

Json grip(const control::RunRecord& record) {
  if (!record.grip) return nullptr;
  const control::GripQuality& g = *record.grip;
  static constexpr std::array<const char*, hal::kTactileArrays> kNames{"F1", "F2", "F3", "palm"};
  Json contacts = Json::array();
  for (std::size_t i = 0; i < kNames.size(); ++i)
    contacts.push_back({{"name", kNames[i]},
                        {"cells", g.contacts[i].cells},
                        {"force_n", number(g.contacts[i].force_n)},
                        {"torque_nm", i < hal::kFingers ? number(g.torque_nm[i]) : Json(nullptr)}});
  return {{"contact_points", g.contact_points},
          {"palm_touches", g.palm_touches()},
          {"held_fraction", number(g.held_fraction)},
          {"friction_limit_n", number(g.friction_limit_n)},
          {"friction_margin", number(record.lift ? control::friction_margin(g, record.lift->load_n) : NAN)},
          {"contacts", std::move(contacts)}};
}

Json asked(const control::RunRecord& record) {
  Json all = Json::array();
  for (const control::AskRecord& a : record.asked)
    all.push_back({{"t", hal::seconds(a.at)}, {"place", json_array(a.place)}, {"because", a.reason}});
  return all;
}

Json intents(const control::RunRecord& record) {
  Json all = Json::array();
  for (const control::Intent& i : record.intents)
    all.push_back({{"t", hal::seconds(i.at)},
                   {"motion", i.motion ? Json(control::to_string(*i.motion)) : Json(nullptr)},
                   {"in_s", i.in_s},
                   {"says", i.says}});
  return all;
}

Json timing(const control::RunRecord& record) {
  const control::RunTiming& t = record.timing;
  return {{"grasp_to_decision_s", number(t.grasp_to_decision_s)},
          {"decision_compute_ms", record.decision ? number(t.decision_compute_ms) : Json(nullptr)},
          {"plan_ms", record.plan ? number(t.plan_ms) : Json(nullptr)},
          {"monitor_ms", record.monitor.frames > 0 ? number(record.monitor.compute_ms / record.monitor.frames)
                                                   : Json(nullptr)},
          {"sim_s", number(t.sim_s)},
          {"wall_s", number(t.wall_s)}};
}

Json truth(const RunView& view) {
  Json j = {{"mass_kg", number(view.truth->mass_kg)},
            {"cog", json_array(view.truth->cog)},
            {"partner", view.truth->partner ? json_array(*view.truth->partner) : Json(nullptr)},
            {"share_robot", nullptr},
            {"lift", nullptr}};
  if (const auto top = true_lift(view)) {
    j["share_robot"] = number(top->share_robot);
    j["lift"] = {{"height_m", number(top->height_m)},
                 {"tilt_deg", number(hal::kDegPerRad * top->tilt_rad)},
                 {"share_robot", number(top->share_robot)},
                 {"slip_m", number(top->slip_m)}};
  }
  return j;
}

Json spans(const std::vector<ArmLink::Span>& all) {
  Json j = Json::array();
  for (const ArmLink::Span& span : all) j.push_back({span.from_s, span.to_s});
  return j;
}

Json arm_link(const ArmLink& link) {
  Json j;
  j["cycles"] = link.cycles;
  j["answered"] = link.answered;
  j["lost"] = link.lost;
  j["answer_us"] = {{"p50", link.answer_us.p50},
                    {"p99", link.answer_us.p99},
                    {"p999", link.answer_us.p999},
                    {"worst", link.answer_us.worst}};
  j["slow_monotonic_s"] = spans(link.slow);
  if (!link.controller) return j;
  const ArmLink::Controller& c = *link.controller;
  j["controller"] = {{"sent", c.sent},
                     {"answered", c.answered},
                     {"missed", c.missed},
                     {"most_missed_in_a_row", c.most_missed_in_a_row},
                     {"late_cycles", c.late},
                     {"worst_late_ms", c.worst_late_ms},
                     {"missed_in_command", c.missed_in_command},
                     {"missed_monotonic_s", spans(c.missed_at)},
                     {"broken_rules", c.broken_rules},
                     {"left_command", c.left_command}};
  return j;
}

Json camera_correction(const control::RunRecord& record) {
  if (!record.camera_correction) return nullptr;
  const perception::CameraCorrection& c = *record.camera_correction;
  using Verdict = perception::CameraCorrection::Verdict;
  return {{"verdict", c.applied()                     ? "applied"
                      : c.verdict == Verdict::Refused ? "refused"
                                                      : "kept"},
          {"because", c.reason},
          {"position_m", json_array(c.X_KC.translation())},
          {"rotation_deg", number(hal::kDegPerRad * c.rotation_rad())},
          {"depth_scale", number(c.depth_scale)},
          {"focal_scale", number(c.focal_scale)},
          {"shift_m", number(c.shift_m)},
          {"sigma_m", number(c.sigma_m)},
          {"arm_before_m", number(c.residual_before_m)},
          {"arm_after_m", number(c.residual_m)},
          {"arm_points", c.arm_points},
          {"floor_points", c.floor_points}};
}

Json cameras(const control::RunRecord& record) {
  Json all = Json::array();
  for (std::size_t n = 0; n < record.views.size(); ++n) {
    const control::ViewReport& v = record.views[n];
    all.push_back({{"camera", hal::camera_name(n)},
                   {"used", v.used},
                   {"knows_object", v.knows_object},
                   {"agreement_m", number(v.agreement_m)},
                   {"unseen_without", number(v.unseen_without)},
                   {"because", v.reason}});
  }
  return all;
}

Json faults(const control::RunRecord& record) {
  Json all = Json::array();
  for (const control::DeviceNote& f : record.faults)
    all.push_back({{"t", hal::seconds(f.at)}, {"device", f.device}, {"what", f.what}});
  return all;
}

Json monitor(const control::RunRecord& record) {
  const control::MonitorRecord& m = record.monitor;
  return {{"on", m.on},
          {"stops", m.stops},
          {"waited_s", number(m.waited_s)},
          {"min_speed_scale", number(m.min_scale)},
          {"min_distance_m", number(m.min_distance_m)},
          {"max_bodies", m.max_bodies},
          {"frames", m.frames}};
}

// Null without a verdict: real devices, a replay.
Json judge_json(const std::optional<sim_hal::Verdict>& verdict) {
  if (!verdict) return nullptr;
  Json contacts = Json::array(), not_judged = Json::object();
  for (const sim_hal::JudgedContact& c : verdict->contacts)
    contacts.push_back({{"t", c.t_s},
                        {"body", c.region},
                        {"person", c.person},
                        {"by", c.by},
                        {"force_n", c.force_n},
                        {"limit_n", c.limit_n},
                        {"clamped_s", c.clamped_s},
                        {"kept_n", c.kept_n},
                        {"closing_m_s", c.closing_m_s},
                        {"robot_m_s", c.robot_m_s},
                        {"commanded_j", c.commanded_j},
                        {"his_own", c.his_own}});
  for (const auto& [name, why] : verdict->not_judged) not_judged[name] = why;
  Json distance = {{"t", Json::array()}, {"people_m", Json::array()}, {"partner_m", Json::array()}};
  for (const sim_hal::DistanceSample& s : verdict->distances) {
    distance["t"].push_back(number(s.t_s));
    distance["people_m"].push_back(number(s.people_m));
    distance["partner_m"].push_back(number(s.partner_m));
  }
  return {{"breaches", verdict->breaches},
          {"contacts", contacts},
          {"min_distance_m", number(verdict->min_distance_m)},
          {"partner_distance_m", number(verdict->partner_distance_m)},
          {"distance", distance},
          {"stop_latency_s", number(verdict->stop_latency_s)},
          {"judged", verdict->judged},
          {"not_judged", not_judged}};
}

// One array for each quantity, entries that belong together at the same place.
Json curve(const control::RunRecord& record) {
  Json j = {{"t", Json::array()},      {"state", Json::array()},    {"palm_height_m", Json::array()},
            {"rise_m", Json::array()}, {"tilt_deg", Json::array()}, {"slip_m", Json::array()},
            {"load_n", Json::array()}};
  for (const control::LiftSample& s : record.curve) {
    j["t"].push_back(number(s.t_s));
    j["state"].push_back(control::word(s.state));
    j["palm_height_m"].push_back(number(s.palm_height_m));
    j["rise_m"].push_back(number(s.object_rise_m));
    j["tilt_deg"].push_back(number(hal::kDegPerRad * s.tilt_rad));
    j["slip_m"].push_back(number(s.slip_m));
    j["load_n"].push_back(number(s.load_n));
  }
  return j;
}

// Of the decision, or, where it did not come to one, of the look.
Json candidates(const control::RunRecord& record) {
  if (record.decision) return candidates_json(*record.decision);
  Json all = Json::array();
  if (record.analysis)
    for (const planner::GraspCandidate& c : record.analysis->candidates) all.push_back(candidate_json(c));
  return all;
}

}  // namespace

std::string run_document(const RunView& view) {
  const control::RunRecord& record = view.record;
  Json j = {{"schema", "colift.run/1"},
            {"outcome", word(record.outcome)},
            {"because", record.reason},
            {"seed", view.setting.seed},
            {"scenario", view.setting.scenario.empty() ? Json(nullptr) : Json(view.setting.scenario)},
            {"robot", view.setting.robot},
            {"method", view.setting.method},
            {"share_wanted", number(view.setting.share)},
            {"dry_run", view.setting.dry_run},
            {"states", states(record)},
            {"partner", partner(view)},
            {"decision", record.decision ? decision_json(*record.decision) : Json(nullptr)},
            {"share", record.decision ? share_json(record.decision->share) : Json(nullptr)},
            {"certificate", record.decision ? certificate_json(record.decision->share) : Json(nullptr)},
            {"asked", asked(record)},
            {"intents", intents(record)},
            {"test_lifts", test_lifts(record)},
            {"grip", grip(record)},
            {"lift", lift(record)},
            {"timing", timing(record)}};
  if (view.truth) j["truth"] = truth(view);
  j["judge"] = view.truth ? judge_json(view.truth->verdict) : Json(nullptr);
  if (view.arm_link != nullptr) j["arm_link"] = arm_link(*view.arm_link);
  if (!view.recovery.empty()) j["recovery"] = Json::parse(view.recovery);
  j["camera_correction"] = camera_correction(record);
  j["cameras"] = cameras(record);
  j["unseen"] = number(record.unseen);
  j["monitor"] = monitor(record);
  j["faults"] = faults(record);
  j["hand_keeps_grip"] = record.hand_keeps_grip;
  j["candidates"] = candidates(record);
  j["curve"] = record.curve.empty() ? Json(nullptr) : curve(record);
  // reasons may quote names of files, which hold any bytes
  return j.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace colift::tools
