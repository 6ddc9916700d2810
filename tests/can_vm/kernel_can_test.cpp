// SocketCAN as cards really are, which virtual interfaces are not: [serial] an adapter on a serial line
// (slcan) whose far end the test plays, with the kernel's own states, bus-off and unplugging; [card] two
// emulated Kvaser cards on one bus. Runs inside the machines of run_in_vm alone, which has all of it to
// itself.
#include <fcntl.h>
#include <linux/tty.h>
#include <net/if.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <mutex>
#include <string>
#include <thread>

#include "hal/os/can_link.hpp"
#include "hal/os/socketcan_bus.hpp"

using namespace colift::hal;
using namespace std::chrono_literals;
using Catch::Matchers::Contains;
using State = CanHealth::State;

namespace {

CanFrame frame(std::uint16_t id, std::uint8_t first) {
  CanFrame f;
  f.id = id;
  f.length = 1;
  f.data[0] = first;
  return f;
}

void shell(const std::string& command) {
  INFO(command);
  REQUIRE(std::system(command.c_str()) == 0);
}

/// Looks for up to 10 s whether it has come true; only a failure takes that long.
template <class Condition>
bool comes_true(Condition condition) {
  for (int i = 0; i < 2000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(5ms);
  }
  return false;
}

/// An adapter on a pseudo terminal, as slcand attaches one; the test is the adapter.
class SerialAdapter {
 public:
  SerialAdapter() : far_(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    REQUIRE(far_ >= 0);
    REQUIRE(::grantpt(far_) == 0);
    REQUIRE(::unlockpt(far_) == 0);
    near_ = ::open(::ptsname(far_), O_RDWR | O_NOCTTY | O_CLOEXEC);
    REQUIRE(near_ >= 0);
    termios raw{};
    ::cfmakeraw(&raw);
    REQUIRE(::tcsetattr(near_, TCSANOW, &raw) == 0);
    const int discipline = N_SLCAN;
    REQUIRE(::ioctl(near_, TIOCSETD, &discipline) == 0);
    std::array<char, IFNAMSIZ> name{};
    REQUIRE(::ioctl(near_, SIOCGIFNAME, name.data()) == 0);
    interface = name.data();
    // all the time: the kernel's driver waits until its commands have been taken
    reader_ = std::thread([this] {
      while (!stop_) {
        pollfd poll{far_, POLLIN, 0};
        std::array<char, 256> some;
        if (::poll(&poll, 1, 10) <= 0) continue;
        const ssize_t n = ::read(far_, some.data(), some.size());
        const std::lock_guard lock(mutex_);
        if (n > 0) heard_.append(some.data(), static_cast<std::size_t>(n));
      }
    });
  }
  ~SerialAdapter() {
    if (near_ >= 0) unplug();
  }
  SerialAdapter(const SerialAdapter&) = delete;
  SerialAdapter& operator=(const SerialAdapter&) = delete;

  void says(const std::string& line) const {
    const std::string text = line + "\r";
    REQUIRE(::write(far_, text.data(), text.size()) == static_cast<ssize_t>(text.size()));
  }
  /// Until it has got this from the kernel.
  [[nodiscard]] bool is_told(const std::string& part) {
    return comes_true([&] {
      const std::lock_guard lock(mutex_);
      return heard_.find(part) != std::string::npos;
    });
  }
  void unplug() {
    stop_ = true;
    reader_.join();
    ::close(far_);
    ::close(near_);
    far_ = near_ = -1;
  }

  std::string interface;

 private:
  int far_, near_ = -1;
  std::mutex mutex_;
  std::string heard_;
  std::atomic<bool> stop_{false};
  std::thread reader_;
};

/// What the bus is once `condition` holds; its frames are taken in on the way.
template <class Condition>
bool becomes(CanBus& bus, Condition condition) {
  return comes_true([&] {
    CanFrame f;
    (void)bus.receive(f, 0ms);
    return condition(bus.health());
  });
}

}  // namespace

