#include "hal/drivers/barrett_can/calibration/gauge_reading.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "hal/drivers/barrett_can/hand_units.hpp"
#include "hal/drivers/barrett_can/pucks/puck_link.hpp"
#include "hal/drivers/barrett_can/pucks/wait_on.hpp"

namespace colift::hal {
namespace {

using namespace barrett;

constexpr const char* kWhere = "hand.gauge";
constexpr Duration kPatient = std::chrono::seconds(60);
constexpr std::int32_t kMost = 4095;

}  // namespace

Result<GaugeReading> read_gauge(CanBus& bus, const Clock& clock, const BarrettHandConfig& config, Puck finger,
                                double for_s) {
  if (auto opened = bus.open(); !opened) return tl::unexpected(opened.error());
  PuckLink link(bus, clock, std::chrono::microseconds(static_cast<std::int64_t>(1e3 * config.reply_ms)),
                std::chrono::microseconds(static_cast<std::int64_t>(1e3 * config.tactile_reply_ms)));
  link.measure_round_trip(kPatient);
  const auto ask = [&](Property property) {
    link.ask(finger, property);
    (void)wait_on(link, clock, link.three_tries() + std::chrono::milliseconds(20),
                  [&] { return !link.pending(finger, property); });
    return link.reported(finger, property);
  };
  const Reported stat = ask(Property::Stat);
  if (!stat.known)
    return failure(ErrorCode::LinkLost, kWhere, fmt::format("{} does not answer", name(finger)));
  if (stat.value != kStatReady)
    return failure(ErrorCode::NotReady, kWhere,
                   fmt::format("{} is asleep: colift hal hand init comes first", name(finger)));
  const Reported role = ask(Property::Role), serial = ask(Property::Sn);
  if (!role.known || (role.value & kRoleStrain) == 0)
    return failure(ErrorCode::DeviceFault, kWhere, fmt::format("{} has no strain gauge", name(finger)));
  if (!serial.known || serial.value <= 0)
    return failure(ErrorCode::DeviceFault, kWhere,
                   fmt::format("{} does not tell its serial number", name(finger)));
  GaugeReading r;
  r.serial = serial.value;
  double sum = 0.0, squares = 0.0;
  const Timestamp end = clock.now() + duration_of(for_s);
  while (clock.now() < end) {
    const Timestamp asked = clock.now();
    const Reported sg = ask(Property::Sg);
    if (!sg.known || sg.asked_at < asked)
      return failure(ErrorCode::LinkLost, kWhere, fmt::format("{} stopped answering", name(finger)));
    if (sg.value < 0 || sg.value > kMost)
      return failure(
          ErrorCode::DeviceFault, kWhere,
          fmt::format("the gauge of {} shows {}, expected 0 to {}", name(finger), sg.value, kMost));
    sum += sg.value;
    squares += static_cast<double>(sg.value) * sg.value;
    ++r.readings;
  }
  if (r.readings == 0) return failure(ErrorCode::BadInput, kWhere, "no time was given to read the gauge");
  r.counts = sum / r.readings;
  r.noise_counts = std::sqrt(std::max(0.0, squares / r.readings - r.counts * r.counts));
  r.shown_nm = strain_nm(r.counts);
  return r;
}

}  // namespace colift::hal
