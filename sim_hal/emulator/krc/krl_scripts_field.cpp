// Programs that are in use elsewhere, as their public sources and clients show them. Index 0 is KRL's 1.

#include <fmt/format.h>

#include "sim_hal/emulator/krc/krl_scripts.hpp"

namespace colift::sim_hal {
namespace {

std::optional<FriControl> control_of(std::int32_t strategy) {
  if (strategy == 10) return FriControl::Position;
  if (strategy == 20) return FriControl::CartesianImpedance;
  if (strategy == 30) return FriControl::JointImpedance;
  return std::nullopt;
}

constexpr double kPanelMessage_s = 0.3;  // what a message costs a program

/// What all of them share: they start in the same way, pause for messages, and close after a while.
class FieldScript : public KrlScript {
 public:
  explicit FieldScript(const KrlScriptConfig& config) : config_(config) {}

  void begin(KrlHost& krc) override {
    ended_ = starting_ = false;
    start_at_s_.reset();
    close_at_s_.reset();
    wait_until_s_ = 0.0;
    krc.to_pc() = {};
    krc.ptp_here();
    krc.set_strategy(config_.strategy.value_or(first_strategy()), stiffness());
    krc.fri_open(krc.cycle_ms());
    opened(krc);
  }

  void poll(KrlHost& krc) override {
    if (ended_) return;
    if (close_at_s_) {
      if (krc.now_s() < *close_at_s_) return;
      krc.fri_close(reason_);
      ended_ = true;
      return;
    }
    if (start_at_s_) {
      if (krc.now_s() < *start_at_s_) return;
      start_at_s_.reset();
      krc.fri_start(1.0);
      starting_ = true;
      return;
    }
    if (starting_) {
      if (krc.start_pending()) return;
      starting_ = false;
      started(krc);
      return;
    }
    if (krc.now_s() < wait_until_s_) return;
    round(krc);
  }

  [[nodiscard]] bool ended() const override { return ended_; }

 protected:
  [[nodiscard]] virtual FriControl first_strategy() const = 0;
  [[nodiscard]] virtual KrlStiffness stiffness() const { return {}; }
  virtual void opened(KrlHost&) {}
  virtual void started(KrlHost&) = 0;
  virtual void round(KrlHost&) = 0;

  /// Commits a strategy; friStart comes one round later, so that `control` is on the wire before it. None of
  /// these programs moves before it: where FRI left the arm stays FRI's offset.
  void start(KrlHost& krc, FriControl control) {
    krc.set_strategy(control, stiffness());
    start_at_s_ = krc.now_s() + period_s();
  }
  void pause(KrlHost& krc) { wait_until_s_ = krc.now_s() + kPanelMessage_s; }
  void close(KrlHost& krc, std::string reason) {
    reason_ = std::move(reason);
    if (krc.fri_state() == FriState::Command) krc.fri_stop(reason_);
    close_at_s_ = krc.now_s() + config_.linger_s;
  }
  [[nodiscard]] const KrlScriptConfig& config() const { return config_; }

 private:
  KrlScriptConfig config_;
  bool ended_ = false, starting_ = false;
  std::optional<double> start_at_s_, close_at_s_;
  double wait_until_s_ = 0.0;
  std::string reason_;
};

/// FRIControl.src of Stanford's FRI library.
class Stanford final : public FieldScript {
 public:
  using FieldScript::FieldScript;

 protected:
  [[nodiscard]] FriControl first_strategy() const override { return FriControl::Position; }
  void opened(KrlHost& krc) override {
    // a close request that still stands there from the run before would end this one at once
    krc.to_pc().integer[14] = krc.from_pc().integer[15] == 30 ? 40 : 30;
    krc.to_pc().integer[15] = 10;
  }
  void started(KrlHost& krc) override {
    krc.to_pc().integer[15] = 20;  // even when it did not come to command mode
    pause(krc);
  }
  void round(KrlHost& krc) override {
    const std::int32_t request = krc.from_pc().integer[15], told = krc.to_pc().integer[15];
    if (request == krc.to_pc().integer[14]) {
      close(krc, "the client asked for the end");
      krc.to_pc().integer[15] = 30;
    } else if (request == 10 && told != 20) {
      const auto control = control_of(krc.from_pc().integer[14]);
      if (!control) {
        if (complained_ != krc.from_pc().integer[14])
          krc.say(fmt::format("no start: FRM_INT[15] holds {}, expected 10, 20 or 30",
                              krc.from_pc().integer[14]));
        complained_ = krc.from_pc().integer[14];
        return;
      }
      start(krc, *control);
    } else if (request == 20 && told != 10) {
      krc.fri_stop("the client asked for a stop");
      krc.to_pc().integer[15] = 10;
      pause(krc);
    }
  }

 private:
  std::optional<std::int32_t> complained_;
};

/// ros_control.src of CentroEPiaggio. It moves at its beginning only, waits where it is for quality and for
/// command mode, however long that takes, and never ends by itself.
class Cep final : public KrlScript {
 public:
  explicit Cep(const KrlScriptConfig& config) : config_(config) {}

  void begin(KrlHost& krc) override {
    step_ = Step::Waits;
    wait_until_s_ = 0.0;
    krc.to_pc() = {};
    krc.to_pc().integer[1] = kBegun;
    krc.ptp_here();
    krc.set_strategy(config_.strategy.value_or(FriControl::Position), {});
    krc.fri_open(krc.cycle_ms());
    message(krc);
  }

