#include "tools/colift/look_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/colift/words.hpp"

namespace colift::tools {
namespace {

using Json = nlohmann::ordered_json;
using hal::Vec3;

Json array(const Vec3& v) {
  return Json::array({v.x(), v.y(), v.z()});
}

Json box(const hal::OrientedBox& b) {
  return {{"center", array(b.center)},
          {"axes", Json::array({array(b.axes.col(0)), array(b.axes.col(1)), array(b.axes.col(2))})},
          {"size", array(b.size)}};
}

Json sigma(const Eigen::Matrix3d& covariance) {
  return array(covariance.diagonal().cwiseMax(0.0).cwiseSqrt());
}

Json ground(const perception::Scene& scene) {
  if (!scene.ground) return nullptr;
  const auto& g = *scene.ground;
  return {{"normal", array(g.plane.normal)},
          {"offset", g.plane.offset},
          {"inliers", g.inliers},
          {"rms", g.rms_m}};
}

Json target(const perception::Scene& scene) {
  if (!scene.target) return nullptr;
  const auto& t = *scene.target;
  return {{"points", t.points.size()},
          {"aabb", {{"min", array(t.aabb.min())}, {"max", array(t.aabb.max())}}},
          {"obb", box(t.obb)},
          {"cog", array(t.cog)},
          {"cog_sigma", sigma(t.cog_covariance)},
          {"shape", box(t.shape)},
          {"because", t.because}};
}

Json surface(const perception::Surface& s) {
  if (const auto* r = std::get_if<perception::Rectangle>(&s)) {
    return {{"kind", "rectangle"},
            {"center", array(r->center)},
            {"normal", array(r->normal)},
            {"u", array(r->u)},
            {"v", array(r->v)},
            {"size", Json::array({r->size.x(), r->size.y()})},
            {"fill", r->fill}};
  }
  const auto& c = std::get<perception::Cylinder>(s);
  return {{"kind", "cylinder"},
          {"center", array(c.center)},
          {"axis", array(c.axis)},
          {"radius", c.radius},
          {"length", c.length}};
}

Json candidate(const planner::GraspCandidate& c) {
  Json j = {{"id", c.id},
            {"kind", planner::name_of(c.kind)},
            {"position", array(c.position)},
            {"approach", array(c.approach)},
            {"closing", array(c.closing)},
            {"width", c.width},
            {"surface", c.surface},
            {"verdict", word(c.verdict)}};
  if (c.stability && std::isfinite(*c.stability)) j["stability"] = *c.stability;
  if (!c.because.empty()) j["because"] = c.because;
  return j;
}

Json wrench(const hal::Wrench& w) {
  return {{"force", array(w.force)}, {"torque", array(w.torque)}};
}

Json look(const Seen& seen, const char* schema, const std::vector<planner::GraspCandidate>& candidates) {
  const control::Look& l = seen.look;
  Json j = {{"schema", schema},
            {"method", l.method == control::Method::Fast ? "fast" : "thesis"},
            {"points", seen.file.points},
            {"valid_points", seen.file.valid_points},
            {"organised", seen.file.organised},
            {"ground", ground(l.scene)},
            {"target", target(l.scene)}};
  j["surfaces"] = Json::array();
  for (const auto& s : l.scene.surfaces) j["surfaces"].push_back(surface(s));
  j["candidates"] = Json::array();
  for (const auto& c : candidates) j["candidates"].push_back(candidate(c));
  j["others"] = Json::array();
  for (const auto& r : l.rejected) {
    j["others"].push_back(
        {{"kind", word(r.kind)}, {"center", array(r.center)}, {"pixels", r.pixels}, {"because", r.because}});
  }
  j["because"] = l.because;
  j["timing_ms"] = {{"ground", l.ms.ground},
                    {"target", l.ms.target},
                    {"surfaces", l.ms.surfaces},
                    {"candidates", l.ms.candidates},
                    {"total", l.ms.total}};
  return j;
}

}  // namespace

std::string look_document(const Seen& seen) {
  return look(seen, "colift.look/1", seen.look.candidates).dump();
}

std::string decide_document(const Seen& seen, const control::Outcome& o) {
  Json j = look(seen, "colift.decide/1", o.candidates);
  for (std::size_t i = 0; i < o.decision.scores.size(); ++i) {
    if (!o.decision.scores[i]) continue;
    j["candidates"][i]["share"] = o.decision.scores[i]->share;
    j["candidates"][i]["cost"] = o.decision.scores[i]->cost;
  }
  if (o.partner) {
    j["partner"] = {{"position", array(o.partner->position)},
                    {"sigma", sigma(o.partner->covariance)},
                    {"points", o.partner->points},
                    {"because", o.partner_because}};
  } else {
    j["partner"] = nullptr;
  }
  const auto& d = o.decision;
  if (d.chosen) {
    const auto& s = *d.scores[*d.chosen];
    j["decision"] = {{"candidate", o.candidates[*d.chosen].id},
                     {"share", d.share},
                     {"cost", d.cost},
                     {"because", d.because},
                     {"optimum", array(d.optimum)},
                     {"partner", wrench(s.wrenches.partner)},
                     {"robot", wrench(s.wrenches.robot)}};
  } else {
    j["decision"] = nullptr;
    j["because"] = d.because;
  }
  j["timing_ms"]["partner"] = o.partner_ms;
  j["timing_ms"]["decision"] = o.decision_ms;
  j["timing_ms"]["total"] = seen.look.ms.total + o.partner_ms + o.decision_ms;
  return j.dump();
}

}  // namespace colift::tools
