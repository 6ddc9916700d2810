#include "tools/analyse/look_json.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "tools/analyse/grasp_json.hpp"
#include "tools/analyse/words.hpp"

namespace colift::tools {
namespace {

using Json = nlohmann::ordered_json;

Json box(const hal::OrientedBox& b) {
  return {{"center", json_array(b.center)},
          {"axes",
           Json::array({json_array(b.axes.col(0)), json_array(b.axes.col(1)), json_array(b.axes.col(2))})},
          {"size", json_array(b.size)}};
}

Json ground(const perception::Scene& scene) {
  if (!scene.ground) return nullptr;
  const auto& g = *scene.ground;
  return {{"normal", json_array(g.plane.normal)},
          {"offset", g.plane.offset},
          {"inliers", g.inliers},
          {"rms", g.rms_m}};
}

Json target(const perception::Scene& scene) {
  if (!scene.target) return nullptr;
  const auto& t = *scene.target;
  return {{"points", t.points.size()},
          {"aabb", {{"min", json_array(t.aabb.min())}, {"max", json_array(t.aabb.max())}}},
          {"obb", box(t.obb)},
          {"cog", json_array(t.cog)},
          {"cog_sigma", json_sigma(t.cog_covariance)},
          {"confidence", t.confidence},
          {"doubts", t.doubts},
          {"shape", box(t.shape)},
          {"because", t.reason}};
}

Json surface(const perception::Surface& s) {
  if (const auto* r = std::get_if<perception::Rectangle>(&s)) {
    return {{"kind", "rectangle"},
            {"center", json_array(r->center)},
            {"normal", json_array(r->normal)},
            {"u", json_array(r->u)},
            {"v", json_array(r->v)},
            {"size", Json::array({r->size.x(), r->size.y()})},
            {"fill", r->fill}};
  }
  const auto& c = std::get<perception::Cylinder>(s);
  return {{"kind", "cylinder"},
          {"center", json_array(c.center)},
          {"axis", json_array(c.axis)},
          {"radius", c.radius},
          {"length", c.length}};
}

Json document(const Seen& seen, const char* schema, Json candidates) {
  const control::SceneAnalysis& l = seen.analysis;
  Json j = {{"schema", schema},
            {"method", control::to_string(l.method)},
            {"points", seen.file.points},
            {"valid_points", seen.file.valid_points},
            {"organised", seen.file.organised},
            {"ground", ground(l.scene)},
            {"target", target(l.scene)}};
  j["surfaces"] = Json::array();
  for (const auto& s : l.scene.surfaces) j["surfaces"].push_back(surface(s));
  j["candidates"] = std::move(candidates);
  j["others"] = Json::array();
  for (const auto& r : l.rejected) {
    j["others"].push_back({{"kind", word(r.kind)},
                           {"center", json_array(r.center)},
                           {"pixels", r.pixels},
                           {"because", r.reason}});
  }
  j["because"] = l.reason;
  j["timing_ms"] = {{"ground", l.ms.ground},
                    {"target", l.ms.target},
                    {"surfaces", l.ms.surfaces},
                    {"candidates", l.ms.candidates},
                    {"total", l.ms.total}};
  return j;
}

}  // namespace

std::string look_document(const Seen& seen) {
  Json candidates = Json::array();
  for (const auto& c : seen.analysis.candidates) candidates.push_back(candidate_json(c));
  return document(seen, "colift.look/1", std::move(candidates)).dump();
}

std::string decide_document(const Seen& seen, const control::Outcome& o,
                            const std::optional<control::Suggestion>& suggestion) {
  Json j = document(seen, "colift.decide/1", candidates_json(o));
  if (o.partner) {
    j["partner"] = {{"position", json_array(o.partner->position)},
                    {"sigma", json_sigma(o.partner->covariance)},
                    {"points", o.partner->points},
                    {"because", o.partner_reason}};
  } else {
    j["partner"] = nullptr;
  }
  j["decision"] = decision_json(o);
  j["share"] = share_json(o.share);
  j["certificate"] = certificate_json(o.share);
  if (!o.decision.chosen) j["because"] = o.decision.reason;
  j["suggestion"] = nullptr;
  if (suggestion)
    j["suggestion"] = {{"partner", json_array(suggestion->position)},
                       {"gain", suggestion->gain ? Json(*suggestion->gain) : Json(nullptr)},
                       {"because", suggestion->reason}};
  j["timing_ms"]["partner"] = o.partner_ms;
  j["timing_ms"]["decision"] = o.decision_ms;
  j["timing_ms"]["total"] = seen.analysis.ms.total + o.partner_ms + o.decision_ms;
  return j.dump();
}

}  // namespace colift::tools
