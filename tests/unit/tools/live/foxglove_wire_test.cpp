#include "tools/live/foxglove_wire.hpp"

#include <catch2/catch.hpp>
#include <cstring>
#include <nlohmann/json.hpp>
#include <random>

using namespace colift;
using namespace colift::live;
using nlohmann::json;

namespace {

std::string call(std::uint32_t service, std::uint32_t id, const std::string& encoding,
                 const std::string& payload) {
  std::string bytes("\x02", 1);
  for (const std::uint32_t v : {service, id, static_cast<std::uint32_t>(encoding.size())})
    for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<char>((v >> (8 * i)) & 0xFF));
  return bytes + encoding + payload;
}

}  // namespace

TEST_CASE("a client is spoken to in the first of our sub-protocols that it offers") {
  CHECK(chosen_sub_protocol("foxglove.websocket.v1") == "foxglove.websocket.v1");
  CHECK(chosen_sub_protocol("chat, foxglove.sdk.v1 ,foxglove.websocket.v1") == "foxglove.sdk.v1");
  CHECK_FALSE(chosen_sub_protocol(""));
  CHECK_FALSE(chosen_sub_protocol(",, foxglove.websocket.v2,"));
}

TEST_CASE("only who may operate hears of services") {
  CHECK(json::parse(server_info("CoLift", "7", false))["capabilities"] == json::array({"time"}));
  const json info = json::parse(server_info("CoLift", "7", true));
  CHECK(info["capabilities"] == json::array({"time", "services"}));
  CHECK(info["supportedEncodings"] == json::array({"json"}));
  CHECK(info["sessionId"] == "7");
}

TEST_CASE("every channel is announced with its schema under its own number") {
  const json message = json::parse(advertise(telemetry::channels()));
  REQUIRE(message["channels"].size() == telemetry::channels().size());
  for (std::size_t i = 0; i < message["channels"].size(); ++i) {
    const json& channel = message["channels"][i];
    CHECK(channel["id"] == i);
    CHECK(channel["topic"] == telemetry::channels()[i].topic);
    if (channel["encoding"] == "json") CHECK(json::parse(channel["schema"].get<std::string>()).is_object());
  }
}

TEST_CASE("message data: opcode, subscription, nanoseconds, payload, little-endian") {
  const std::string bytes = message_data(0x01020304, hal::Timestamp(0x1122334455667788), "{}");
  const unsigned char expected[] = {1, 4, 3, 2, 1, 0x88, 0x77, 0x66, 0x55, 0x44, 0x33, 0x22, 0x11, '{', '}'};
  REQUIRE(bytes.size() == sizeof(expected));
  CHECK(std::memcmp(bytes.data(), expected, sizeof(expected)) == 0);
}

TEST_CASE("the robot's time: opcode, nanoseconds; never before its zero") {
  CHECK(server_time(hal::Timestamp(0x0102)) == std::string("\x02\x02\x01\0\0\0\0\0\0", 9));
  CHECK(server_time(hal::Timestamp(-5)) == std::string("\x02\0\0\0\0\0\0\0\0", 9));
}

TEST_CASE("what clients say is taken apart, or refused in one sentence") {
  SECTION("subscriptions") {
    const auto m =
        parse_text(R"({"op":"subscribe","subscriptions":[{"id":3,"channelId":5},{"id":4,"channelId":0}]})");
    REQUIRE(m);
    const auto& list = std::get<Subscribe>(*m).subscriptions;
    REQUIRE(list.size() == 2);
    CHECK(list[0].id == 3);
    CHECK(list[0].channel == 5);
  }
  SECTION("and their end") {
    const auto m = parse_text(R"({"op":"unsubscribe","subscriptionIds":[4294967295]})");
    REQUIRE(m);
    CHECK(std::get<Unsubscribe>(*m).ids == std::vector<std::uint32_t>{0xFFFFFFFFu});
  }
  SECTION("a call of a service") {
    const auto m = parse_binary(call(1, 77, "json", "{}"));
    REQUIRE(m);
    CHECK(std::get<ServiceCall>(*m).service == 1);
    CHECK(std::get<ServiceCall>(*m).call == 77);
    CHECK(std::get<ServiceCall>(*m).payload == "{}");
  }
  SECTION("nonsense") {
    for (const char* text :
         {"", "[]", "7", "{", R"({"op":7})", R"({"op":"subscribe"})", R"({"op":"setParameters"})",
          R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":0}]})",
          R"({"op":"subscribe","subscriptions":[7]})",
          R"({"op":"subscribe","subscriptions":[{"id":1e300,"channelId":0}]})",
          R"({"op":"unsubscribe","subscriptionIds":["a"]})"}) {
      INFO(text);
      const auto m = parse_text(text);
      REQUIRE_FALSE(m);
      CHECK_FALSE(m.error().detail.empty());
    }
    CHECK_FALSE(parse_binary(""));
    CHECK_FALSE(parse_binary("\x01"));
    CHECK_FALSE(parse_binary(call(1, 1, "ros1", "")));
    CHECK_FALSE(parse_binary(call(1, 1, "json", "").substr(0, 15)));
  }
  SECTION("a list without end") {
    std::string text = R"({"op":"unsubscribe","subscriptionIds":[0)";
    for (std::size_t i = 0; i < kMostEntries; ++i) text += ",0";
    CHECK_FALSE(parse_text(text + "]}"));
  }
}

TEST_CASE("whatever bytes come, the parser says yes or no") {
  std::mt19937 random(5);
  const std::string seeds[] = {R"({"op":"subscribe","subscriptions":[{"id":3,"channelId":5}]})",
                               call(1, 2, "json", "{}")};
  for (int i = 0; i < 20000; ++i) {
    std::string bytes = seeds[i % 2];
    for (int k = 0; k < 3; ++k) bytes[random() % bytes.size()] = static_cast<char>(random());
    if (random() % 4 == 0) bytes.resize(random() % bytes.size());
    const auto a = parse_text(bytes);
    const auto b = parse_binary(bytes);
    if (!a) CHECK_FALSE(a.error().detail.empty());
    if (!b) CHECK_FALSE(b.error().detail.empty());
  }
}
