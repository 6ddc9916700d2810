#include <linux/can/error.h>
#include <catch2/catch.hpp>
#include <random>
#include <string>

#include "hal/os/can_error.hpp"
#include "hal/os/can_link.hpp"
#include "hal/os/make_can_bus.hpp"
#include "hal/os/socketcand_text.hpp"

using namespace colift::hal;
using Catch::Matchers::Contains;
using Kind = GatewayMessage::Kind;

namespace {

void feed(GatewayParser& parser, std::string_view text) {
  const auto room = parser.room();
  REQUIRE(room.size() >= text.size());
  std::copy(text.begin(), text.end(), room.begin());
  parser.filled(text.size());
}

}  // namespace

TEST_CASE("messages of a gateway are read as gateways and their manual write them", "[socketcand]") {
  const auto written = parse_gateway_message(" frame 566 1320751234.123456 8100051E ");
  REQUIRE(written.kind == Kind::Frame);
  CHECK(written.frame.id == 0x566);
  CHECK(written.frame.length == 4);
  CHECK(written.frame.data[3] == 0x1e);
  CHECK(parse_gateway_message(" frame 123 23.424242 11 22 33 44 ").frame.length == 4);
  CHECK(parse_gateway_message(" frame 123 23.424242  ").frame.length == 0);
  CHECK(parse_gateway_message("frame 7ff 0.000001 0011223344556677").frame.data[7] == 0x77);
  CHECK(parse_gateway_message(" hi ").kind == Kind::Hi);
  CHECK(parse_gateway_message(" ok ").kind == Kind::Ok);
  const auto error = parse_gateway_message(" error 044 12.000000 ");
  REQUIRE(error.kind == Kind::Error);
  CHECK(error.error_class == 0x44);
  const auto words = parse_gateway_message(" error could not open bus ");
  REQUIRE(words.kind == Kind::Refused);
  CHECK(words.words == "could not open bus");
  CHECK(parse_gateway_message(" frame 18DAF110 1.5 1122 ").kind == Kind::Other);  // extended
  CHECK(parse_gateway_message(" rtr 123 1.5 4 ").kind == Kind::Other);
  CHECK(parse_gateway_message(" echo ").kind == Kind::Other);
}

TEST_CASE("what is no message of a gateway is broken", "[socketcand]") {
  for (const char* text :
       {"", "  ", "frame", "frame 123", "frame 123 1.5 1", "frame 123 1.5 112",
        "frame 123 1.5 112233445566778899", "frame 123 1.5 GG", "frame 800 1.5 11", "frame 0123 1.5 11",
        "frame 12 15 11", "frame -1 1.5 11", "frame 123 1.5.5 11", "frame xyz 1.5 11",
        "frame FFFFFFFF 1.5 11", "hi there", "ok then", "?", "\x01\x02"})
    CHECK(parse_gateway_message(text).kind == Kind::Broken);
}

TEST_CASE("a stream is cut into messages wherever the pieces end", "[socketcand]") {
  const std::string stream =
      "< hi >\n< ok >< frame 123 1.5 AABB >\r\n  noise < frame 124 1.5  >< error 004 1.5 >x< frame 125 1.5 "
      "01 >";
  for (std::size_t piece = 1; piece <= stream.size(); ++piece) {
    GatewayParser parser;
    std::vector<Kind> kinds;
    for (std::size_t at = 0; at < stream.size(); at += piece) {
      feed(parser, std::string_view(stream).substr(at, piece));
      for (;;) {
        const auto message = parser.next();
        if (message.kind == Kind::None) break;
        kinds.push_back(message.kind);
      }
    }
    REQUIRE(kinds ==
            std::vector<Kind>{Kind::Hi, Kind::Ok, Kind::Frame, Kind::Frame, Kind::Error, Kind::Frame});
  }
}

TEST_CASE("a message without end does not swallow the ones after it", "[socketcand]") {
  GatewayParser parser;
  feed(parser, "< frame 123 1.5 AA < ok >");
  CHECK(parser.next().kind == Kind::Broken);
  CHECK(parser.next().kind == Kind::Ok);
  CHECK(parser.next().kind == Kind::None);
  feed(parser, "< " + std::string(3000, 'a'));
  CHECK(parser.next().kind == Kind::Broken);
  CHECK(parser.next().kind == Kind::None);
  feed(parser, std::string(4000, 'a'));
  CHECK(parser.next().kind == Kind::None);
  feed(parser, "a >< ok >");
  CHECK(parser.next().kind == Kind::Ok);
}

TEST_CASE("random bytes leave the parser able to read on", "[socketcand]") {
  std::mt19937 random(3);
  const char letters[] = "<<>> \nframe0123456789ABCDEF.ok";
  GatewayParser parser;
  for (int round = 0; round < 20'000; ++round) {
    std::string noise(random() % 200, ' ');
    for (char& c : noise)
      c = random() % 8 ? letters[random() % (sizeof letters - 1)] : static_cast<char>(random());
    feed(parser, noise);
    while (parser.next().kind != Kind::None) {
    }
  }
  feed(parser, ">< ok >");
  Kind last = Kind::None;
  for (;;) {
    const auto message = parser.next();
    if (message.kind == Kind::None) break;
    last = message.kind;
  }
  CHECK(last == Kind::Ok);
}

