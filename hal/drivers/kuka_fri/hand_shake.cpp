#include "hal/drivers/kuka_fri/hand_shake.hpp"

#include "hal/drivers/kuka_fri/wire/krl_channels.hpp"

namespace colift::hal {
namespace {

constexpr double kHalted_s = 1.0;      // the heartbeat's echo may stand still for so long
constexpr double kRestarted_s = 0.3;   // a program writes its result before its state: not at one moment
constexpr double kTumRequest_s = 4.5;  // TUM's client lets a request stand for so long
constexpr double kTumGuard_s = 0.8;    // and keeps it for so long after the answer
constexpr std::uint16_t kTumRequestBit = 1 << 0, kTumCommandBit = 1 << 7;

bool commanding(const FriMeasurement& m) {
  return m.state == FriState::Command;
}

/// config/krl/colift.src
class CoLiftScript final : public HandShake {
 public:
  explicit CoLiftScript(std::int32_t strategy) : strategy_(strategy) {}

  void step(Ask ask, const FriMeasurement& m, double since_s, double timeout_s,
            KrlChannels& out) noexcept override {
    using namespace colift_krl;
    const auto& in = m.krl.integer;
    out = KrlChannels{};
    beat(in[kFromBeat], since_s);
    out.integer[kToVersion] = kVersion;
    out.integer[kToBeat] = beat_;
    if (ask != asked_) {
      asked_ = ask;
      number_ = 0;
      since_asked_s_ = idle_s_ = 0.0;
      sign_ = ScriptSign::Working;
      code_ = kAtWork;
    }
    since_asked_s_ += since_s;
    // a program that has not begun yet would take the number for an old one
    if (ask != Ask::Nothing && number_ == 0 && in[kFromVersion] == kVersion)
      number_ = in[kFromNumber] >= 1 && in[kFromNumber] < kMostNumber ? in[kFromNumber] + 1 : 1;
    if (ask == Ask::Nothing || number_ == 0) {
      out.integer[kToNumber] = in[kFromNumber];
      if (ask != Ask::Nothing) {
        if (since_asked_s_ > timeout_s) sign_ = ScriptSign::Silent;
        return;
      }
      sign_ = in[kFromVersion] != kVersion  ? ScriptSign::Silent
              : echo_still_s_ > kHalted_s   ? ScriptSign::Halted
              : in[kFromState] == kCommands ? ScriptSign::Done
                                            : ScriptSign::Unknown;
      code_ = in[kFromResult];
      return;
    }
    out.integer[kToRequest] = ask == Ask::Start ? kStart : ask == Ask::Stop ? kStop : kClose;
    out.integer[kToStrategy] = ask == Ask::Start ? strategy_ : 0;
    out.integer[kToNumber] = number_;
    judge(in, since_s, timeout_s);
  }

 private:
  void judge(const std::array<std::int32_t, 16>& in, double since_s, double timeout_s) {
    using namespace colift_krl;
    const bool there = in[kFromVersion] == kVersion;
    const bool taken = there && in[kFromNumber] == number_;
    code_ = in[kFromResult];
    if (!taken) {
      if (since_asked_s_ > timeout_s)
        sign_ = there && echo_still_s_ > kHalted_s ? ScriptSign::Halted : ScriptSign::Silent;
      return;
    }
    idle_s_ = code_ == kAtWork && in[kFromState] == kWaits ? idle_s_ + since_s : 0.0;
    if (in[kFromState] == kCloses) {
      sign_ = ScriptSign::Ended;
    } else if (code_ == kDone) {
      sign_ = ScriptSign::Done;
    } else if (code_ != kAtWork) {
      sign_ = ScriptSign::Refused;
    } else if (idle_s_ > kRestarted_s) {
      sign_ = ScriptSign::Restarted;
    } else {
      sign_ = echo_still_s_ > kHalted_s ? ScriptSign::Halted : ScriptSign::Working;
    }
  }

  void beat(std::int32_t echo, double since_s) {
    since_beat_s_ += since_s;
    echo_still_s_ = echo == echo_ ? echo_still_s_ + since_s : 0.0;
    echo_ = echo;
    if (since_beat_s_ < colift_krl::kBeat_s) return;
    since_beat_s_ = 0.0;
    beat_ = beat_ >= colift_krl::kMostNumber ? 1 : beat_ + 1;
  }

  std::int32_t strategy_, number_ = 0, beat_ = 1, echo_ = 0;
  Ask asked_ = Ask::Nothing;
  double since_asked_s_ = 0.0, idle_s_ = 0.0, since_beat_s_ = 0.0, echo_still_s_ = 0.0;
};

/// FRIControl.src of the Stanford FRI library.
class StanfordScript final : public HandShake {
 public:
  explicit StanfordScript(std::int32_t strategy) : strategy_(strategy) {}

