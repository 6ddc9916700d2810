// The client against a gateway of the test's own: a thread that answers as it is told to.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <string>
#include <thread>
#include <vector>

#include "hal/os/make_can_bus.hpp"

using namespace colift::hal;
using namespace std::chrono_literals;
using Catch::Matchers::Contains;

namespace {

/// Listens on a port of the kernel's choosing; each connection gets the greeting and one answer per message.
class Gateway {
 public:
  struct Script {
    std::string greeting = "< hi >";
    std::vector<std::string> answers{"< ok >", "< ok >"};
    std::string after;  ///< Sent behind the last answer.
    bool hang_up = false;
    bool deaf = false;  ///< Reads nothing more behind the last answer.
  };

  explicit Gateway(Script script) : script_(std::move(script)) {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    REQUIRE(::bind(listener_, reinterpret_cast<sockaddr*>(&address), size) == 0);
    REQUIRE(::listen(listener_, 4) == 0);
    REQUIRE(::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) == 0);
    port = ntohs(address.sin_port);
    thread_ = std::thread([this] { serve(); });
  }
  ~Gateway() { finish(); }
  /// Ends all connections; what was heard is whole then.
  void finish() {
    if (!thread_.joinable()) return;
    ::shutdown(listener_, SHUT_RDWR);
    if (const int c = client_.load(); c >= 0) ::shutdown(c, SHUT_RDWR);
    thread_.join();
    ::close(listener_);
  }
  Gateway(const Gateway&) = delete;
  Gateway& operator=(const Gateway&) = delete;

  [[nodiscard]] std::unique_ptr<CanBus> client(const std::vector<CanFilter>& filters = {}) const {
    auto bus = make_can_bus("socketcand:127.0.0.1:" + std::to_string(port) + "/can0", filters);
    REQUIRE(bus);
    return std::move(*bus);
  }

  std::string heard;  ///< All that came; to be read after finish().
  std::uint16_t port = 0;

 private:
  static void say(int fd, const std::string& text) {
    if (!text.empty()) (void)!::send(fd, text.data(), text.size(), MSG_NOSIGNAL);
  }

  void serve() {
    for (;;) {
      const int fd = ::accept(listener_, nullptr, nullptr);
      if (fd < 0) return;
      client_ = fd;
      say(fd, script_.greeting);
      std::size_t answered = 0;
      if (answered == script_.answers.size()) say(fd, script_.after);
      for (char c; !(script_.hang_up && answered == script_.answers.size()) && ::recv(fd, &c, 1, 0) == 1;) {
        heard += c;
        if (c != '>' || answered == script_.answers.size()) continue;
        say(fd, script_.answers[answered++]);
        if (answered < script_.answers.size()) continue;
        say(fd, script_.after);
        if (!script_.deaf) continue;
        pollfd end{fd, 0, 0};
        (void)::poll(&end, 1, -1);
      }
      client_ = -1;
      ::close(fd);
    }
  }

  Script script_;
  int listener_ = -1;
  std::atomic<int> client_{-1};
  std::thread thread_;
};

std::string failure_of(CanBus& bus) {
  const auto opened = bus.open();
  return opened ? std::string("opened") : opened.error().text();
}

}  // namespace

