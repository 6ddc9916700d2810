#include "sim_hal/emulator/krc/krc_server.hpp"

#include <catch2/catch.hpp>

#include "fri_peer.hpp"
#include "hal/os/udp_link.hpp"

using namespace colift;
using namespace colift::sim_hal;

namespace {

/// A client's socket on any free port of this machine.
struct Client {
  std::unique_ptr<hal::DatagramLink> link;
  hal::Endpoint at{0x7F000001, 0};
  Client() {
    for (std::uint16_t port = 51000; port < 51100 && !link; ++port) {
      at.port = port;
      link = hal::make_udp_link(at);
      if (!link->open()) link.reset();
    }
    REQUIRE(link);
  }
};

std::unique_ptr<KrcServer> server_for(const Client& client, std::uint16_t from_port = 0) {
  KrcServerConfig config;
  config.krc.to = client.at;
  config.krc.script = "stanford";
  config.krc.program.linger_s = 0.1;
  config.from_port = from_port;
  config.speed = 0.0;  // a step for each answer: this machine's load decides nothing
  const hal::ArmDynamics dynamics(hal::built_in_robot(), hal::ArmDynamics::Load::Hand);
  return std::make_unique<KrcServer>(config, dynamics,
                                     std::make_unique<LightPlant>(dynamics, test::Bench::bent()));
}

/// Holds the measured pose, and asks the Stanford program for command mode or for its end.
std::vector<std::byte> answer_to(const test::Seen& m, std::uint16_t send, bool end) {
  std::vector<std::byte> c(376);
  test::set<std::uint16_t>(c, 0, send);
  test::set<std::uint16_t>(c, 2, m.send());
  test::set<std::uint16_t>(c, 4, 376);
  test::set<std::uint16_t>(c, 6, 0x1005);
  test::set<std::int32_t>(c, 72 + 4 * 14, 10);
  test::set<std::int32_t>(c, 72 + 4 * 15, end ? 30 : 10);
  test::set<std::uint32_t>(c, 140, 0x1);
  for (std::size_t j = 0; j < 7; ++j)
    test::set<float>(c, 144 + 4 * j, static_cast<float>(m.q_total()[static_cast<int>(j)]));
  return c;
}

}  // namespace

TEST_CASE("over UDP a session goes from start to close, and the server ends by itself", "[krc][server]") {
  Client client;
  const auto server = server_for(client);
  REQUIRE(server->start());
  CHECK(server->start().error().code == hal::ErrorCode::NotReady);
  std::uint16_t send = 0;
  int commanded = 0;
  std::array<std::byte, 2000> buffer;
  while (!server->ended()) {
    const hal::Datagram got = client.link->receive(buffer, std::chrono::milliseconds(200));
    if (got.kind != hal::Datagram::Kind::Data) continue;
    REQUIRE(got.size == 916);
    const test::Seen m{{buffer.begin(), buffer.begin() + 916}};
    if (m.state() == 2) ++commanded;
    client.link->send(got.from, answer_to(m, ++send, commanded > 200));
  }
  server->stop();
  const KrcReport r = server->report();
  CHECK(commanded > 200);
  CHECK(r.closed == "the client asked for the end");
  CHECK(r.broken_rules.empty());
  CHECK(r.mode_changes.size() == 4);
  CHECK(r.answered + r.missed + 1 >= r.sent);
  CHECK(server->timing().cycles >= r.sent);
  const auto events = server->take_events();
  CHECK(std::any_of(events.begin(), events.end(), [](const KrcServer::Event& e) {
    return e.text.find("command mode") != std::string::npos;
  }));
  CHECK(server->take_events().empty());
}

TEST_CASE("each answer that is missed in command is told with its times", "[krc][server]") {
  Client client;
  const auto server = server_for(client);
  const double began_s = hal::seconds(hal::SteadyClock{}.now());
  REQUIRE(server->start());
  std::uint16_t send = 0;
  int commanded = 0;
  std::array<std::byte, 2000> buffer;
  while (!server->ended()) {
    const hal::Datagram got = client.link->receive(buffer, std::chrono::milliseconds(200));
    if (got.kind != hal::Datagram::Kind::Data) continue;
    const test::Seen m{{buffer.begin(), buffer.begin() + 916}};
    if (m.state() == 2) ++commanded;
    if (commanded == 20 || commanded == 40) {
      ++commanded;
      continue;
    }
    client.link->send(got.from, answer_to(m, ++send, commanded > 60));
  }
  server->stop();
  const auto missed = server->timing().missed;
  CHECK(server->report().missed_in_command == 2);
  REQUIRE(missed.size() == 2);
  double before_s = began_s;
  for (const auto& one : missed) {
    CHECK(one.sent_s >= before_s);
    CHECK(one.until_s > one.sent_s);
    before_s = one.until_s;
  }
  CHECK(before_s <= hal::seconds(hal::SteadyClock{}.now()));
}

TEST_CASE("a server ends when it is told to, any number of times, and can start again", "[krc][server]") {
  Client client;
  const auto server = server_for(client);
  for (int i = 0; i < 2; ++i) {
    REQUIRE(server->start());
    server->stop();
    server->stop();
    CHECK(server->ended());
    CHECK(server->report().broken_rules.empty());
  }
}

TEST_CASE("a server whose port is taken says so", "[krc][server]") {
  Client client;
  const auto server = server_for(client, client.at.port);
  const auto done = server->start();
  REQUIRE_FALSE(done);
  CHECK(done.error().code == hal::ErrorCode::LinkLost);
  CHECK(done.error().detail.find("in use") != std::string::npos);
}
