#include "hal/os/udp_link.hpp"

#include <array>
#include <catch2/catch.hpp>

using namespace colift;
using namespace std::chrono_literals;

namespace {

constexpr std::uint32_t kLoopback = 0x7f000001;

std::array<std::byte, 4> letters(char a, char b, char c, char d) {
  return {std::byte(a), std::byte(b), std::byte(c), std::byte(d)};
}

}  // namespace

TEST_CASE("A datagram arrives with its size and its sender, and the answer goes back there") {
  const auto server = hal::make_udp_link({kLoopback, 39431}), client = hal::make_udp_link({kLoopback, 0});
  REQUIRE(server->open());
  REQUIRE(client->open());
  std::array<std::byte, 16> buffer{};
  CHECK(server->receive(buffer, 0ns).kind == hal::Datagram::Kind::None);
  REQUIRE(client->send({kLoopback, 39431}, letters('p', 'i', 'n', 'g')));
  const hal::Datagram got = server->receive(buffer, 1s);
  REQUIRE(got.kind == hal::Datagram::Kind::Data);
  CHECK(got.size == 4);
  CHECK(buffer[0] == std::byte('p'));
  REQUIRE(server->send(got.from, letters('p', 'o', 'n', 'g')));
  const hal::Datagram answer = client->receive(buffer, 1s);
  CHECK(answer.from == hal::Endpoint{kLoopback, 39431});
  CHECK(buffer[1] == std::byte('o'));
}

TEST_CASE("A datagram longer than the buffer tells its whole size") {
  const auto server = hal::make_udp_link({kLoopback, 39432}), client = hal::make_udp_link({kLoopback, 0});
  REQUIRE(server->open());
  REQUIRE(client->open());
  const std::array<std::byte, 100> long_one{};
  REQUIRE(client->send({kLoopback, 39432}, long_one));
  std::array<std::byte, 8> small{};
  CHECK(server->receive(small, 1s).size == 100);
}

TEST_CASE("A port that is in use is said so") {
  const auto first = hal::make_udp_link({kLoopback, 39433}), second = hal::make_udp_link({kLoopback, 39433});
  REQUIRE(first->open());
  const auto opened = second->open();
  REQUIRE_FALSE(opened);
  CHECK_THAT(opened.error().text(), Catch::Contains("in use"));
}

TEST_CASE("A link that is not open is broken and sends nothing") {
  const auto link = hal::make_udp_link({kLoopback, 0});
  std::array<std::byte, 8> buffer{};
  CHECK(link->receive(buffer, 0ns).kind == hal::Datagram::Kind::Broken);
  CHECK_FALSE(link->send({kLoopback, 39434}, buffer));
}

TEST_CASE("Addresses are read as people write them") {
  CHECK(hal::parse_endpoint("127.0.0.1:49938").value() == hal::Endpoint{kLoopback, 49938});
  CHECK(hal::parse_endpoint(":80").value() == hal::Endpoint{0, 80});
  CHECK(hal::to_string({0xc0a80014, 49938}) == "192.168.0.20:49938");
  for (const char* wrong : {"", "127.0.0.1", "127.0.0.1:", "127.0.0.1:70000", "localhost:1", "1.2.3.4:5x"})
    CHECK_FALSE(hal::parse_endpoint(wrong));
}
