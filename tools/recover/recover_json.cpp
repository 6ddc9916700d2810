#include "tools/recover/recover_json.hpp"

#include <nlohmann/json.hpp>

namespace colift::tools {
namespace {

using Json = nlohmann::ordered_json;

std::string_view word(control::Assessment::Arm arm) {
  using enum control::Assessment::Arm;
  switch (arm) {
    case Unknown:
      return "unknown";
    case Moving:
      return "moving";
    case AtHome:
      return "at-home";
    case Away:
      return "away";
  }
  return "";
}

std::string_view word(control::Assessment::Hand hand) {
  using enum control::Assessment::Hand;
  switch (hand) {
    case Unknown:
      return "unknown";
    case Open:
      return "open";
    case Holds:
      return "holds";
    case Closed:
      return "closed";
    case Between:
      return "may-hold";
  }
  return "";
}

}  // namespace

std::string recover_document(const control::RecoveryRecord& record) {
  const control::Assessment& a = record.before;
  Json steps = Json::array();
  for (const auto& s : record.steps)
    steps.push_back({{"t", hal::seconds(s.at)}, {"step", control::word(s.step)}, {"because", s.reason}});
  const Json j = {
      {"schema", "colift.recover/1"},
      {"outcome", record.recovered ? "recovered" : "held"},
      {"because", record.reason},
      {"before",
       {{"arm", word(a.arm)},
        {"arm_because", a.arm_words},
        {"hand", word(a.hand)},
        {"hand_because", a.hand_words},
        {"load_n", a.load_n ? Json(*a.load_n) : Json(nullptr)},
        {"load_because", a.load_words}}},
      {"steps", steps},
      {"arm_at_rest", record.arm_at_rest},
  };
  return j.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace colift::tools
