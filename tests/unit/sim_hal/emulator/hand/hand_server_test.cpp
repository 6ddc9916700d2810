// The hand in real time behind a socketcand gateway. Patience is long: only what comes is judged.
#include "sim_hal/emulator/hand/hand_server.hpp"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <thread>

#include "hal/drivers/barrett_can/make_barrett_hand.hpp"
#include "hal/os/make_can_bus.hpp"
#include "sim_hal/emulator/hand/hand_gateway.hpp"
#include "sim_hal/emulator/hand/hand_light_plant.hpp"

using namespace colift;
using namespace colift::sim_hal;
using namespace std::chrono_literals;

namespace {

struct Client {
  int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  std::string unread;

  explicit Client(std::uint16_t port) {
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_port = htons(port);
    (void)::inet_pton(AF_INET, "127.0.0.1", &at.sin_addr);
    REQUIRE(::connect(fd, reinterpret_cast<const sockaddr*>(&at), sizeof at) == 0);
  }
  ~Client() { ::close(fd); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  void say(const std::string& text) const {
    REQUIRE(::send(fd, text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size()));
  }
  /// What the next read gives, as python-can takes a greeting; "" at the end.
  std::string once() const {
    pollfd p{fd, POLLIN, 0};
    REQUIRE(::poll(&p, 1, 20'000) == 1);
    std::array<char, 4096> buffer;
    const ssize_t n = ::recv(fd, buffer.data(), buffer.size(), 0);
    return n > 0 ? std::string(buffer.data(), static_cast<std::size_t>(n)) : std::string();
  }
  std::string line() {
    std::size_t end = 0;
    while ((end = unread.find('\n')) == std::string::npos) {
      const std::string more = once();
      REQUIRE_FALSE(more.empty());
      unread += more;
    }
    const std::string text = unread.substr(0, end);
    unread.erase(0, end + 1);
    return text;
  }
  void shake_hands() {
    REQUIRE(once() == "< hi >");
    say("< open can0 >");
    REQUIRE(once() == "< ok >");
    say("< rawmode >");
    REQUIRE(once() == "< ok >");
  }
};

struct Served {
  HandGateway* gate = nullptr;
  std::unique_ptr<HandServer> server;

  Served() {
    HandEmulatorConfig config;
    config.puck.awake = true;
    auto bus = std::make_unique<HandGateway>(HandGatewayConfig{"127.0.0.1", 0, "can0"});
    gate = bus.get();
    server = std::make_unique<HandServer>(config, std::make_unique<LightHandPlant>(), std::move(bus));
    REQUIRE(server->start());
  }
  [[nodiscard]] std::uint16_t port() const { return gate->port(); }
};

// "< frame 566 23.424242 8100051E >": identifier and bytes
std::string of_frame(const std::string& line) {
  REQUIRE(line.substr(0, 8) == "< frame ");
  REQUIRE(line.substr(line.size() - 2) == " >");
  const std::size_t time = line.find(' ', 12);
  return line.substr(8, 3) + " " + line.substr(time + 1, line.size() - time - 3);
}

/// A client's frames may be asked before the gateway's pause after rawmode is over.
std::string ask(Client& client, const std::string& question) {
  ::usleep(100'000);
  client.say(question);
  return of_frame(client.line());
}

}  // namespace

TEST_CASE("a gateway's client asks the pucks, in both ways of writing a byte", "[hand][emulator][server]") {
  Served s;
  Client client(s.port());
  client.shake_hands();
  CHECK(ask(client, "< send 00B 1 1 >") == "566 8100051E");
  client.say("< send 00b 1 01 >");
  CHECK(of_frame(client.line()) == "566 8100051E");
  client.say("< send 00E 1 30 >");
  CHECK(of_frame(client.line()) == "5C3 800000");
  client.say("< send 00B 4 AD 0 64 0 >< send 00B 1 2D >");
  CHECK(of_frame(client.line()) == "566 AD006400");
  s.server->stop();
  CHECK(s.server->report().questions == 4);
  CHECK(s.server->report().settings == 1);
}

TEST_CASE("two clients see what the other one says", "[hand][emulator][server]") {
  Served s;
  Client one(s.port()), other(s.port());
  one.shake_hands();
  other.shake_hands();
  CHECK(ask(one, "< send 00B 1 0 >") == "566 8000C800");
  CHECK(of_frame(other.line()) == "00B 00");
  CHECK(of_frame(other.line()) == "566 8000C800");
}

TEST_CASE("a gateway refuses other buses and nonsense in words", "[hand][emulator][server]") {
  Served s;
  {
    Client client(s.port());
    REQUIRE(client.once() == "< hi >");
    client.say("< open can7 >");
    CHECK(client.once() == "< error could not open bus >");
    CHECK(client.once().empty());
  }
  Client client(s.port());
  client.shake_hands();
  for (const char* bad :
       {"< send 800 0 >", "< send 00B 9 1 >", "< send 00B 2 1 >", "< send 00B 1 100 >", "< send >"}) {
    client.say(bad);
    CHECK(client.once() == "< error syntax error in send command >");
  }
  client.say("< dance >");
  CHECK(client.once() == "< error unknown command >");
  client.say(std::string(5000, 'x'));
  client.say("<" + std::string(5000, 'y'));
  client.say("> < echo >");
  std::string all;
  while (all.find("< echo >") == std::string::npos) all += client.once();
}

TEST_CASE("a gateway tells of bus-off and breaks off when its interface goes down",
          "[hand][emulator][server]") {
  Served s;
  Client client(s.port());
  client.shake_hands();
  (void)ask(client, "< send 00B 1 0 >");
  auto off = parse_hand_fault("0:bus-off:0.2");
  REQUIRE(off);
  s.server->inject(*off);
  CHECK(client.line().substr(0, 17) == "< error 00000040 ");
  CHECK(client.line().substr(0, 17) == "< error 00000100 ");
  auto down = parse_hand_fault("0:down:0.2");
  REQUIRE(down);
  s.server->inject(*down);
  CHECK(client.once().empty());
}

TEST_CASE("row 30: behind a gateway the driver names bus-off, and works on when the bus is back",
          "[hand][emulator][server]") {
  Served s;
  auto bus = hal::make_can_bus("socketcand:127.0.0.1:" + std::to_string(s.port()) + "/can0");
  REQUIRE(bus);
  const auto hand = hal::make_barrett_hand(std::move(*bus), {});
  const auto configured = hand->configure();
  INFO((configured ? std::string() : configured.error().text()));
  REQUIRE(configured);
  const hal::SteadyClock clock;
  const auto in_time = [&](const auto& happens) {
    const hal::Timestamp until = clock.now() + 20s;
    for (; clock.now() < until; std::this_thread::sleep_for(1ms))
      if (happens()) return true;
    return false;
  };
  REQUIRE(in_time([&] { return hand->activate().has_value(); }));
  REQUIRE(in_time([&] { return hand->state().has_value(); }));
  auto off = parse_hand_fault("0:bus-off:1.5");
  REQUIRE(off);
  s.server->inject(*off);
  CHECK(in_time([&] {
    const auto state = hand->state();
    return !state && state.error().detail.find("bus-off") != std::string::npos;
  }));
  CHECK(in_time([&] { return hand->state().has_value(); }));
  CHECK(in_time([&] { return hand->preshape(0.5).has_value(); }));
}
