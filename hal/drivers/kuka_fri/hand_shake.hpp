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
};

/// The client's side of one KRL program: one step for each measurement, in the packets' time. The tables are
/// in docs/krl-hand-shakes.md. Real-time safe.
class HandShake {
 public:
  virtual ~HandShake() = default;
  /// `since_s`: packets' time since the last step; `timeout_s`: for the program's answer.
  virtual void step(Ask ask, const FriMeasurement& m, double since_s, double timeout_s,
                    KrlChannels& out) noexcept = 0;
  [[nodiscard]] ScriptSign sign() const noexcept { return sign_; }
  [[nodiscard]] std::int32_t code() const noexcept { return code_; }

 protected:
  ScriptSign sign_ = ScriptSign::Unknown;
  std::int32_t code_ = 0;
};

/// `strategy`: 10, 20 or 30. `script` as in FriConfig; an unknown name is as "none".
[[nodiscard]] std::unique_ptr<HandShake> make_hand_shake(std::string_view script, std::int32_t strategy);

}  // namespace colift::hal
