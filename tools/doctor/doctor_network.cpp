#include <fmt/format.h>

#include <charconv>
#include <sstream>

#include "tools/doctor/doctor_row.hpp"

namespace colift::tools {
namespace {

namespace fs = std::filesystem;
using Verdict = DoctorRow::Verdict;

constexpr long long kMinBuffer = 64 * 1024;  // some 70 datagrams of the KRC
constexpr int kEthernet = 1;

/// Local ports in the text of /proc/net/udp: lines "  12: 0100007F:C312 00000000:0000 ...".
bool port_in_use(const std::string& table, int port) {
  std::istringstream lines(table);
  std::string line;
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    std::string slot, local;
    if (!(words >> slot >> local)) continue;
    const std::size_t colon = local.rfind(':');
    if (colon == std::string::npos) continue;
    int found = -1;
    const auto done = std::from_chars(local.data() + colon + 1, local.data() + local.size(), found, 16);
    if (done.ec == std::errc{} && done.ptr == local.data() + local.size() && found == port) return true;
  }
  return false;
}

DoctorRow udp_port(const fs::path& root, int port) {
  const std::string what = fmt::format("UDP port {}", port);
  const auto v4 = read_small(root / "proc/net/udp");
  if (!v4) return {what, "not reported by the system", Verdict::Warn, "ss -lun"};
  if (port_in_use(*v4, port) || port_in_use(read_small(root / "proc/net/udp6").value_or(""), port))
    return {what, "in use: another client of the arm, or a second instance", Verdict::Bad,
            fmt::format("sudo ss -lunp sport = :{}    # says who has it; end that one", port)};
  return {what, "free"};
}

DoctorRow receive_buffer(const fs::path& root) {
  const auto bytes = read_number(root / "proc/sys/net/core/rmem_default");
  if (!bytes) return {"UDP receive buffer", "not reported by the system"};
  const std::string found = fmt::format("{} KiB, {} datagrams of the KRC", *bytes / 1024, *bytes / 916);
  if (*bytes >= kMinBuffer) return {"UDP receive buffer", found};
  return {"UDP receive buffer", found, Verdict::Warn, "sudo sysctl -w net.core.rmem_default=212992"};
}

/// The interface of the default route in the text of /proc/net/route.
std::string default_route(const fs::path& root) {
  std::istringstream lines(read_small(root / "proc/net/route").value_or(""));
  std::string line;
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    std::string interface, destination;
    if (words >> interface >> destination && destination == "00000000") return interface;
  }
  return "";
}

DoctorRows cards(const fs::path& root) {
  const fs::path net = root / "sys/class/net";
  const std::string way_out = default_route(root);
  DoctorRows rows;
  int free_with_link = 0;
  for (const std::string& name : names_in(net)) {
    const fs::path card = net / name;
    std::error_code none;
    const bool wired = read_number(card / "type") == kEthernet && fs::exists(card / "device", none) &&
                       !fs::exists(card / "wireless", none) && !fs::exists(card / "phy80211", none);
    if (!wired) continue;
    const bool link = read_number(card / "carrier") == 1;
    const long long speed = read_number(card / "speed").value_or(-1);
    std::string found =
        link ? "link" : fmt::format("no link ({})", read_small(card / "operstate").value_or("?"));
    if (link && speed > 0) found += fmt::format(", {} Mbit/s", speed);
    if (name == way_out) found += ", carries everything else too (default route)";
    if (link && name != way_out) ++free_with_link;
    rows.push_back({fmt::format("network card {}", name), found});
  }
  if (free_with_link > 0) return rows;
  const std::string advice =
      "a card and a cable of its own from the KRC to this machine, then: sudo ip addr add 192.168.0.1/24 dev "
      "CARD; sudo "
      "ip link set CARD up    # the address that friSetup names";
  if (rows.empty())
    rows.push_back(
        {"network card", "no wired one: nothing that a KRC could be plugged into", Verdict::Warn, advice});
  else
    rows.push_back(
        {"network for the KRC", "no wired card with a link is free for it", Verdict::Warn, advice});
  return rows;
}

}  // namespace

DoctorRows network_rows(const fs::path& root, int port) {
  DoctorRows rows{udp_port(root, port), receive_buffer(root)};
  for (DoctorRow& row : cards(root)) rows.push_back(std::move(row));
  return rows;
}

}  // namespace colift::tools
