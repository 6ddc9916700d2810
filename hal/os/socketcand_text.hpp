#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "hal/can_bus.hpp"

namespace colift::hal {

/// One message of a socketcand gateway, as its protocol writes it: "< word ... >".
struct GatewayMessage {
  enum class Kind {
    None,     ///< No complete message yet.
    Hi,       ///< Greeting of a new connection.
    Ok,       ///< The command was carried out.
    Frame,    ///< A data frame with an 11-bit identifier, in `frame`.
    Error,    ///< An error frame of the far bus; `error_class` as in linux/can/error.h.
    Refused,  ///< A complaint in words, in `words`.
    Other,    ///< Well formed, but nothing that is used here: extended and remote frames, echo, statistics.
    Broken,   ///< Not a message of the protocol, or one that is too long.
  };
  Kind kind = Kind::None;
  CanFrame frame;  ///< Without time of arrival: the gateway's clock is another machine's.
  std::uint32_t error_class = 0;
  std::string_view words;  ///< Valid until the next call.
};

/// Cuts a stream of bytes into messages: any pieces, any bytes, newlines and blanks between messages or none.
/// Never allocates. What is not inside "<" and ">" is skipped; a message of 128 bytes or more is Broken.
class GatewayParser {
 public:
  /// Room to read into; tell with filled() how much came. Never empty after next() returned None.
  [[nodiscard]] std::span<char> room() noexcept;
  void filled(std::size_t bytes) noexcept { size_ += bytes; }
  [[nodiscard]] GatewayMessage next() noexcept;
  void clear() noexcept { begin_ = size_ = 0; }

 private:
  std::array<char, 4096> buffer_{};
  std::size_t begin_ = 0, size_ = 0;  ///< What is not looked at yet: [begin_, size_).
  bool skipping_ = false;             ///< Within a message that is too long.
};

/// What is between "<" and ">", without them.
[[nodiscard]] GatewayMessage parse_gateway_message(std::string_view inside) noexcept;

/// "< send 123 2 AA BB >". Returns the used part of `into`.
[[nodiscard]] std::string_view write_gateway_send(const CanFrame& frame, std::array<char, 64>& into) noexcept;

}  // namespace colift::hal