  void poll(KrlHost& krc) override {
    if (krc.now_s() < wait_until_s_) return;
    std::int32_t& told = krc.to_pc().integer[1];
    const std::int32_t request = krc.from_pc().integer[1];
    switch (step_) {
      case Step::Waits:
        if (request == 0 && told == kStarted) {
          step_ = Step::Stops;
          message(krc);
        } else if (request == 1 && told != kStarted) {
          // the first start keeps what was set at the beginning, whatever is asked for
          if (const auto control = control_of(krc.from_pc().integer[0]); control && told != kBegun)
            krc.set_strategy(*control, {});
          step_ = Step::Quality;
          message(krc);
        }
        return;
      case Step::Stops:
        krc.fri_stop("the client asked for a stop");
        told = kStopped;
        step_ = Step::Waits;
        return message(krc);
      case Step::Quality:
        if (krc.fri_quality() != FriQuality::Perfect || request != 1) return;
        krc.fri_start(1.0);
        step_ = Step::Command;
        return;
      case Step::Command:
        if (krc.fri_state() != FriState::Command) return;
        told = kStarted;
        step_ = Step::Waits;
        return message(krc);
    }
  }

  [[nodiscard]] bool ended() const override { return false; }

 private:
  enum class Step { Waits, Stops, Quality, Command };
  static constexpr std::int32_t kStopped = 0, kStarted = 1, kBegun = 10;
  static constexpr double kMessage_s = 0.5;

  void message(KrlHost& krc) { wait_until_s_ = krc.now_s() + kMessage_s; }

  KrlScriptConfig config_;
  Step step_ = Step::Waits;
  double wait_until_s_ = 0.0;
};

/// fri_hand.src of TUM, fri_start.src of RCPRG.
class Tum final : public FieldScript {
 public:
  using FieldScript::FieldScript;

 protected:
  [[nodiscard]] FriControl first_strategy() const override { return FriControl::JointImpedance; }
  [[nodiscard]] KrlStiffness stiffness() const override {
    KrlStiffness s;
    s.axis_nm_rad = 40.0;
    return s;
  }
  void opened(KrlHost& krc) override { next_motion_s_ = krc.now_s() + kMotion_s; }
  void started(KrlHost&) override {}
  void round(KrlHost& krc) override {
    // a motion to where it is commanded keeps the brakes from closing
    if (krc.now_s() >= next_motion_s_) {
      krc.ptp_here();
      next_motion_s_ = krc.now_s() + kMotion_s;
    }
    KrlChannels& to = krc.to_pc();
    const bool pending = (krc.from_pc().boolean & 1U) != 0;
    if ((to.boolean & 1U) != 0) {
      if (!pending) to.boolean = static_cast<std::uint16_t>(to.boolean & ~1U);
      return;
    }
    if (!pending) return;
    const std::int32_t request = krc.from_pc().integer[0];
    acknowledge(krc);
    if (request == 1) {
      const Vector6 wrench = krc.tool_wrench();
      if (wrench.head<3>().norm() > 8.0 || wrench.tail<3>().norm() > 8.0) {
        krc.say(fmt::format("no start: {:.1f} N and {:.1f} N m at the tool (limits 8 N, 8 N m)",
                            wrench.head<3>().norm(), wrench.tail<3>().norm()));
      } else if (krc.fri_state() != FriState::Command) {
        start(krc, config().strategy.value_or(first_strategy()));
      }
    } else if (request == 2) {
      krc.fri_stop("the client asked for monitor mode");
    } else if (request == 3) {
      const std::int32_t ms = krc.from_pc().integer[1];
      krc.fri_stop("the client asked for a new cycle");
      krc.fri_close("the client asked for a new cycle");
      krc.fri_open(ms >= 1 && ms <= 100 ? ms : krc.cycle_ms());
    } else if (request == 10) {
      krc.ptp_here();
    } else {
      krc.say(fmt::format("no such request: FRM_INT[1] holds {}", request));
    }
  }

 private:
  static void acknowledge(KrlHost& krc) {
    krc.to_pc().boolean = static_cast<std::uint16_t>(krc.to_pc().boolean | 1U);
  }
  static constexpr double kMotion_s = 3.0;
  double next_motion_s_ = 0.0;
};

/// What the sample of the FRI SDK expects of its program.
class Vendor final : public FieldScript {
 public:
  using FieldScript::FieldScript;

 protected:
  [[nodiscard]] FriControl first_strategy() const override { return FriControl::Position; }
  void started(KrlHost& krc) override {
    if (krc.fri_state() == FriState::Command)
      ends_at_s_ = krc.now_s() + config().runs_s;
    else
      pause(krc);  // the message says why
  }
  void round(KrlHost& krc) override {
    krc.to_pc().real[1] = static_cast<float>(krc.now_s());  // comes back in FRM_REA[1]
    if (ends_at_s_) {
      if (krc.fri_state() == FriState::Command && krc.now_s() < *ends_at_s_) return;
      ends_at_s_.reset();
      close(krc, "the program ended the session");
      krc.to_pc().integer[0] = -1;
    } else if (krc.from_pc().integer[0] == 10 && krc.fri_state() == FriState::Monitor) {
      start(krc, config().strategy.value_or(first_strategy()));
    }
  }

 private:
  std::optional<double> ends_at_s_;
};

}  // namespace

std::unique_ptr<KrlScript> make_stanford_script(const KrlScriptConfig& config) {
  return std::make_unique<Stanford>(config);
}
std::unique_ptr<KrlScript> make_cep_script(const KrlScriptConfig& config) {
  return std::make_unique<Cep>(config);
}
std::unique_ptr<KrlScript> make_tum_script(const KrlScriptConfig& config) {
  return std::make_unique<Tum>(config);
}
std::unique_ptr<KrlScript> make_vendor_script(const KrlScriptConfig& config) {
  return std::make_unique<Vendor>(config);
}

}  // namespace colift::sim_hal
