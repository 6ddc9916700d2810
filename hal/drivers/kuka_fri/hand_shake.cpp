#include "hal/drivers/kuka_fri/hand_shake.hpp"

#include "hal/drivers/kuka_fri/wire/krl_channels.hpp"

namespace colift::hal {
namespace {

constexpr double kHalted_s = 1.0;      // the heartbeat's echo may stand still for so long
constexpr double kRestarted_s = 0.3;   // a program writes its result before its state: not at one moment
constexpr double kTumRequest_s = 4.5;  // TUM's client lets a request stand for so long
constexpr double kTumGuard_s = 0.8;    // and keeps it for so long after the answer
constexpr double kCepStarts_s = 1.5;   // its message, and friStart
constexpr std::uint16_t kTumRequestBit = 1 << 0, kTumCommandBit = 1 << 7;

bool commanding(const FriMeasurement& m) {
  return m.state == FriState::Command;
}

/// config/krl/colift.src
class CoLiftScript final : public HandShake {
 public:
  using HandShake::HandShake;

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

  std::int32_t number_ = 0, beat_ = 1, echo_ = 0;
  Ask asked_ = Ask::Nothing;
  double since_asked_s_ = 0.0, idle_s_ = 0.0, since_beat_s_ = 0.0, echo_still_s_ = 0.0;
};

/// FRIControl.src of the Stanford FRI library.
class StanfordScript final : public HandShake {
 public:
  using HandShake::HandShake;

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
  std::int32_t request_ = 0;
  Ask asked_ = Ask::Nothing;
  bool ever_ = false;
  double since_asked_s_ = 0.0;
};

/// fri_hand.src of TUM, fri_start.src of RCPRG.
class TumScript final : public HandShake {
 public:
  using HandShake::HandShake;

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

/// ros_control.src of the Centro Piaggio. Begun anew it starts in position control only, whatever it is asked
/// for; what it is told to do it acknowledges when it is done, after a wait for perfect quality.
class CepScript final : public HandShake {
 public:
  using HandShake::HandShake;

  void step(Ask ask, const FriMeasurement& m, double since_s, double timeout_s,
            KrlChannels& out) noexcept override {
    constexpr std::int32_t kStopped = 0, kStarted = 1, kBegun = 10, kPosition = 10;
    const std::int32_t says = m.krl.integer[1];
    const bool is_it = says == kStopped || says == kStarted || says == kBegun;
    if (ask != asked_) {
      asked_ = ask;
      since_asked_s_ = since_good_s_ = left_s_ = 0.0;
      on_detour_ = false;
      sign_ = ask == Ask::Nothing ? ScriptSign::Unknown : ScriptSign::Working;
    }
    since_asked_s_ += since_s;
    since_good_s_ = m.quality == FriQuality::Perfect ? since_good_s_ + since_s : 0.0;
    known_ = (known_ || says == kStarted || says == kBegun) && is_it;
    out = KrlChannels{};
    out.integer[0] = strategy_;
    code_ = says;
    if (ask != Ask::Start) {
      detour_ = detour_ && commanding(m);  // its flags until command mode is left
      if (ask == Ask::Nothing) return;
      sign_ = says != kStarted && !commanding(m) ? (ask == Ask::Close ? ScriptSign::Ended : ScriptSign::Done)
              : since_asked_s_ > timeout_s       ? ScriptSign::Silent
                                                 : ScriptSign::Working;
      return;
    }
    if (says == kBegun && strategy_ != kPosition && !commanding(m)) detour_ = true;
    if (!detour_ || commanding(m)) left_s_ = 0.0;
    on_detour_ = detour_ && (on_detour_ || commanding(m));
    // friStop and its acknowledgement are not seen in one moment
    if (on_detour_ && !commanding(m) && says != kStopped) left_s_ += since_s;
    if (left_s_ > (says == kBegun ? 0.0 : kRestarted_s)) sign_ = ScriptSign::Lost;
    if (says == kStopped && !commanding(m)) detour_ = on_detour_ = false;
    // a start that it believes to have done has to be taken back first
    const bool take_back = says == kStarted && (detour_ || !commanding(m));
    out.integer[1] = take_back ? 0 : 1;
    if (sign_ == ScriptSign::Lost) return;
    // all zeros may be another program: this one starts as soon as the quality is perfect
    const bool silent =
        is_it ? !known_ && since_good_s_ > timeout_s + kCepStarts_s : since_asked_s_ > timeout_s;
    sign_ = says == kStarted && !take_back ? ScriptSign::Done
            : silent && !commanding(m)     ? ScriptSign::Silent
                                           : ScriptSign::Working;
  }

