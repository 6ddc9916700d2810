#include "control/task/intent.hpp"

#include <array>
#include <utility>

namespace colift::control {
namespace {

constexpr double kGivenUp_s = 0.1;

struct Words {
  std::string_view name, says;
};

// in the order of Motion
constexpr std::array<Words, kMotions> kWords{{{"approach", "the arm moves to the grasp"},
                                              {"close", "the hand closes"},
                                              {"lift", "lifts the object"},
                                              {"lower", "lowers the object"},
                                              {"open", "the hand opens"},
                                              {"retreat", "the arm leaves the object and goes home"},
                                              {"return", "the arm returns along its path"},
                                              {"continue", "the arm continues"}}};

const Words& words_of(Motion motion) {
  return kWords[static_cast<std::size_t>(motion)];
}

}  // namespace

std::string_view to_string(Motion motion) {
  return words_of(motion).name;
}

bool IntentAnnouncer::may_begin(Motion motion, hal::Timestamp since_start) {
  if (lead_s_ <= 0.0) return true;
  Announced& announced = announced_[static_cast<std::size_t>(motion)];
  const bool known = announced.ever && hal::seconds(since_start - announced.asked_at) < kGivenUp_s;
  announced.asked_at = since_start;
  if (!known) {
    announced.ever = true;
    announced.at = since_start;
    into_->push_back({since_start, motion, lead_s_, std::string(words_of(motion).says)});
  }
  return hal::seconds(since_start - announced.at) >= lead_s_;
}

void IntentAnnouncer::request(std::string says, hal::Timestamp since_start) {
  into_->push_back({since_start, std::nullopt, 0.0, std::move(says)});
}

}  // namespace colift::control
