#pragma once

#include <memory>
#include <string_view>

#include "hal/drivers/kuka_fri/wire/fri_packets.hpp"

namespace colift::hal {

/// What the PC wants of the KRL program.
enum class Ask : std::uint8_t { Nothing, Start, Stop, Close };

/// What is known of the KRL program.
enum class ScriptSign : std::uint8_t {
  Unknown,    ///< Nothing was asked for.
  Silent,     ///< It was asked and does not answer, or it is another program.
  Halted,     ///< It answered before and stands still.
  Working,    ///< It has taken the request, or may still do so.
  Done,       ///< It says that it has done what was asked.
  Refused,    ///< It says that it will not; `code` is its reason.
  Restarted,  ///< It was begun anew and knows nothing of the request.
  Ended,      ///< It has closed and ended.
  Lost,       ///< Command mode ended by itself on the way to what was asked.
};

/// The client's side of one KRL program: one step for each measurement, in the packets' time. The tables are
/// in docs/krl-hand-shakes.md. Real-time safe.
class HandShake {
 public:
  explicit HandShake(std::int32_t strategy) : strategy_(strategy) {}
  virtual ~HandShake() = default;
  /// `since_s`: packets' time since the last step; `timeout_s`: for the program's answer.
  virtual void step(Ask ask, const FriMeasurement& m, double since_s, double timeout_s,
                    KrlChannels& out) noexcept = 0;
  [[nodiscard]] ScriptSign sign() const noexcept { return sign_; }
  [[nodiscard]] std::int32_t code() const noexcept { return code_; }
  /// The program has to be started in position control first, and stopped, before it takes a strategy: until
  /// then the flags are those of position control.
  [[nodiscard]] bool detour() const noexcept { return detour_; }
  /// Another strategy, from the next start on.
  void set_strategy(std::int32_t strategy) noexcept { strategy_ = strategy; }

 protected:
  std::int32_t strategy_;
  ScriptSign sign_ = ScriptSign::Unknown;
  std::int32_t code_ = 0;
  bool detour_ = false;
};

/// The program takes the strategy that it is told; others keep the one that they were written for.
[[nodiscard]] bool script_sets_strategy(std::string_view script);

/// `strategy`: 10, 20 or 30. `script` as in FriConfig; an unknown name is as "none".
[[nodiscard]] std::unique_ptr<HandShake> make_hand_shake(std::string_view script, std::int32_t strategy);

}  // namespace colift::hal
