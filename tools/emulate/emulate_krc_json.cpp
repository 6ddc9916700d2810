#include "tools/emulate/emulate_krc_json.hpp"

#include <nlohmann/json.hpp>

namespace colift::tools {

std::string emulate_krc_json(const EmulateKrcOptions& o, const sim_hal::KrcReport& r,
                             const sim_hal::KrcServerTiming& timing, const std::string& reason) {
  using Json = nlohmann::ordered_json;
  using sim_hal::name;
  Json rejected = Json::object();
  for (const auto& [why, count] : r.rejected) rejected[why] = count;
  Json changes = Json::array(), rules = Json::array(), faults = Json::array();
  for (const auto& c : r.mode_changes)
    changes.push_back({{"t", c.t}, {"from", name(c.from)}, {"to", name(c.to)}, {"because", c.reason}});
  for (const auto& b : r.broken_rules)
    rules.push_back({{"t", b.t}, {"rule", name(b.rule)}, {"because", b.reason}});
  for (const auto& f : r.injected) faults.push_back({{"t", f.t}, {"fault", f.what}});
  Json cycles = Json::object();
  for (std::size_t q = 0; q < r.quality_cycles.size(); ++q)
    cycles[std::string(name(static_cast<sim_hal::FriQuality>(q)))] = r.quality_cycles[q];

  const Json j = {
      {"schema", "colift.emulate/1"},
      {"device", "krc"},
      {"because", reason},
      {"script", o.script},
      {"plant", o.common.plant},
      {"to", o.to},
      {"cycle_ms", o.cycle_ms},
      {"speed", o.common.speed},
      {"seed", o.common.seed},
      {"duration_s", r.duration_s},
      {"state", name(r.state)},
      {"command_s", 1e-3 * o.cycle_ms * static_cast<double>(r.command_cycles)},
      {"packets",
       {{"sent", r.sent},
        {"answered", r.answered},
        {"missed", r.missed},
        {"most_missed_in_a_row", r.most_missed_in_a_row},
        {"missed_in_command", r.missed_in_command},
        {"received", r.received},
        {"late", r.late},
        {"duplicate", r.duplicate},
        {"reordered", r.reordered},
        {"rejected", rejected}}},
      {"quality",
       {{"now", name(r.quality)},
        {"answer_rate", r.answer_rate},
        {"latency_ms", 1e3 * r.latency_s},
        {"jitter_ms", 1e3 * r.jitter_s},
        {"cycles", cycles}}},
      {"mode_changes", changes},
      {"broken_rules", rules},
      {"broken_rules_in_all", r.broken_rules_in_all},
      {"faults", faults},
      {"timing",
       {{"realtime", timing.realtime},
        {"cycles", timing.cycles},
        {"late_cycles", timing.late},
        {"worst_late_ms", timing.worst_late_ms},
        {"plant_ms", timing.plant_ms},
        {"worst_plant_ms", timing.worst_plant_ms},
        {"wall_s", timing.wall_s}}},
  };
  // names of scenarios and messages may hold anything
  return j.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace colift::tools