TEST_CASE("a frame is sent in the words that gateways read", "[socketcand]") {
  CanFrame frame;
  frame.id = 0x00b;
  frame.length = 4;
  frame.data = {0x88, 0, 5, 0xff};
  std::array<char, 64> buffer{};
  CHECK(write_gateway_send(frame, buffer) == "< send 00B 4 88 00 05 FF >");
  frame.length = 8;
  frame.id = 0x7ff;
  CHECK(write_gateway_send(frame, buffer) == "< send 7FF 8 88 00 05 FF 00 00 00 00 >");
  frame.length = 0;
  CHECK(write_gateway_send(frame, buffer) == "< send 7FF 0 >");
}

TEST_CASE("error frames of Linux become the state of the bus", "[can]") {
  CanHealth health;
  health.state = CanHealth::State::Active;
  const auto note = [&](std::uint32_t error_class, std::array<std::uint8_t, 8> data) {
    note_can_error(error_class, data, health);
    return health.state;
  };
  using State = CanHealth::State;
  CHECK(note(CAN_ERR_CRTL, {0, CAN_ERR_CRTL_TX_WARNING, 0, 0, 0, 0, 97, 2}) == State::Warning);
  CHECK(health.send_errors == 97);
  CHECK(health.receive_errors == 2);
  CHECK(note(CAN_ERR_CRTL, {0, CAN_ERR_CRTL_TX_PASSIVE}) == State::Passive);
  CHECK(note(CAN_ERR_CRTL, {0, CAN_ERR_CRTL_ACTIVE}) == State::Active);
  CHECK(note(CAN_ERR_ACK, {}) == State::Active);
  CHECK(health.not_acknowledged == 1);
  CHECK(note(CAN_ERR_PROT | CAN_ERR_BUSERROR, {}) == State::Active);
  CHECK(health.bus_errors == 1);
  CHECK(note(CAN_ERR_BUSOFF, {}) == State::BusOff);
  CHECK(note(CAN_ERR_BUSOFF, {}) == State::BusOff);
  CHECK(health.bus_offs == 1);
  CHECK(note(CAN_ERR_RESTARTED, {}) == State::Active);
  CHECK(health.error_frames == 8);
  note_can_error(CAN_ERR_CRTL, {}, health);  // from a gateway: the class alone
  CHECK(health.state == State::Warning);
}

TEST_CASE("the name of a bus is read, or refused in words", "[can]") {
  for (const char* good : {"socketcan:can0", "socketcan:vcan0", "socketcand:127.0.0.1:29536/can0",
                           "socketcand:gateway.local:28600/vcan0", "socketcand:[::1]:28600/can0"})
    CHECK(make_can_bus(good));
  for (const char* wrong : {"", "can0", "socketcan:", "socketcan:a/b", "socketcan:sixteen-letters-x",
                            "canopen:can0", "socketcand:host/can0", "socketcand:host:0/can0",
                            "socketcand:host:70000/can0", "socketcand:host:29536", "socketcand::29536/can0",
                            "socketcand:host:29536/", "socketcand:host:29536/a b"}) {
    const auto bus = make_can_bus(wrong);
    REQUIRE_FALSE(bus);
    CHECK(bus.error().code == ErrorCode::BadConfig);
    CHECK_THAT(bus.error().detail, Contains("expected socketcan:"));
  }
}

TEST_CASE("a link that cannot serve the hand is refused with what to do", "[can]") {
  CanLink link;
  const auto refusal = [&] {
    const auto ok = check_can_link("can0", link, 1'000'000);
    return ok ? std::string() : ok.error().text();
  };
  CHECK_THAT(refusal(), Contains("no interface can0"));
  link.index = 3;
  CHECK_THAT(refusal(), Contains("no CAN interface"));
  link.is_can = true;
  CHECK_THAT(refusal(), Contains("is down: ip link set can0 up type can bitrate 1000000"));
  link.up = true;
  link.bitrate = 500'000;
  CHECK_THAT(refusal(), Contains("500000 bit/s, the hand speaks 1000000"));
  link.bitrate = 1'000'000;
  CHECK(refusal().empty());
  link.bitrate.reset();  // vcan has none
  CHECK(refusal().empty());
}

TEST_CASE("an interface that does not exist is no bus, never all of them", "[can]") {
  const auto bus = make_can_bus("socketcan:nocan7");
  REQUIRE(bus);
  const auto opened = (*bus)->open();
  REQUIRE_FALSE(opened);
  CHECK(opened.error().code == ErrorCode::BadConfig);
  CHECK_THAT(opened.error().text(), Contains("no interface nocan7"));
  CHECK((*bus)->health().state == CanHealth::State::Closed);
  CanFrame frame;
  CHECK((*bus)->receive(frame, Duration{0}) == CanBus::Received::Down);
  CHECK((*bus)->send(frame) == CanBus::Sent::Down);
}

TEST_CASE("an interface of another kind is refused", "[can]") {
  const auto bus = make_can_bus("socketcan:lo");
  REQUIRE(bus);
  const auto opened = (*bus)->open();
  REQUIRE_FALSE(opened);
  CHECK_THAT(opened.error().text(), Contains("lo is no CAN interface"));
}
