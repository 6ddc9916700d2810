#include "tools/doctor/doctor_can.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace colift::tools {
namespace {

namespace fs = std::filesystem;
using Verdict = DoctorRow::Verdict;

constexpr int kArpCan = 280;  // ARPHRD_CAN
constexpr std::uint32_t kBitRate = 1'000'000;
constexpr std::uint16_t kWarning = 96, kPassive = 128;  // error counters, ISO 11898

std::string up_line(const std::string& name) {
  return fmt::format("sudo ip link set {} up type can bitrate 1000000 sample-point 0.75 restart-ms 100",
                     name);
}
std::string anew_line(const std::string& name) {
  return fmt::format("sudo ip link set {} down; {}", name, up_line(name));
}

const char* word(hal::CanHealth::State state) {
  using enum hal::CanHealth::State;
  switch (state) {
    case Closed:
    case Down:
      return "stopped";
    case Active:
      return "error-active";
    case Warning:
      return "error-warning";
    case Passive:
      return "error-passive";
    case BusOff:
      return "bus-off";
  }
  return "unknown";
}

DoctorRow interface_row(const std::string& name, const hal::CanLink& link) {
  DoctorRow row{fmt::format("CAN {}", name), ""};
  const bool real = link.kind != "vcan" && link.kind != "vxcan";
  row.found = fmt::format("{}{}", link.up ? "up" : "down", real ? "" : ", virtual");
  if (link.bitrate && *link.bitrate > 0) row.found += fmt::format(", {} bit/s", *link.bitrate);
  if (link.sample_point && link.bitrate && *link.bitrate > 0)
    row.found += fmt::format(" sampled at {:.1f} %", 100 * *link.sample_point);
  if (link.state) row.found += fmt::format(", {}", word(*link.state));
  if (link.send_errors && link.receive_errors)
    row.found += fmt::format(", error counters send {} receive {}", *link.send_errors, *link.receive_errors);
  if (real && link.restart_ms) row.found += fmt::format(", restart after {} ms", *link.restart_ms);

  const auto judge = [&](Verdict verdict, std::string why, std::string repair) {
    if (!why.empty()) row.found += fmt::format(": {}", why);
    row.verdict = verdict;
    row.repair = std::move(repair);
    return row;
  };
  if (!link.up)
    return judge(Verdict::Bad, "", real ? up_line(name) : fmt::format("sudo ip link set {} up", name));
  if (!real) return row;
  if (link.bitrate && *link.bitrate != kBitRate)
    return judge(Verdict::Bad, "the hand speaks 1000000 bit/s", anew_line(name));
  if (link.state == hal::CanHealth::State::BusOff)
    return judge(
        Verdict::Bad, "no node acknowledges: hand without supply, no termination, or another bit rate",
        fmt::format("switch the hand's supply and its CAN termination on; then {}", anew_line(name)));
  if (!link.running) return judge(Verdict::Bad, "no carrier: adapter unplugged or bus-off", anew_line(name));
  const std::uint16_t worst = std::max(link.send_errors.value_or(0), link.receive_errors.value_or(0));
  if (worst >= kPassive || link.state == hal::CanHealth::State::Passive)
    return judge(Verdict::Warn, "most frames fail",
                 "120 ohm at both ends of the bus, CAN high and low not swapped, the hand's supply on");
  if (worst >= kWarning || link.state == hal::CanHealth::State::Warning)
    return judge(Verdict::Warn, "many frames fail", "look at termination, cable and connectors");
  if (!link.restart_ms || *link.restart_ms == 0)
    return judge(Verdict::Warn, "after a bus-off it stays off until a person comes", anew_line(name));
  return row;
}

bool in_modules(const fs::path& root, const std::string& release, const char* file,
                const std::string& module) {
  const auto text = read_small(root / "lib/modules" / release / file);
  return text && text->find(fmt::format("/{}.ko", module)) != std::string::npos;
}

DoctorRow support(const fs::path& root) {
  const std::string release = read_small(root / "proc/sys/kernel/osrelease").value_or("");
  std::string loaded;
  bool raw = false;
  const std::string modules = fmt::format("\n{}", read_small(root / "proc/modules").value_or(""));
  for (const char* name : {"can_raw", "can_dev", "vcan", "slcan", "peak_usb", "kvaser_usb", "gs_usb"})
    if (modules.find(fmt::format("\n{} ", name)) != std::string::npos) {
      loaded += fmt::format("{}{}", loaded.empty() ? "" : ", ", name);
      raw = raw || std::string_view(name) == "can_raw";
    }
  std::error_code none;
  raw = raw || fs::exists(root / "proc/net/can", none);
  if (raw)
    return {"CAN in the kernel",
            loaded.empty() ? std::string("built in") : fmt::format("loaded: {}", loaded)};
  const bool there = fs::exists(root / "lib/modules" / release / "kernel/net/can/can-raw.ko", none) ||
                     fs::exists(root / "lib/modules" / release / "kernel/net/can/can-raw.ko.xz", none) ||
                     in_modules(root, release, "modules.builtin", "can-raw");
  if (there) return {"CAN in the kernel", "there, not loaded"};
  return {"CAN in the kernel",
          fmt::format("{} has no SocketCAN: a hand can be reached through a gateway only", release),
          Verdict::Warn,
          "a kernel with CAN (sudo apt install linux-image-amd64), or can: socketcand:HOST:29536/can0 in the "
          "file behind "
          "--robot"};
}

}  // namespace

DoctorRows can_rows(const fs::path& root, const std::string& hand_bus, const AskCanLink& ask) {
  DoctorRows rows{support(root)};
  constexpr std::string_view kSocketCan = "socketcan:";
  const bool local = hand_bus.rfind(kSocketCan, 0) == 0;
  const std::string wanted = local ? hand_bus.substr(kSocketCan.size()) : "";
  bool any = false, wanted_seen = false;
  for (const std::string& name : names_in(root / "sys/class/net")) {
    if (read_number(root / "sys/class/net" / name / "type") != kArpCan) continue;
    any = true;
    wanted_seen = wanted_seen || name == wanted;
    const auto link = ask(name);
    if (!link) {
      rows.push_back({fmt::format("CAN {}", name), link.error().text(), Verdict::Warn,
                      fmt::format("ip -details link show {}", name)});
      continue;
    }
    DoctorRow row = interface_row(name, *link);
    if (local && name != wanted && row.verdict == Verdict::Bad)
      row.verdict = Verdict::Warn;  // not the hand's
    rows.push_back(std::move(row));
  }
  if (!local)
    rows.push_back(
        {"hand's bus",
         fmt::format("{}: a gateway; \"colift hal hand state\" says whether it answers", hand_bus)});
  else if (!any)
    rows.push_back(
        {"CAN", "no CAN interface", Verdict::Warn,
         fmt::format("plug the adapter in (sudo modprobe peak_usb, kvaser_usb or gs_usb if it stays unseen); "
                     "{}    # for trials without a hand: sudo modprobe vcan; sudo ip link add {} type vcan; "
                     "sudo ip link set {} up",
                     up_line(wanted), wanted, wanted)});
  else if (!wanted_seen)
    rows.push_back({"hand's bus", fmt::format("there is no interface {}", wanted), Verdict::Bad,
                    "ip -br link show type can    # name one of these in can: of the file behind --robot"});
  return rows;
}

}  // namespace colift::tools
