// Any bytes in any pieces as the stream of a socketcand gateway: frames that come out are 11-bit data frames,
// and the pieces make no difference.

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>

#include "hal/os/make_can_bus.hpp"
#include "hal/os/socketcand_text.hpp"
#include "tests/fuzz/demand.hpp"

namespace {

using colift::fuzz::demand;
using namespace colift::hal;
using Kind = GatewayMessage::Kind;

// all messages, as text
std::string read_all(std::string_view stream, std::size_t piece) {
  GatewayParser parser;
  std::string all;
  while (!stream.empty()) {
    const auto room = parser.room();
    demand(room.size() > 256);
    const std::size_t n = std::min({piece, stream.size(), room.size()});
    std::copy_n(stream.begin(), n, room.begin());
    parser.filled(n);
    stream.remove_prefix(n);
    for (;;) {
      const GatewayMessage message = parser.next();
      if (message.kind == Kind::None) break;
      all += static_cast<char>('a' + static_cast<int>(message.kind));
      if (message.kind == Kind::Frame) {
        demand(message.frame.id <= 0x7ff && message.frame.length <= 8);
        std::array<char, 64> text{};
        all += write_gateway_send(message.frame, text);
      }
      if (message.kind == Kind::Refused) all += message.words;
    }
  }
  return all;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  const std::string whole = read_all(input, 2048);
  demand(read_all(input, 1) == whole);
  demand(read_all(input, 7) == whole);
  (void)make_can_bus(input);
  return 0;
}
