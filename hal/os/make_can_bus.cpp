#include "hal/os/make_can_bus.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string>

#include "hal/os/socketcan_bus.hpp"
#include "hal/os/socketcand_bus.hpp"

namespace colift::hal {
namespace {

constexpr std::size_t kLongestInterface = 15;  // IFNAMSIZ of Linux, without its end

bool is_interface(std::string_view name) {
  return !name.empty() && name.size() <= kLongestInterface && name != "." && name != ".." &&
         std::all_of(name.begin(), name.end(), [](char c) {
           return c > ' ' && c < 127 && c != '/' && c != ':' && c != '<' && c != '>';
         });
}

}  // namespace

Result<std::unique_ptr<CanBus>> make_can_bus(std::string_view text, const std::vector<CanFilter>& filters) {
  const auto bad = [&](std::string_view why) {
    return failure(ErrorCode::BadConfig, "can",
                   fmt::format("\"{}\": {}; expected socketcan:INTERFACE, as socketcan:can0, or "
                               "socketcand:HOST:PORT/INTERFACE, as socketcand:127.0.0.1:29536/can0",
                               text, why));
  };
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) return bad("no kind of bus");
  const std::string_view kind = text.substr(0, colon), rest = text.substr(colon + 1);
  if (kind == "socketcan") {
    if (!is_interface(rest)) return bad(fmt::format("\"{}\" is no name of an interface", rest));
    return make_socketcan_bus(std::string(rest), filters);
  }
  if (kind != "socketcand") return bad(fmt::format("\"{}\" is no kind of bus", kind));
  const std::size_t slash = rest.find('/');
  if (slash == std::string_view::npos) return bad("no interface behind a slash");
  const std::string_view address = rest.substr(0, slash), bus = rest.substr(slash + 1);
  if (!is_interface(bus)) return bad(fmt::format("\"{}\" is no name of an interface", bus));
  const std::size_t last = address.rfind(':');
  if (last == std::string_view::npos) return bad("no port");
  std::string_view host = address.substr(0, last);
  const std::string_view port_text = address.substr(last + 1);
  std::uint16_t port = 0;
  const auto [end, error] = std::from_chars(port_text.data(), port_text.data() + port_text.size(), port);
  if (error != std::errc{} || end != port_text.data() + port_text.size() || port == 0)
    return bad(fmt::format("\"{}\" is no port (1 to 65535)", port_text));
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  if (host.empty()) return bad("no host");
  return make_socketcand_bus(std::string(host), port, std::string(bus), filters);
}

}  // namespace colift::hal
