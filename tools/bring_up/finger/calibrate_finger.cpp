#include "tools/bring_up/finger/calibrate_finger.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "hal/drivers/barrett_can/calibration/gauge_reading.hpp"
#include "hal/drivers/barrett_can/service/finger_motion.hpp"
#include "hal/drivers/barrett_can/service/hand_reading.hpp"
#include "hal/types/units.hpp"

namespace colift::tools {
namespace {

constexpr const char* kWhere = "hand.calibrate";
constexpr double kRead_s = 1.0;
constexpr double kMax_nm = 1.5;      // a gauge is at its end near 1.9 N m
constexpr double kExample_m = 0.05;  // of the pad's middle from the outer joint
constexpr double kPress_s = 1.5;     // until a finger that presses has come to rest
constexpr double kOpen_rad = 0.17;   // afterwards
constexpr double kInTime = 0.95;
constexpr int kPresses = 4;

hal::Result<> check(const FingerCalibration& what) {
  const auto bad = [](std::string why) {
    return hal::failure(hal::ErrorCode::BadInput, "--torques", std::move(why));
  };
  if (what.torques_nm.size() < 2) return bad("expected at least two torques (N m), as in 0.2,0.5");
  for (std::size_t i = 0; i < what.torques_nm.size(); ++i) {
    const double nm = what.torques_nm[i];
    if (!(nm > 0.0 && nm <= kMax_nm))
      return bad(fmt::format("{} N m, expected more than 0 and at most {}", nm, kMax_nm));
    if (i > 0 && !(nm > what.torques_nm[i - 1])) return bad("expected each torque above the one before");
  }
  return {};
}

class Calibration {
 public:
  Calibration(hal::CanBus& bus, const hal::Clock& clock, const hal::BarrettHandConfig& config,
              const FingerCalibration& what, const AskPerson& ask)
      : bus_(bus), clock_(clock), config_(config), what_(what), ask_(ask) {}

  hal::Result<FingerCalibrated> run() {
    if (auto good = check(what_); !good) return tl::unexpected(good.error());
    if (what_.press)
      if (auto ready = may_press(); !ready) return tl::unexpected(ready.error());
    if (auto done = read_strain(); !done) return tl::unexpected(done.error());
    if (what_.press)
      if (auto done = press(); !done) return tl::unexpected(done.error());
    return result_;
  }

 private:
  // before a person has hung a weight anywhere
  hal::Result<> may_press() {
    const auto hand = hal::read_hand(bus_, clock_, config_);
    if (!hand) return tl::unexpected(hand.error());
    if (hand->pucks[index(what_.finger)].zero_known()) return {};
    return hal::failure(
        hal::ErrorCode::NotReady, kWhere,
        fmt::format("{} is asleep or does not know its zero, and is to press", name(what_.finger)));
  }

  hal::Result<hal::GaugeReading> read() {
    return hal::read_gauge(bus_, clock_, config_, what_.finger, kRead_s);
  }

  hal::Result<> read_strain() {
    if (auto ready = ask_(fmt::format("nothing touches {}", name(what_.finger))); !ready) return ready;
    const auto idle = read();
    if (!idle) return tl::unexpected(idle.error());
    idle_nm_ = idle->shown_nm;
    result_.scale.serial = idle->serial;
    result_.scale.finger = name(what_.finger);
    result_.scale.date = what_.date;
    result_.strain.push_back({0.0, 0.0});
    for (const double nm : what_.torques_nm) {
      const double kg = nm / (hal::kGravity_m_s2 * kExample_m);
      if (auto ready =
              ask_(fmt::format("bend {} open with {:.2f} N m about its outer joint, for example {:.2f} kg "
                               "hung {:.0f} mm from it, the outer link level",
                               name(what_.finger), nm, kg, 1e3 * kExample_m));
          !ready)
        return ready;
      const auto loaded = read();
      if (!loaded) return tl::unexpected(loaded.error());
      result_.strain.push_back({nm, loaded->shown_nm - idle_nm_});
    }
    const auto fit = hal::fit_scale(result_.strain);
    if (!fit) {
      std::string shown;
      for (const hal::ScalePoint& p : result_.strain)
        shown += fmt::format(", {:+.3f} at {:.2f}", p.shown, p.is);
      return hal::failure(
          fit.error().code, kWhere,
          fmt::format("{}; shown N m at those applied: {}", fit.error().detail, shown.substr(2)));
    }
    result_.scale.strain_scale = fit->scale;
    result_.scale.strain_residual_nm = fit->residual;
    result_.scale.strain_points = static_cast<int>(what_.torques_nm.size());
    return {};
  }