TEST_CASE("an adapter on a serial line: frames, states, bus-off and its end, unplugging", "[serial]") {
  SerialAdapter adapter;
  const std::string& name = adapter.interface;
  const auto bus = make_socketcan_bus(name, {{0x560, 0x7e0}});
  const auto down = bus->open();
  REQUIRE_FALSE(down);
  CHECK_THAT(down.error().text(), Contains("is down"));

  shell("ip link set " + name + " up type can bitrate 500000");
  const auto slow = bus->open();
  REQUIRE_FALSE(slow);
  CHECK_THAT(slow.error().text(), Contains("the bit rate is 500000 bit/s, the hand speaks 1000000"));
  shell("ip link set " + name + " down");
  shell("ip link set " + name + " up type can bitrate 1000000");
  REQUIRE(bus->open());
  CHECK(bus->health().state == State::Active);
  CHECK(adapter.is_told("S8\r"));

  REQUIRE(bus->send(frame(0x00b, 0x08)) == CanBus::Sent::Yes);
  CHECK(adapter.is_told("t00B108\r"));
  adapter.says("t566180");
  adapter.says("t123180");  // nobody asked for it
  adapter.says("t56310A");
  CanFrame got;
  REQUIRE(bus->receive(got, 10s) == CanBus::Received::Frame);
  CHECK(got == frame(0x566, 0x80));
  REQUIRE(bus->receive(got, 10s) == CanBus::Received::Frame);
  CHECK(got == frame(0x563, 0x0a));

  // errors in receiving first, then in sending
  adapter.says("sw001100");
  CHECK(becomes(*bus, [](const CanHealth& h) { return h.state == State::Warning; }));
  CHECK(bus->health().send_errors == 100);
  CHECK(bus->health().receive_errors == 1);
  adapter.says("sp000130");
  CHECK(becomes(*bus, [](const CanHealth& h) { return h.state == State::Passive; }));
  adapter.says("sb000255");
  CHECK(becomes(*bus, [](const CanHealth& h) { return h.state == State::BusOff; }));
  CHECK(bus->health().bus_offs == 1);
  CHECK(comes_true([&] {
    const auto link = read_can_link(name);
    return link && link->state == State::BusOff && !link->running;
  }));

  // nothing restarts this kind by itself: down and up again ends it
  shell("ip link set " + name + " down");
  CHECK(becomes(*bus, [](const CanHealth& h) { return h.state == State::Down; }));
  shell("ip link set " + name + " up");
  REQUIRE(bus->open());
  CHECK(bus->health().state == State::Active);
  adapter.says("t566181");
  REQUIRE(bus->receive(got, 10s) == CanBus::Received::Frame);
  CHECK(got == frame(0x566, 0x81));

  adapter.unplug();
  CHECK(becomes(*bus, [](const CanHealth& h) { return h.state == State::Down; }));
  CHECK(bus->send(frame(0x00b, 1)) == CanBus::Sent::Down);
  const auto gone = bus->open();
  REQUIRE_FALSE(gone);
  CHECK_THAT(gone.error().text(), Contains("there is no interface " + name));
}

TEST_CASE(
    "an adapter as slcand attaches it has no bit rate to be told, and its bus-off is seen by who comes later",
    "[serial]") {
  SerialAdapter adapter;
  shell("ip link set " + adapter.interface + " up");
  const auto link = read_can_link(adapter.interface);
  REQUIRE(link);
  CHECK_FALSE(link->bitrate);
  const auto bus = make_socketcan_bus(adapter.interface);
  REQUIRE(bus->open());
  CHECK(bus->health().state == State::Active);
  adapter.says("sb000255");
  REQUIRE(becomes(*bus, [](const CanHealth& h) { return h.state == State::BusOff; }));
  const auto late = make_socketcan_bus(adapter.interface);
  REQUIRE(late->open());
  CHECK(late->health().state == State::BusOff);
}

TEST_CASE("two cards on one bus: bit rate, restart, and a bit rate that is not the hand's", "[card]") {
  for (const char* name : {"can0", "can1"}) {
    const auto link = read_can_link(name);
    REQUIRE(link);
    CHECK(link->kind == "can");
    CHECK(link->up);
    CHECK(link->running);
    CHECK(link->bitrate == 1'000'000u);
    CHECK(link->restart_ms == 100u);
    REQUIRE(link->sample_point);
    CHECK(*link->sample_point == Approx(0.75));
  }
  const auto host = make_socketcan_bus("can0", {{0x560, 0x7e0}}), hand = make_socketcan_bus("can1");
  REQUIRE(host->open());
  REQUIRE(hand->open());
  CanFrame got;
  for (std::uint8_t i = 0; i < 100; ++i) {
    REQUIRE(host->send(frame(0x00b, i)) == CanBus::Sent::Yes);
    REQUIRE(hand->receive(got, 10s) == CanBus::Received::Frame);
    REQUIRE(got == frame(0x00b, i));
    REQUIRE(hand->send(frame(0x566, i)) == CanBus::Sent::Yes);
    REQUIRE(host->receive(got, 10s) == CanBus::Received::Frame);
    REQUIRE(got == frame(0x566, i));
  }
  CHECK(host->health().state == State::Active);

  shell("ip link set can0 down");
  CHECK(becomes(*host, [](const CanHealth& h) { return h.state == State::Down; }));
  shell("ip link set can0 up type can bitrate 250000 restart-ms 0");
  const auto refused = host->open();
  REQUIRE_FALSE(refused);
  CHECK_THAT(refused.error().text(), Contains("the bit rate is 250000 bit/s, the hand speaks 1000000"));
  CHECK(read_can_link("can0")->restart_ms == 0u);
  shell("ip link set can0 down");
  shell("ip link set can0 up type can bitrate 1000000 restart-ms 100");
  CHECK(host->open());
}
