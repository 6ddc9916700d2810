#include "tools/bring_up/finger/finger_words.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "hal/types/units.hpp"

namespace colift::tools {

std::optional<hal::barrett::Puck> parse_finger(const std::string& text) {
  const bool prefixed = text.size() == 2 && (text[0] == 'F' || text[0] == 'f');
  if (!prefixed && text.size() != 1) return std::nullopt;
  const char digit = text.back();
  if (digit < '1' || digit > '3') return std::nullopt;
  return hal::barrett::kFingerPucks[static_cast<std::size_t>(digit - '1')];
}

std::optional<hal::FingerMotion> finger_motion_of(const std::string& verb, hal::barrett::Puck finger,
                                                  double value) {
  using Kind = hal::FingerMotion::Kind;
  hal::FingerMotion motion;
  motion.finger = finger;
  motion.value = verb == "torque" ? value : hal::deg_to_rad(value);
  if (verb == "finger")
    motion.kind = Kind::To;
  else if (verb == "step")
    motion.kind = Kind::Step;
  else if (verb == "velocity")
    motion.kind = Kind::Velocity;
  else if (verb == "torque")
    motion.kind = Kind::Torque;
  else
    return std::nullopt;
  return motion;
}

std::string finger_text(hal::barrett::Puck finger, const hal::FingerMotionEnd& e) {
  std::string t = fmt::format("{} from {:.1f} to {:.1f} deg in {:.1f} s: {}\n", name(finger),
                              hal::rad_to_deg(e.from_rad), hal::rad_to_deg(e.to_rad), e.took_s, e.how);
  if (!std::isnan(e.max_torque_nm))
    t += fmt::format("its gauge measured up to {:.2f} N m\n", e.max_torque_nm);
  t += e.rests ? "its motor rests, as read back; the worm gear holds\n"
               : "its motor was NOT read back as resting: switch the hand's supply off\n";
  return t;
}

std::string finger_document(const std::string& verb, hal::barrett::Puck finger,
                            const hal::FingerMotionEnd& e) {
  using Json = nlohmann::ordered_json;
  Json j = {{"schema", "colift.hal.hand/1"}, {"verb", verb}, {"finger", name(finger)}};
  j["result"] = {{"outcome", e.as_asked ? "done" : "failed"},
                 {"because", e.how},
                 {"moved", e.moved},
                 {"took_s", e.took_s}};
  j["from_deg"] = hal::rad_to_deg(e.from_rad);
  j["to_deg"] = hal::rad_to_deg(e.to_rad);
  j["max_torque_nm"] = std::isnan(e.max_torque_nm) ? Json(nullptr) : Json(e.max_torque_nm);
  j["rests"] = e.rests;
  return j.dump();
}

std::string with_fingers(const std::string& hand, const std::vector<std::string>& fingers) {
  using Json = nlohmann::ordered_json;
  Json j = Json::parse(hand);
  j["fingers"] = Json::array();
  for (const std::string& finger : fingers) j["fingers"].push_back(Json::parse(finger));
  return j.dump();
}

}  // namespace colift::tools
