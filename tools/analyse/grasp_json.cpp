#include "tools/analyse/grasp_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/analyse/words.hpp"

namespace colift::tools {
namespace {

using Json = nlohmann::ordered_json;

Json wrench(const hal::Wrench& w) {
  return {{"force", json_array(w.force)}, {"torque", json_array(w.torque)}};
}

}  // namespace

Json json_array(const hal::Vec3& v) {
  return Json::array({v.x(), v.y(), v.z()});
}

Json json_sigma(const Eigen::Matrix3d& covariance) {
  return json_array(covariance.diagonal().cwiseMax(0.0).cwiseSqrt());
}

Json candidate_json(const planner::GraspCandidate& c) {
  Json j = {{"id", c.id},
            {"kind", planner::name_of(c.kind)},
            {"position", json_array(c.position)},
            {"approach", json_array(c.approach)},
            {"closing", json_array(c.closing)},
            {"width", c.width},
            {"surface", c.surface},
            {"verdict", word(c.verdict)}};
  if (c.stability && std::isfinite(*c.stability)) j["stability"] = *c.stability;
  if (!c.reason.empty()) j["because"] = c.reason;
  return j;
}

Json candidates_json(const control::Outcome& o) {
  Json all = Json::array();
  for (std::size_t i = 0; i < o.candidates.size(); ++i) {
    Json j = candidate_json(o.candidates[i]);
    if (i < o.decision.scores.size() && o.decision.scores[i]) {
      j["share"] = o.decision.scores[i]->share;
      j["cost"] = o.decision.scores[i]->cost;
    }
    all.push_back(std::move(j));
  }
  return all;
}

Json share_json(const control::ShareContract& s) {
  const auto number = [](const std::optional<double>& v) {
    return v && std::isfinite(*v) ? Json(*v) : Json(nullptr);
  };
  const auto range = [](const std::optional<planner::ShareRange>& r) {
    return r ? Json{r->low, r->high} : Json(nullptr);
  };
  Json j = {{"wanted", number(s.wanted)},
            {"reachable", range(s.reachable)},
            {"predicted", number(s.predicted)},
            {"interval", range(s.interval)},
            {"as_wished", s.as_wished ? Json(*s.as_wished) : Json(nullptr)},
            {"tolerance", s.interval ? Json(s.tolerance) : Json(nullptr)},
            {"elsewhere", nullptr},
            {"mass_kg", number(s.mass_kg)},
            {"partner_load_n", number(s.partner_load_n)},
            {"partner_limit_n", number(s.partner_limit_n)},
            {"because", s.text.empty() ? Json(nullptr) : Json(s.text)}};
  if (s.elsewhere)
    j["elsewhere"] = {{"partner", json_array(s.elsewhere->partner)},
                      {"robot", json_array(s.elsewhere->robot)},
                      {"share", s.elsewhere->share}};
  return j;
}

Json certificate_json(const control::ShareContract& share) {
  if (!share.certificate) return nullptr;
  const control::Certificate& c = *share.certificate;
  const auto range = [](const std::optional<control::Certificate::LoadRange>& r) {
    return r ? Json{r->low, r->high} : Json(nullptr);
  };
  return {{"confidence", 0.95},
          {"share", {c.share.low, c.share.high}},
          {"tilt_deg", c.tilt_deg},
          {"slip_m", c.slip_m},
          {"load_n", range(c.load_n)},
          {"partner_load_n", range(c.partner_load_n)},
          {"within_limits", c.breaches.empty()},
          {"because", c.breaches.empty() ? c.text : c.breach_text}};
}

Json decision_json(const control::Outcome& o) {
  const auto& d = o.decision;
  if (!d.chosen) return nullptr;
  const planner::GraspCandidate& c = o.candidates[*d.chosen];
  Json j = {{"candidate", c.id},   {"position", json_array(c.position)}, {"share", d.share}, {"cost", d.cost},
            {"because", d.reason}, {"optimum", json_array(d.optimum)}};
  if (*d.chosen < d.scores.size() && d.scores[*d.chosen]) {
    const auto& w = d.scores[*d.chosen]->wrenches;
    j["partner"] = wrench(w.partner);
    j["robot"] = wrench(w.robot);
  }
  return j;
}

}  // namespace colift::tools
