// On real kernel interfaces: run in a machine that has vcan0 (hidden elsewhere: unit_hal_os "[vcan]").
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <string>

#include "hal/os/can_link.hpp"
#include "hal/os/socketcan_bus.hpp"

using namespace colift::hal;
using namespace std::chrono_literals;
using Catch::Matchers::Contains;

namespace {

CanFrame frame(std::uint16_t id, std::uint8_t first) {
  CanFrame f;
  f.id = id;
  f.length = 2;
  f.data[0] = first;
  return f;
}

/// A plain socket beside the bus: writes what the bus class never would.
class RawSocket {
 public:
  explicit RawSocket(const char* interface) : fd_(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW)) {
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(::if_nametoindex(interface));
    REQUIRE(::bind(fd_, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0);
  }
  ~RawSocket() { ::close(fd_); }
  RawSocket(const RawSocket&) = delete;
  RawSocket& operator=(const RawSocket&) = delete;
  void write(std::uint32_t id, std::array<std::uint8_t, 8> data = {}) const {
    can_frame raw{};
    raw.can_id = id;
    raw.can_dlc = 8;
    std::copy(data.begin(), data.end(), raw.data);
    REQUIRE(::write(fd_, &raw, sizeof raw) == sizeof raw);
  }

 private:
  int fd_;
};

void set_up(const std::string& interface, bool up) {
  const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ifreq request{};
  interface.copy(request.ifr_name, IFNAMSIZ - 1);
  REQUIRE(::ioctl(fd, SIOCGIFFLAGS, &request) == 0);
  request.ifr_flags = static_cast<short>(up ? request.ifr_flags | IFF_UP : request.ifr_flags & ~IFF_UP);
  REQUIRE(::ioctl(fd, SIOCSIFFLAGS, &request) == 0);
  ::close(fd);
}

}  // namespace

TEST_CASE("frames pass between two programs on one interface, stamped, and only those that are wanted",
          "[.][vcan]") {
  const auto host = make_socketcan_bus("vcan0", {{0x560, 0x7e0}}), hand = make_socketcan_bus("vcan0");
  REQUIRE(host->open());
  REQUIRE(hand->open());
  const SteadyClock clock;
  const Timestamp before = clock.now();
  REQUIRE(hand->send(frame(0x123, 1)) == CanBus::Sent::Yes);
  REQUIRE(hand->send(frame(0x566, 2)) == CanBus::Sent::Yes);
  RawSocket other("vcan0");
  other.write(0x566 | CAN_RTR_FLAG);
  other.write(0x566 | CAN_EFF_FLAG);
  REQUIRE(hand->send(frame(0x563, 3)) == CanBus::Sent::Yes);
  CanFrame got;
  REQUIRE(host->receive(got, 1s) == CanBus::Received::Frame);
  CHECK(got == frame(0x566, 2));
  CHECK(got.arrived_at >= before - 1ms);
  CHECK(got.arrived_at <= clock.now());
  REQUIRE(host->receive(got, 1s) == CanBus::Received::Frame);
  CHECK(got.id == 0x563);
  CHECK(host->receive(got, 20ms) == CanBus::Received::Nothing);  // its own frames do not come back either
  CHECK(host->health().received == 2);
  CHECK(host->health().state == CanHealth::State::Active);
}

TEST_CASE("error frames of the kernel become states of the bus", "[.][vcan]") {
  const auto bus = make_socketcan_bus("vcan0", {{0x560, 0x7e0}});
  REQUIRE(bus->open());
  const RawSocket driver("vcan0");
  CanFrame got;
  const auto after = [&](std::uint32_t error_class, std::array<std::uint8_t, 8> data) {
    driver.write(CAN_ERR_FLAG | error_class, data);
    CHECK(bus->receive(got, 100ms) == CanBus::Received::Nothing);
    return bus->health().state;
  };
  CHECK(after(CAN_ERR_CRTL, {0, CAN_ERR_CRTL_TX_WARNING, 0, 0, 0, 0, 100, 1}) == CanHealth::State::Warning);
  CHECK(bus->health().send_errors == 100);
  CHECK(after(CAN_ERR_CRTL, {0, CAN_ERR_CRTL_TX_PASSIVE}) == CanHealth::State::Passive);
  CHECK(after(CAN_ERR_ACK, {}) == CanHealth::State::Passive);
  CHECK(after(CAN_ERR_BUSOFF, {}) == CanHealth::State::BusOff);
  CHECK(bus->send(frame(0x00b, 1)) ==
        CanBus::Sent::Yes);  // writing goes on as if nothing were: do not believe it
  CHECK(after(CAN_ERR_RESTARTED, {}) == CanHealth::State::Active);
  CHECK(bus->health().not_acknowledged == 1);
  CHECK(bus->health().bus_offs == 1);
}

TEST_CASE("an interface that goes down is noticed and can be opened again", "[.][vcan]") {
  const auto bus = make_socketcan_bus("vcan1");
  REQUIRE(bus->open());
  set_up("vcan1", false);
  CanFrame got;
  CHECK(bus->receive(got, 1s) == CanBus::Received::Down);
  CHECK(bus->health().state == CanHealth::State::Down);
  CHECK(bus->send(frame(1, 1)) == CanBus::Sent::Down);
  const auto refused = bus->open();
  REQUIRE_FALSE(refused);
  CHECK_THAT(refused.error().text(), Contains("is down: ip link set vcan1 up"));
  set_up("vcan1", true);
  REQUIRE(bus->open());
  CHECK(bus->send(frame(1, 1)) == CanBus::Sent::Yes);
}

TEST_CASE("the kernel tells what a virtual interface is", "[.][vcan]") {
  const auto link = read_can_link("vcan0");
  REQUIRE(link);
  CHECK(link->index > 0);
  CHECK(link->is_can);
  CHECK(link->up);
  CHECK(link->kind == "vcan");
  CHECK_FALSE(link->bitrate);
}

// With the engine that has emulated cards: their bit rate is the kernel's, 1 Mbit/s.
TEST_CASE("the kernel tells the bit rate of a card, and the wrong one is refused", "[.][cancard]") {
  const auto link = read_can_link("can0");
  REQUIRE(link);
  CHECK(link->kind == "can");
  REQUIRE(link->bitrate);
  CHECK(*link->bitrate > 0);
  CHECK(link->state == CanHealth::State::Active);
  CHECK(make_socketcan_bus("can0", {}, *link->bitrate)->open());
  const auto refused = make_socketcan_bus("can0", {}, *link->bitrate / 2)->open();
  REQUIRE_FALSE(refused);
  CHECK_THAT(refused.error().text(), Contains("bit/s, the hand speaks"));
}