TEST_CASE("a gateway is greeted, frames come through, and what is of no use is counted", "[socketcand]") {
  Gateway::Script script;
  script.after =
      "< frame 563 1.000001 82F9B88130B0 >\n< frame 123 1.0 AA >< rtr 563 1.0 2 >< error 044 1.0 >< frame "
      "566 1.5 0 >"
      "< frame 566 1.5 8100051E >";
  Gateway gateway(script);
  {
    const auto bus = gateway.client({{0x560, 0x7e0}});
    REQUIRE(bus->open());
    CHECK(bus->health().state == CanHealth::State::Active);
    CHECK_FALSE(bus->health().reports_errors);  // as far as is known
    CanFrame frame;
    REQUIRE(bus->receive(frame, 2s) == CanBus::Received::Frame);
    CHECK(frame.id == 0x563);
    CHECK(frame.length == 6);
    CHECK(frame.arrived_at > 0ns);
    REQUIRE(bus->receive(frame, 2s) == CanBus::Received::Frame);
    CHECK(frame.id == 0x566);
    CHECK(frame.data[2] == 0x05);
    CHECK(bus->receive(frame, 0ns) == CanBus::Received::Nothing);
    const CanHealth health = bus->health();
    CHECK(health.state == CanHealth::State::BusOff);  // the error frame said so
    CHECK(health.error_frames == 1);
    CHECK(health.reports_errors);
    CHECK(health.dropped == 2);  // the remote frame and the broken one
    CHECK(health.received == 2);
    frame.id = 0x00b;
    frame.length = 1;
    frame.data[0] = 0x30;
    CHECK(bus->send(frame) == CanBus::Sent::Yes);
    bus->close();
    CHECK(bus->send(frame) == CanBus::Sent::Down);
    // the gateway has read all when it has seen the end
    const auto again = gateway.client();
    REQUIRE(again->open());
  }
  gateway.finish();
  CHECK(gateway.heard == "< open can0 >< rawmode >< send 00B 1 30 >< open can0 >< rawmode >");
}

TEST_CASE("a gateway that hangs up is noticed, and can be opened anew", "[socketcand]") {
  Gateway::Script script;
  script.hang_up = true;
  Gateway gateway(script);
  const auto bus = gateway.client();
  for (int round = 0; round < 3; ++round) {
    REQUIRE(bus->open());
    CanFrame frame;
    CHECK(bus->receive(frame, 2s) == CanBus::Received::Down);
    CHECK(bus->health().state == CanHealth::State::Down);
  }
}

TEST_CASE("a gateway that cannot be used says why", "[socketcand]") {
  {
    Gateway gateway({"< hi >", {"< error could not open bus >"}, "", false, false});
    const auto bus = gateway.client();
    CHECK_THAT(failure_of(*bus),
               Contains("the gateway says \"could not open bus\" instead of its answer to open"));
  }
  {
    Gateway gateway({"SSH-2.0-OpenSSH< hi there >", {}, "", false, false});
    const auto bus = gateway.client();
    CHECK_THAT(failure_of(*bus), Contains("is not socketcand"));
  }
  {
    Gateway gateway({"", {}, "", true, false});
    const auto bus = gateway.client();
    CHECK_THAT(failure_of(*bus), Contains("closed the connection before its greeting"));
  }
  std::uint16_t port = 0;
  {
    Gateway gone({});
    port = gone.port;
  }
  const auto bus = make_can_bus("socketcand:127.0.0.1:" + std::to_string(port) + "/can0");
  CHECK_THAT(failure_of(**bus), Contains("nobody listens there"));
}

TEST_CASE("a gateway that says nothing is given up after two seconds", "[socketcand]") {
  Gateway gateway({"", {}, "", false, false});
  const auto bus = gateway.client();
  const SteadyClock clock;
  const Timestamp start = clock.now();
  CHECK_THAT(failure_of(*bus), Contains("no greeting within 2 s"));
  CHECK(clock.now() - start >= 2s);
}

TEST_CASE("a gateway that does not read fills the queue, and that is known", "[socketcand]") {
  Gateway::Script script;
  script.deaf = true;
  Gateway gateway(script);
  const auto bus = gateway.client();
  REQUIRE(bus->open());
  CanFrame frame;
  frame.id = 0x123;
  frame.length = 8;
  std::uint64_t sent = 0;
  CanBus::Sent last = CanBus::Sent::Yes;
  while (last == CanBus::Sent::Yes && sent < 10'000'000) {
    last = bus->send(frame);
    sent += last == CanBus::Sent::Yes;
  }
  CHECK(last == CanBus::Sent::Full);
  CHECK(bus->health().sent == sent);
  CHECK(bus->health().not_sent == 1);
}
