#include "hal/drivers/barrett_can/second_master.hpp"

namespace colift::hal::barrett {
namespace {

constexpr Duration kAskedLately = std::chrono::seconds(2);

}  // namespace

void SecondMaster::start() {
  settings_ = link_.foreign().settings;
  questions_ = link_.foreign().questions;
  odd_ = {};
  words_ = warning_ = {};
}

void SecondMaster::ask() {
  link_.ask_all(kWatched[next_]);
  next_ = (next_ + 1) % kWatched.size();
}

// Twice the same other value: once may be a bad frame.
void SecondMaster::judge(Puck puck, std::size_t which) {
  const Property property = kWatched[which];
  std::optional<Odd>& odd = odd_[index(puck)][which];
  const Reported& reported = link_.reported(puck, property);
  const auto& taken = link_.taken(puck, property);
  // one whose answers are another puck's, or that was reset, is reported as that
  const Reported& ct = link_.reported(puck, Property::Ct);
  const bool was_reset = ct.known && ct.value == factory_ct(puck);
  const bool other =
      was_reset || facts_.zero_lost[index(puck)] || facts_.jump_pending[index(puck)] || link_.busy(puck);
  if (!reported.known || !taken || reported.asked_at <= taken->at || reported.value == taken->value ||
      other) {
    odd.reset();
    return;
  }
  // a warm puck may limit its torque by itself
  if (property == Property::Mt && reported.value < taken->value && puck != Puck::Spread &&
      torque_fraction(link_, facts_, puck) < 1.0)
    return;
  if (odd && odd->value == reported.value && reported.asked_at > odd->asked_at) {
    say(words_, "another program commands the hand: {} of {} is {}, was set to {}; end it, then start again",
        property_info(property).name, name(puck), reported.value, taken->value);
    return;
  }
  if (odd && odd->asked_at == reported.asked_at) return;
  odd = Odd{reported.value, reported.asked_at};
  link_.ask(puck, Property::Ct);  // before the other: it was reset, perhaps
  link_.ask(puck, property);
}

void SecondMaster::step(Timestamp now) {
  const auto& foreign = link_.foreign();
  if (foreign.settings > settings_) {
    settings_ = foreign.settings;
    const Request& r = foreign.last_setting;
    const PropertyInfo* info = property_info(static_cast<std::uint8_t>(r.property));
    if (words_.empty())
      say(words_,
          "another program (node {}) commands the hand: it set {} of {} to {}; end it, then start again",
          r.from, info == nullptr ? "an unknown property" : info->name, r.puck ? name(*r.puck) : "all pucks",
          r.value);
  }
  warning_ = {};
  if (foreign.questions > questions_ && now - foreign.asked_at < kAskedLately)
    say(warning_, "another program asks the pucks too: it must not command them");
  if (!words_.empty()) return;
  for (const Puck puck : kAllPucks)
    for (std::size_t i = 0; i < kWatched.size(); ++i) judge(puck, i);
}

}  // namespace colift::hal::barrett
