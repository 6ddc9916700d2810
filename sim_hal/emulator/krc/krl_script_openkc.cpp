// OpenKC's program, as its public client and the simulator that takes its place show it. Index 0 is KRL's 1.

#include <fmt/format.h>

#include "sim_hal/emulator/krc/krl_scripts.hpp"

namespace colift::sim_hal {
namespace {

/// A command stands in i15 with the request bit; the answer is the program's bit, the command's number in
/// i14, a count in i13 and a code in i15, and stands until the request bit is gone.
class OpenKc final : public KrlScript {
 public:
  explicit OpenKc(const KrlScriptConfig& config) : config_(config) {}

  void begin(KrlHost& krc) override {
    ended_ = false;
    starts_ = false;
    close_at_s_.reset();
    krc.to_pc() = {};
    krc.ptp_here();
    krc.set_strategy(config_.strategy.value_or(FriControl::Position), {});
    krc.fri_open(krc.cycle_ms());
  }

  void poll(KrlHost& krc) override {
    if (ended_) return;
    KrlChannels& to = krc.to_pc();
    const bool asked = (krc.from_pc().boolean & kBit) != 0, answers = (to.boolean & kBit) != 0;
    if (answers && !asked) to.boolean = static_cast<std::uint16_t>(to.boolean & ~kBit);
    if (close_at_s_) {
      if (krc.now_s() < *close_at_s_) return;
      krc.fri_close("the client asked for the end");
      ended_ = true;
      return;
    }
    if (starts_) {
      if (krc.start_pending()) return;
      starts_ = false;
      return answer(krc, kStart, 100);  // also when it did not come to command mode
    }
    if (asked && !answers) take(krc, krc.from_pc().integer[15]);
  }

  [[nodiscard]] bool ended() const override { return ended_; }

 private:
  static constexpr std::uint16_t kBit = 1U << 0;
  static constexpr std::int32_t kStart = 1, kStop = 2, kCartesian = 6, kJoints = 7, kPosition = 9, kEnd = 99;

  static void answer(KrlHost& krc, std::int32_t command, std::int32_t code) {
    KrlChannels& to = krc.to_pc();
    to.integer[14] = command;
    to.integer[15] = code;
    ++to.integer[13];
    to.boolean = static_cast<std::uint16_t>(to.boolean | kBit);
  }

  void take(KrlHost& krc, std::int32_t command) {
    switch (command) {
      case kStart:
        krc.fri_start(1.0);
        starts_ = true;
        return;
      case kStop:
        krc.fri_stop("the client asked for a stop");
        return answer(krc, command, 101);
      case kCartesian:
        krc.set_strategy(FriControl::CartesianImpedance, {});
        return answer(krc, command, 104);
      case kJoints:
        krc.set_strategy(FriControl::JointImpedance, {});
        return answer(krc, command, 105);
      case kPosition:
        krc.set_strategy(FriControl::Position, {});
        return answer(krc, command, 107);
      case kEnd:
        krc.fri_stop("the client asked for the end");
        answer(krc, command, 0);
        close_at_s_ = krc.now_s() + config_.linger_s;
        return;
      default:
        krc.say(fmt::format("no such command: FRM_INT[16] holds {}", command));
        return answer(krc, command, 0);
    }
  }

  KrlScriptConfig config_;
  bool ended_ = false, starts_ = false;
  std::optional<double> close_at_s_;
};

}  // namespace

std::unique_ptr<KrlScript> make_openkc_script(const KrlScriptConfig& config) {
  return std::make_unique<OpenKc>(config);
}

}  // namespace colift::sim_hal