  void step(Ask ask, const FriMeasurement& m, double since_s, double timeout_s,
            KrlChannels& out) noexcept override {
    constexpr std::int32_t kStart = 10, kStop = 20, kSaysStopped = 10, kSaysStarted = 20, kEnded = 30;
    const std::int32_t says = m.krl.integer[15];
    if (ask != asked_) {
      asked_ = ask;
      since_asked_s_ = 0.0;
      request_ = kStop;
    }
    since_asked_s_ += since_s;
    out = KrlChannels{};
    if (ask == Ask::Nothing) {
      sign_ = ScriptSign::Unknown;
      out.integer[15] = ever_ ? kStop : 0;
      return;
    }
    ever_ = true;
    bool done = false;
    if (ask == Ask::Start) {
      // it starts on a change only: a start that it believes to have done has to be taken back first
      if (request_ == kStart || says != kSaysStarted || commanding(m)) request_ = kStart;
      done = request_ == kStart && says == kSaysStarted;
      out.integer[14] = strategy_;
      out.integer[15] = request_;
    } else if (ask == Ask::Stop) {
      out.integer[15] = kStop;
      done = says == kSaysStopped;
    } else {
      out.integer[15] = m.krl.integer[14] != 0 ? m.krl.integer[14] : kEnded;
      done = says == kEnded;
    }
    code_ = says;
    sign_ = done                         ? (ask == Ask::Close ? ScriptSign::Ended : ScriptSign::Done)
            : since_asked_s_ > timeout_s ? ScriptSign::Silent
                                         : ScriptSign::Working;
  }

 private:
  std::int32_t strategy_, request_ = 0;
  Ask asked_ = Ask::Nothing;
  bool ever_ = false;
  double since_asked_s_ = 0.0;
};

/// fri_hand.src of TUM, fri_start.src of RCPRG.
class TumScript final : public HandShake {
 public:
  void step(Ask ask, const FriMeasurement& m, double since_s, double, KrlChannels& out) noexcept override {
    if (ask != asked_) {
      asked_ = ask;
      waited_s_ = guard_s_ = 0.0;
      answered_ = false;
      sign_ = ask == Ask::Nothing ? ScriptSign::Unknown : ScriptSign::Working;
    }
    out = KrlChannels{};
    if (commanding(m)) out.boolean |= kTumCommandBit;
    if (ask == Ask::Nothing) return;
    waited_s_ += since_s;
    if ((m.krl.boolean & kTumRequestBit) != 0) answered_ = true;
    if (answered_) {
      guard_s_ += since_s;
      sign_ = ScriptSign::Done;
      if (guard_s_ < kTumGuard_s) out.integer[0] = ask == Ask::Start ? 1 : 2;
    } else if (waited_s_ < kTumRequest_s) {
      out.integer[0] = ask == Ask::Start ? 1 : 2;
      out.boolean |= kTumRequestBit;
    } else {
      sign_ = ScriptSign::Silent;
    }
  }

 private:
  Ask asked_ = Ask::Nothing;
  double waited_s_ = 0.0, guard_s_ = 0.0;
  bool answered_ = false;
};

/// The sample of the vendor's SDK.
class VendorScript final : public HandShake {
 public:
  void step(Ask ask, const FriMeasurement& m, double, double, KrlChannels& out) noexcept override {
    out = KrlChannels{};
    out.real[0] = m.krl.real[1];
    out.integer[0] = 1;
    if (ask == Ask::Start && (going_ || m.quality >= FriQuality::Ok)) {
      going_ = true;
      out.integer[0] = 10;
    }
    if (ask != Ask::Start) going_ = false;
    sign_ = m.krl.integer[0] == -1 ? ScriptSign::Ended
            : ask == Ask::Nothing  ? ScriptSign::Unknown
                                   : ScriptSign::Working;
  }

 private:
  bool going_ = false;
};

/// Nobody listens: a person works at the panel.
class NoScript final : public HandShake {
 public:
  void step(Ask, const FriMeasurement&, double, double, KrlChannels& out) noexcept override {
    out = KrlChannels{};
  }
};

}  // namespace

std::unique_ptr<HandShake> make_hand_shake(std::string_view script, std::int32_t strategy) {
  if (script == "colift") return std::make_unique<CoLiftScript>(strategy);
  if (script == "stanford") return std::make_unique<StanfordScript>(strategy);
  if (script == "tum") return std::make_unique<TumScript>();
  if (script == "vendor") return std::make_unique<VendorScript>();
  return std::make_unique<NoScript>();
}

}  // namespace colift::hal