  // The limit of the motor is raised step by step; a finger that met something rigid shows what comes of it.
  hal::Result<> press() {
    if (auto ready = ask_(fmt::format(
            "something rigid stands in the way of {}, some centimetres from its tip", name(what_.finger)));
        !ready)
      return ready;
    const double from = config_.min_torque_units, to = config_.move_torque_units;
    hal::BarrettHandConfig pressing = config_;
    // the torque that the service is told is only a name for units; its limit of strain has to lie beyond
    // them
    pressing.max_torque_nm = kMax_nm;
    pressing.torque_units_per_nm = to / kMax_nm;
    pressing.calibration_file.clear();
    double at_rad = 0.0;
    for (int i = 1; i <= kPresses; ++i) {
      const double units = from + (to - from) * i / kPresses;
      hal::FingerMotion motion;
      motion.kind = hal::FingerMotion::Kind::Torque;
      motion.finger = what_.finger;
      motion.value = units / pressing.torque_units_per_nm;
      motion.for_s = kPress_s;
      motion.although_closed = true;
      const auto end = hal::move_finger(bus_, clock_, pressing, motion);
      if (!end) return tl::unexpected(end.error());
      at_rad = end->to_rad;
      if (end->took_s < kInTime * kPress_s) break;  // it ended before the motor gave all of it
      const auto pressed = read();
      if (!pressed) return tl::unexpected(pressed.error());
      const double nm = result_.scale.strain_scale * (pressed->shown_nm - idle_nm_);
      if (nm > config_.contact_nm) result_.torque.push_back({units, nm});
    }
    hal::FingerMotion open;
    open.finger = what_.finger;
    open.kind = hal::FingerMotion::Kind::To;
    open.value = std::max(0.0, at_rad - kOpen_rad);
    open.although_closed = true;
    if (const auto opened = hal::move_finger(bus_, clock_, config_, open); !opened)
      return tl::unexpected(opened.error());
    const auto fit = hal::fit_scale(result_.torque);
    if (!fit)
      return hal::failure(fit.error().code, kWhere,
                          fmt::format("{} pressed on nothing that tells its torque: {}", name(what_.finger),
                                      fit.error().detail));
    result_.scale.torque_units_per_nm = fit->scale;
    result_.scale.torque_points = static_cast<int>(result_.torque.size());
    return {};
  }

  hal::CanBus& bus_;
  const hal::Clock& clock_;
  const hal::BarrettHandConfig& config_;
  const FingerCalibration& what_;
  const AskPerson& ask_;
  double idle_nm_ = 0.0;
  FingerCalibrated result_;
};

}  // namespace

hal::Result<FingerCalibrated> calibrate_finger(hal::CanBus& bus, const hal::Clock& clock,
                                               const hal::BarrettHandConfig& config,
                                               const FingerCalibration& what, const AskPerson& ask) {
  return Calibration(bus, clock, config, what, ask).run();
}

std::string calibration_text(hal::barrett::Puck finger, const FingerCalibrated& r) {
  std::string t = fmt::format("{}, puck {}\n", name(finger), r.scale.serial);
  for (const hal::ScalePoint& p : r.strain)
    t += fmt::format("  {:.2f} N m applied, {:+.3f} N m by the maker's curve\n", p.is, p.shown);
  t += fmt::format("true torque = {:.3f} of the curve's, {:.3f} N m off in the mean\n", r.scale.strain_scale,
                   r.scale.strain_residual_nm);
  for (const hal::ScalePoint& p : r.torque)
    t += fmt::format("  {:.0f} units of the motor, {:.2f} N m at the fingertip\n", p.is, p.shown);
  if (r.scale.torque_points > 0)
    t += fmt::format("{:.0f} units of the motor for 1 N m\n", r.scale.torque_units_per_nm);
  return t;
}

std::string calibration_document(hal::barrett::Puck finger, const FingerCalibrated& r) {
  using Json = nlohmann::ordered_json;
  const auto points = [](const std::vector<hal::ScalePoint>& all, const char* is, const char* shown) {
    Json list = Json::array();
    for (const hal::ScalePoint& p : all) list.push_back({{is, p.is}, {shown, p.shown}});
    return list;
  };
  Json j = {{"schema", "colift.hal.hand/1"}, {"verb", "calibrate"}, {"finger", name(finger)}};
  j["result"] = {{"outcome", "done"}};
  j["serial"] = r.scale.serial;
  j["strain_scale"] = r.scale.strain_scale;
  j["strain_residual_nm"] = r.scale.strain_residual_nm;
  j["strain"] = points(r.strain, "applied_nm", "shown_nm");
  j["torque_units_per_nm"] = r.scale.torque_points > 0 ? Json(r.scale.torque_units_per_nm) : Json(nullptr);
  j["torque"] = points(r.torque, "units", "torque_nm");
  return j.dump();
}

}  // namespace colift::tools