 private:
  Ask asked_ = Ask::Nothing;
  double since_asked_s_ = 0.0, since_good_s_ = 0.0, left_s_ = 0.0;
  bool known_ = false, on_detour_ = false;
};

/// OpenKC's program: numbered commands, each with a request bit that is answered by the program's bit and the
/// command's number. The strategy is one command, friStart the next.
class OpenKcScript final : public HandShake {
 public:
  using HandShake::HandShake;

  void step(Ask ask, const FriMeasurement& m, double since_s, double timeout_s,
            KrlChannels& out) noexcept override {
    if (ask != asked_) {
      asked_ = ask;
      done_ = 0;
      asking_ = acknowledged_ = false;
      since_step_s_ = 0.0;
      sign_ = ask == Ask::Nothing ? ScriptSign::Unknown : ScriptSign::Working;
    }
    out = KrlChannels{};
    out.integer[13] = m.krl.integer[13];  // it counts the commands
    code_ = m.krl.integer[14];
    const std::int32_t command = next_command();
    if (command == 0 || sign_ == ScriptSign::Silent) return;
    since_step_s_ += since_s;
    if (since_step_s_ > timeout_s + (command == kStart ? kFriStart_s : 0.0)) {
      sign_ = ScriptSign::Silent;
      return;
    }
    const bool bit = (m.krl.boolean & kRequestBit) != 0;
    if (!asking_ && bit) return;  // an answer that still stands there is to an older command
    asking_ = true;
    acknowledged_ = acknowledged_ || (bit && m.krl.integer[14] == command);
    if (!acknowledged_) {
      out.integer[15] = command;
      out.boolean = kRequestBit;
      return;
    }
    if (bit) return;  // until it has taken its answer back
    asking_ = acknowledged_ = false;
    since_step_s_ = 0.0;
    ++done_;
    if (next_command() == 0) sign_ = asked_ == Ask::Close ? ScriptSign::Ended : ScriptSign::Done;
  }

 private:
  static constexpr std::uint16_t kRequestBit = 1 << 0;
  static constexpr std::int32_t kStart = 1, kStop = 2, kCartesian = 6, kJoints = 7, kPosition = 9, kEnd = 99;
  static constexpr double kFriStart_s = 3.0;  // it answers when friStart has returned

  /// 0: all is done.
  [[nodiscard]] std::int32_t next_command() const {
    const std::int32_t strategy = strategy_ == 10 ? kPosition : strategy_ == 20 ? kCartesian : kJoints;
    if (asked_ == Ask::Start) return done_ == 0 ? strategy : done_ == 1 ? kStart : 0;
    if (asked_ == Ask::Stop) return done_ == 0 ? kStop : 0;
    if (asked_ == Ask::Close) return done_ == 0 ? kStop : done_ == 1 ? kEnd : 0;
    return 0;
  }

  Ask asked_ = Ask::Nothing;
  int done_ = 0;
  bool asking_ = false, acknowledged_ = false;
  double since_step_s_ = 0.0;
};

/// The sample of the vendor's SDK.
class VendorScript final : public HandShake {
 public:
  using HandShake::HandShake;

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
  using HandShake::HandShake;

  void step(Ask, const FriMeasurement&, double, double, KrlChannels& out) noexcept override {
    out = KrlChannels{};
  }
};

}  // namespace

bool script_sets_strategy(std::string_view script) {
  return script == "colift" || script == "stanford" || script == "cep" || script == "openkc";
}

std::unique_ptr<HandShake> make_hand_shake(std::string_view script, std::int32_t strategy) {
  if (script == "colift") return std::make_unique<CoLiftScript>(strategy);
  if (script == "stanford") return std::make_unique<StanfordScript>(strategy);
  if (script == "tum") return std::make_unique<TumScript>(strategy);
  if (script == "cep") return std::make_unique<CepScript>(strategy);
  if (script == "openkc") return std::make_unique<OpenKcScript>(strategy);
  if (script == "vendor") return std::make_unique<VendorScript>(strategy);
  return std::make_unique<NoScript>(strategy);
}

}  // namespace colift::hal
