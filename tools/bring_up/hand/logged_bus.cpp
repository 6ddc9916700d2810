#include "tools/bring_up/hand/logged_bus.hpp"

#include <cstdio>
#include <utility>

#include "hal/drivers/barrett_can/make_barrett_hand.hpp"
#include "hal/os/make_can_bus.hpp"

namespace colift::tools {

hal::Result<LoggedBus> make_bus(const hal::BarrettHandConfig& config, const hal::Clock& clock,
                                bool announced) {
  auto bus = hal::make_can_bus(config.can);
  if (!bus) return tl::unexpected(bus.error());
  auto log = hal::make_bus_log(config);
  if (!log) return tl::unexpected(log.error());
  if (!*log) return LoggedBus{nullptr, std::move(*bus)};
  if (announced) std::fprintf(stderr, "the bus is logged in %s\n", (*log)->file().c_str());
  auto logged = std::make_unique<hal::LoggedCanBus>(std::move(*bus), **log, clock);
  return LoggedBus{std::move(*log), std::move(logged)};
}

}  // namespace colift::tools
