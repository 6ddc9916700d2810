#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim_hal/emulator/krc/krc_wire.hpp"
#include "sim_hal/emulator/krc/plant/krc_motion.hpp"

namespace colift::sim_hal {

/// What a KRL program sees of its controller.
class KrlHost {
 public:
  virtual ~KrlHost() = default;
  [[nodiscard]] virtual double now_s() const = 0;
  [[nodiscard]] virtual FriState fri_state() const = 0;
  [[nodiscard]] virtual FriQuality fri_quality() const = 0;
  [[nodiscard]] virtual const KrlChannels& from_pc() const = 0;  ///< $FRI_FRM_*
  [[nodiscard]] virtual KrlChannels& to_pc() = 0;                ///< $FRI_TO_*
  [[nodiscard]] virtual Vector6 tool_wrench() const = 0;         ///< $TORQUE_TCP_EST, usual order.

  /// A small motion to where the arm stands: opens the brakes, switches the drives on, takes FRI's offset
  /// into the program's position.
  virtual void ptp_here() = 0;
  virtual void set_strategy(FriControl control, const KrlStiffness& stiffness) = 0;
  virtual void fri_open(int ms) = 0;
  /// Runs until start_pending() is false; then the state tells how it went.
  virtual void fri_start(double safety_limits) = 0;
  [[nodiscard]] virtual bool start_pending() const = 0;
  virtual void fri_stop(const std::string& reason) = 0;
  virtual void fri_close(const std::string& reason) = 0;
  [[nodiscard]] virtual int cycle_ms() const = 0;
  virtual void say(const std::string& text) = 0;  ///< A message on the panel.
};

struct KrlScriptConfig {
  std::optional<FriControl> strategy;  ///< In place of the program's own first one.
  double linger_s = 1.5;               ///< In monitor mode between a close and friClose.
  double runs_s = 10.0;                ///< How long the vendor's program commands before it ends the session.
};

/// A KRL program that talks with a client. Which programs there are: docs/krl-hand-shakes.md.
class KrlScript {
 public:
  virtual ~KrlScript() = default;
  [[nodiscard]] virtual double period_s() const { return 0.05; }
  /// From the top, as after a restart at the panel.
  virtual void begin(KrlHost& krc) = 0;
  virtual void poll(KrlHost& krc) = 0;
  [[nodiscard]] virtual bool ended() const = 0;
};

[[nodiscard]] const std::vector<std::string_view>& krl_script_names();
/// Null for a name that is none of them.
[[nodiscard]] std::unique_ptr<KrlScript> make_krl_script(std::string_view name,
                                                         const KrlScriptConfig& config);

}  // namespace colift::sim_hal
