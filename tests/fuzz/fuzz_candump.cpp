// Any bytes as a log of candump: refused with a line, or frames that are written and read again as they are.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "hal/can_log/candump.hpp"
#include "tests/fuzz/demand.hpp"

using colift::fuzz::demand;
using namespace colift::hal;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  const auto log = parse_candump(input, "log");
  if (!log) {
    demand(log.error().where.starts_with("log:") && !log.error().detail.empty());
    return 0;
  }
  std::string again;
  Timestamp last{0};
  for (const CandumpFrame& f : log->frames) {
    demand(f.frame.id <= 0x7ff && f.frame.length <= 8 && f.frame.arrived_at >= last && f.line > 0);
    last = f.frame.arrived_at;
    std::array<char, 96> line{};
    again.append(line.data(), write_candump(line, log->interface, f.frame, f.frame.arrived_at, f.direction));
  }
  const auto second = parse_candump(again, "again");
  demand(second && second->frames.size() == log->frames.size());
  for (std::size_t i = 0; i < log->frames.size(); ++i)
    demand(second->frames[i].frame == log->frames[i].frame &&
           second->frames[i].frame.arrived_at == log->frames[i].frame.arrived_at &&
           second->frames[i].direction == log->frames[i].direction);
  return 0;
}
