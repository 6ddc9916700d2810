#include "hal/drivers/barrett_can/service/hand_reading.hpp"

#include <algorithm>
#include <chrono>

#include "hal/drivers/barrett_can/hand_units.hpp"
#include "hal/drivers/barrett_can/pucks/puck_link.hpp"
#include "hal/drivers/barrett_can/pucks/wait_on.hpp"

namespace colift::hal {
namespace {

using namespace barrett;

constexpr const char* kWhere = "hand.read";
constexpr Duration kPatient = std::chrono::seconds(60);

// what the monitor of a sleeping puck answers, then what an awake one does besides
constexpr std::array kReadOfAll{Property::Stat, Property::Error, Property::Vers, Property::Role,
                                Property::Sn};
constexpr std::array kReadOfAwake{Property::Mode, Property::P,     Property::T,     Property::Sg,
                                  Property::Temp, Property::Therm, Property::Otemp, Property::Vbus,
                                  Property::Mt,   Property::Tstop, Property::Hold,  Property::GrpA,
                                  Property::GrpB, Property::GrpC,  Property::Ct,    Property::Upsecs};

class Reader {
 public:
  Reader(CanBus& bus, const Clock& clock, const BarrettHandConfig& config)
      : clock_(clock),
        link_(bus, clock, std::chrono::microseconds(static_cast<std::int64_t>(1e3 * config.reply_ms)),
              std::chrono::microseconds(static_cast<std::int64_t>(1e3 * config.tactile_reply_ms))) {}

  Result<HandReading> run() {
    link_.measure_round_trip(kPatient);
    for (const Property p : kReadOfAll) read(p, [](const PuckReading&) { return true; });
    if (reading_.answering() == 0)
      return failure(
          ErrorCode::LinkLost, kWhere,
          "no puck answers: is the hand's supply on (48 V), the bus terminated, and is this its bus?");
    for (const Property p : kReadOfAwake) read(p, [](const PuckReading& puck) { return puck.awake(); });
    for (const Puck finger : kFingerPucks)
      if (const Reported& joint = link_.reported(finger, Property::Jp); joint.known)
        reading_.pucks[index(finger)].joint = joint.value;
    reading_.round_trip = link_.round_trip().worst();
    return reading_;
  }

 private:
  template <class Whom>
  void read(Property property, const Whom& whom) {
    std::array<bool, kPucks> asked{};
    for (const Puck puck : kAllPucks) {
      // whoever is silent about its status is not asked for more
      asked[index(puck)] = whom(reading_.pucks[index(puck)]) &&
                           (property == Property::Stat || reading_.pucks[index(puck)].answers);
      if (asked[index(puck)]) link_.ask(puck, property);
    }
    (void)wait_on(link_, clock_, link_.three_tries() + std::chrono::milliseconds(20), [&] {
      return std::none_of(kAllPucks.begin(), kAllPucks.end(),
                          [&](Puck puck) { return link_.pending(puck, property); });
    });
    for (const Puck puck : kAllPucks) {
      if (!asked[index(puck)]) continue;
      const Reported& value = link_.reported(puck, property);
      PuckReading& of = reading_.pucks[index(puck)];
      of.answers = of.answers || value.known;
      of.values.push_back({property, value.known ? std::optional(value.value) : std::nullopt});
    }
  }

  const Clock& clock_;
  PuckLink link_;
  HandReading reading_;
};

}  // namespace

std::optional<std::int32_t> PuckReading::of(Property property) const {
  const auto found =
      std::find_if(values.begin(), values.end(), [&](const Value& v) { return v.property == property; });
  return found == values.end() ? std::nullopt : found->value;
}

bool PuckReading::awake() const {
  return of(Property::Stat) == kStatReady;
}

bool PuckReading::zero_known() const {
  const auto ct = of(Property::Ct);
  return ct && (*ct == zero_mark(Puck::F1) || *ct == zero_mark(Puck::Spread));
}

int HandReading::answering() const {
  return static_cast<int>(
      std::count_if(pucks.begin(), pucks.end(), [](const PuckReading& p) { return p.answers; }));
}

Result<HandReading> read_hand(CanBus& bus, const Clock& clock, const BarrettHandConfig& config) {
  if (auto opened = bus.open(); !opened) return tl::unexpected(opened.error());
  return Reader(bus, clock, config).run();
}

}  // namespace colift::hal
