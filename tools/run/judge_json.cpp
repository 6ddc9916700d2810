#include "tools/run/judge_json.hpp"

#include <nlohmann/json.hpp>

namespace colift::tools {
namespace {

using Json = nlohmann::ordered_json;

Json number(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

}  // namespace

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
                        {"closing_m_s", c.closing_m_s},
                        {"robot_m_s", c.robot_m_s},
                        {"commanded_j", c.commanded_j},
                        {"his_own", c.his_own}});
  for (const auto& [name, why] : verdict->not_judged) not_judged[name] = why;
  return {{"breaches", verdict->breaches},
          {"contacts", contacts},
          {"min_distance_m", number(verdict->min_distance_m)},
          {"partner_distance_m", number(verdict->partner_distance_m)},
          {"stop_latency_s", number(verdict->stop_latency_s)},
          {"judged", verdict->judged},
          {"not_judged", not_judged}};
}

}  // namespace colift::tools
