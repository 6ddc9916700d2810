#include <fmt/format.h>

#include <array>
#include <utility>

#include "sim_hal/emulator/krc/krl_scripts.hpp"

namespace colift::sim_hal {
namespace {

// The channels of config/krl/colift.src; docs/krl-hand-shakes.md has the table.
constexpr std::int32_t kVersion = 10001;
enum Request : std::int32_t { kNone = 0, kStart = 1, kStop = 2, kClose = 3 };
enum State : std::int32_t { kBegins = 0, kWaits = 1, kStarts = 2, kCommands = 3, kStops = 4, kCloses = 5 };
enum Outcome : std::int32_t {
  kAtWork = 0,
  kDone = 1,
  kNoQuality = 2,
  kNoStrategy = 3,
  kNotStarted = 4,
  kLost = 5,
  kWrongVersion = 6,
  kNoRequest = 7,
  kNoHeartbeat = 8,
};
constexpr double kPeriod_s = 0.02, kSettles_s = 0.5, kQuality_s = 5.0, kCommand_s = 1.0, kHeartbeat_s = 1.0,
                 kClosing_s = 1.0;

/// The program that CoLift ships for its own client.
class ColiftScript final : public KrlScript {
 public:
  explicit ColiftScript(const KrlScriptConfig& config) : config_(config) {}

  [[nodiscard]] double period_s() const override { return kPeriod_s; }

  void begin(KrlHost& krc) override {
    ended_ = friing_ = false;
    krc.to_pc() = {};
    krc.ptp_here();
    krc.set_strategy(config_.strategy.value_or(FriControl::Position), {});
    krc.fri_open(krc.cycle_ms());
    until_s_ = krc.now_s() + kSettles_s;
  }

  void poll(KrlHost& krc) override {
    if (ended_) return;
    const auto& from = krc.from_pc().integer;
    auto& to = krc.to_pc().integer;
    if (to[1] == kBegins) {
      if (krc.now_s() < until_s_) return;
      to[3] = from[3];
      to[0] = kVersion;
      to[1] = kWaits;
      return;
    }
    if (to[1] == kCloses) {
      if (krc.now_s() < until_s_) return;
      krc.fri_close("the client asked for the end");
      ended_ = true;
      return;
    }
    hear(krc);
    if (to[1] == kCommands) watch(krc);
    if (from[3] != to[3]) take(krc);
    if (to[1] == kStarts) start(krc);
  }

  [[nodiscard]] bool ended() const override { return ended_; }

 private:
  void hear(KrlHost& krc) {
    const std::int32_t beat = krc.from_pc().integer[4];
    if (beat != krc.to_pc().integer[4]) heard_s_ = krc.now_s();
    krc.to_pc().integer[4] = beat;
  }

  void finish(KrlHost& krc, State state, Outcome outcome) {
    krc.to_pc().integer[1] = state;
    krc.to_pc().integer[5] = outcome;
  }

  void watch(KrlHost& krc) {
    if (krc.fri_state() != FriState::Command) {
      finish(krc, kWaits, kLost);
    } else if (krc.now_s() - heard_s_ > kHeartbeat_s) {
      krc.fri_stop("the client's heartbeat did not change for 1 s");
      finish(krc, kWaits, kNoHeartbeat);
    }
  }

  void take(KrlHost& krc) {
    const auto& from = krc.from_pc().integer;
    auto& to = krc.to_pc().integer;
    to[5] = kAtWork;
    to[3] = from[3];
    // a start that is on its way ends with any other request
    if (to[1] == kStarts && !friing_) to[1] = kWaits;
    if (from[0] != kVersion) {
      to[5] = kWrongVersion;
      return;
    }
    switch (from[1]) {
      case kNone:
        to[5] = kDone;
        return;
      case kStart:
        return ask_start(krc);
      case kStop:
        friing_ = false;
        if (krc.fri_state() == FriState::Command || krc.start_pending())
          krc.fri_stop("the client asked for a stop");
        return finish(krc, kWaits, kDone);
      case kClose:
        friing_ = false;
        if (krc.fri_state() == FriState::Command || krc.start_pending())
          krc.fri_stop("the client asked for the end");
        until_s_ = krc.now_s() + std::max(kClosing_s, config_.linger_s);
        return finish(krc, kCloses, kDone);
      default:
        to[5] = kNoRequest;
    }
  }

  void ask_start(KrlHost& krc) {
    auto& to = krc.to_pc().integer;
    const std::int32_t strategy = krc.from_pc().integer[2];
    static constexpr std::array<std::pair<std::int32_t, FriControl>, 3> kStrategies{
        {{10, FriControl::Position}, {20, FriControl::CartesianImpedance}, {30, FriControl::JointImpedance}}};
    for (const auto& [number, control] : kStrategies) {
      if (number != strategy) continue;
      if (to[1] == kCommands) {
        to[5] = to[2] == strategy ? kDone : kNoStrategy;
        return;
      }
      krc.ptp_here();
      krc.set_strategy(control, {});
      to[2] = strategy;
      to[1] = kStarts;
      friing_ = false;
      until_s_ = krc.now_s() + kQuality_s;
      asked_s_ = krc.now_s();
      return;
    }
    to[5] = kNoStrategy;
  }

  void start(KrlHost& krc) {
    if (!friing_) {
      // the round after the strategy: `control` is on the wire before friStart looks at the flags
      if (krc.now_s() - asked_s_ < kPeriod_s) return;
      if (krc.fri_quality() >= FriQuality::Ok) {
        krc.fri_start(1.0);
        friing_ = true;
        until_s_ = krc.now_s() + kCommand_s;
      } else if (krc.now_s() > until_s_) {
        finish(krc, kWaits, kNoQuality);
      }
      return;
    }
    if (krc.fri_state() == FriState::Command) {
      friing_ = false;
      heard_s_ = krc.now_s();
      finish(krc, kCommands, kDone);
    } else if (!krc.start_pending() || krc.now_s() > until_s_) {
      friing_ = false;
      finish(krc, kWaits, kNotStarted);
    }
  }

  KrlScriptConfig config_;
  bool ended_ = false, friing_ = false;
  double until_s_ = 0.0, heard_s_ = 0.0, asked_s_ = 0.0;
};

}  // namespace

std::unique_ptr<KrlScript> make_colift_script(const KrlScriptConfig& config) {
  return std::make_unique<ColiftScript>(config);
}

const std::vector<std::string_view>& krl_script_names() {
  static const std::vector<std::string_view> names{"colift", "stanford", "tum", "vendor", "cep", "openkc"};
  return names;
}

std::unique_ptr<KrlScript> make_krl_script(std::string_view name, const KrlScriptConfig& config) {
  if (name == "colift") return make_colift_script(config);
  if (name == "stanford") return make_stanford_script(config);
  if (name == "tum") return make_tum_script(config);
  if (name == "vendor") return make_vendor_script(config);
  if (name == "cep") return make_cep_script(config);
  if (name == "openkc") return make_openkc_script(config);
  return nullptr;
}

}  // namespace colift::sim_hal
