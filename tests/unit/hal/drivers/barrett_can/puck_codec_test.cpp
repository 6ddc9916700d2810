#include "hal/drivers/barrett_can/pucks/puck_codec.hpp"

#include <catch2/catch.hpp>
#include <random>
#include <vector>

using namespace colift::hal;
using namespace colift::hal::barrett;

namespace {

CanFrame frame(int id, std::vector<int> bytes) {
  CanFrame f;
  f.id = static_cast<std::uint16_t>(id);
  f.length = static_cast<std::uint8_t>(bytes.size());
  for (std::size_t i = 0; i < bytes.size() && i < f.data.size(); ++i)
    f.data[i] = static_cast<std::uint8_t>(bytes[i]);
  return f;
}

template <class T>
T decoded(const CanFrame& f) {
  const auto reply = decode_reply(f);
  REQUIRE(reply);
  REQUIRE(std::holds_alternative<T>(*reply));
  return std::get<T>(*reply);
}

Reject rejected(const CanFrame& f) {
  const auto reply = decode_reply(f);
  REQUIRE_FALSE(reply);
  return reply.error();
}

}  // namespace

TEST_CASE("what the host says is byte for byte what the pucks are known to understand", "[puck]") {
  CHECK(encode_set(kToEverybody, Property::Stat, 2) == frame(0x400, {0x85, 0, 2, 0}));
  CHECK(encode_get(id_to(Puck::F1), Property::Role) == frame(0x00b, {0x01}));
  CHECK(encode_set(id_to(Puck::Spread), Property::Cmd, 13) == frame(0x00e, {0x9d, 0, 0x0d, 0}));
  CHECK(encode_set(id_to(Puck::F1), Property::E, 81487) == frame(0x00b, {0xb4, 0, 0x4f, 0x3e, 1, 0}));
  CHECK(encode_set(id_to(Puck::F1), Property::Mode, 5) == frame(0x00b, {0x88, 0, 5, 0}));
  CHECK(encode_get(kToHand, Property::P) == frame(0x405, {0x30}));
  CHECK(encode_set(kToHand, Property::Cmd, 19, SetForm::Long) == frame(0x405, {0x9d, 0, 0x13, 0, 0, 0}));
  CHECK(encode_set(kToHand, Property::Tact, 2, SetForm::Long) == frame(0x405, {0xea, 0, 2, 0, 0, 0}));
  CHECK(encode_set(id_to(Puck::F1), Property::Tstop, 0, SetForm::Long) ==
        frame(0x00b, {0xce, 0, 0, 0, 0, 0}));
  CHECK(encode_set(id_to(Puck::F1), Property::Mv, 200) == frame(0x00b, {0xad, 0, 0xc8, 0}));
  CHECK(encode_set(id_to(Puck::F1), Property::Mt, 2200) == frame(0x00b, {0xab, 0, 0x98, 8}));
  CHECK(encode_set(id_to(Puck::F3), Property::Ivel, -75) == frame(0x00d, {0xc9, 0, 0xb5, 0xff}));
  CHECK(encode_set(id_to(Puck::F3), Property::Ivel, -75, SetForm::Long) ==
        frame(0x00d, {0xc9, 0, 0xb5, 0xff, 0xff, 0xff}));
}

TEST_CASE("answers mean what the published examples say", "[puck]") {
  const auto role = decoded<ValueReply>(frame(0x566, {0x81, 0, 0x05, 0x1e}));
  CHECK(role.puck == Puck::F1);
  CHECK(role.property == Property::Role);
  CHECK(role.value == 0x1e05);
  CHECK(decoded<ValueReply>(frame(0x566, {0x80, 0, 0xc8, 0})).value == 200);
  CHECK(decoded<ValueReply>(frame(0x5c6, {0x88, 0, 3, 0})).puck == Puck::Spread);
  CHECK(decoded<ValueReply>(frame(0x566, {0x99, 0, 0xda, 7})).value == 2010);
  CHECK(decoded<ValueReply>(frame(0x586, {0xeb, 0, 0xfe, 0xff})).value == -2);
  const auto finger = decoded<PositionReply>(frame(0x563, {0x82, 0xf9, 0xb8, 0x81, 0x30, 0xb0}));
  CHECK(finger.motor == 195000);
  CHECK(finger.joint == 78000);
  const auto spread = decoded<PositionReply>(frame(0x5c3, {0x80, 0x8c, 0x70}));
  CHECK(spread.motor == 35952);
  CHECK_FALSE(spread.joint);
  CHECK(decoded<PositionReply>(frame(0x5c3, {0x3f, 0xff, 0xfe})).motor ==
        -2);  // the manual's own: bit 7 clear
  CHECK(decoded<PositionReply>(frame(0x5c3, {0xff, 0xff, 0xfe})).motor == -2);
}

TEST_CASE("tactile rows hold five cells of twelve bits", "[puck]") {
  const auto row = decoded<TactileRow>(frame(0x5a9, {0x31, 0x23, 0x45, 0x67, 0x89, 0xab, 0xcd, 0xef}));
  CHECK(row.puck == Puck::F3);
  CHECK(row.row == 3);
  CHECK(row.cells == std::array<std::uint16_t, 5>{0x123, 0x456, 0x789, 0xabc, 0xdef});
  CHECK(rejected(frame(0x5a9, {0x50, 0, 0, 0, 0, 0, 0, 0})) == Reject::WrongFormat);
}

TEST_CASE("the ten cells under most pressure stand where the maker's example puts them", "[puck]") {
  const auto top = decoded<TactileTop>(frame(0x568, {0x98, 0x3a, 0x83, 0x64, 0x5e, 0x77, 0xb6, 0x93}));
  std::array<std::uint16_t, kTactileCells> expected{};
  const int cells[] = {1, 2, 8, 10, 12, 13, 14, 20, 21, 24}, values[] = {6, 4, 5, 14, 7, 7, 11, 6, 9, 3};
  for (std::size_t i = 0; i < 10; ++i)
    expected[static_cast<std::size_t>(cells[i] - 1)] = static_cast<std::uint16_t>(values[i] * 256);
  CHECK(top.cells == expected);
  CHECK(rejected(frame(0x568, {0x98, 0x3a, 0x82, 0, 0, 0, 0, 0})) == Reject::WrongFormat);  // nine
}

TEST_CASE("what is not an answer of the hand is refused with its reason", "[puck]") {
  CHECK(rejected(frame(0x540, {1, 2})) == Reject::ForeignId);           // a WAM's safety module
  CHECK(rejected(frame(0x5e6, {0x88, 0, 0, 0})) == Reject::ForeignId);  // node 15
  CHECK(rejected(frame(0x166, {0x88, 0, 0, 0})) == Reject::ForeignId);  // to node 6, not to a group
  CHECK(rejected(frame(0x564, {0x88, 0, 0, 0})) == Reject::ForeignId);  // a group for commands
  CHECK(rejected(frame(0x00b, {0x30})) == Reject::ForeignId);           // another host's question
  CHECK(rejected(frame(0x566, {0x08, 0, 0, 0})) == Reject::NotAnAnswer);
  CHECK(rejected(frame(0x566, {0x88, 1, 0, 0})) == Reject::WrongFormat);
  CHECK(rejected(frame(0x566, {0xff, 0, 0, 0})) == Reject::UnknownProperty);
  CHECK(rejected(frame(0x566, {0xb1, 0, 0, 0})) == Reject::UnknownProperty);  // second word of P
  CHECK(rejected(frame(0x566, {0x9d, 0, 0, 0})) == Reject::UnknownProperty);  // a command is never read
  for (const int length : {0, 1, 2, 3, 5, 7, 8}) {
    CanFrame f = frame(0x566, {0x88, 0, 0, 0});
    f.length = static_cast<std::uint8_t>(length);
    CHECK(rejected(f) == Reject::WrongLength);
  }
  for (const int length : {0, 1, 2, 4, 5, 7, 8}) {
    CanFrame f = frame(0x563, {0x80, 0, 0});
    f.length = static_cast<std::uint8_t>(length);
    CHECK(rejected(f) == Reject::WrongLength);
  }
}

TEST_CASE("every property keeps every value on its way to the wire and back, in both forms", "[puck]") {
  std::mt19937 random(7);
  int properties = 0;
  for (int number = 0; number < 128; ++number) {
    const PropertyInfo* info = property_info(static_cast<std::uint8_t>(number));
    if (info == nullptr || !info->readable) continue;
    ++properties;
    const auto property = static_cast<Property>(number);
    const int top = info->bits == 16 ? 0x7fff : 0x7fffffff;
    std::vector<std::int32_t> values{0, 1, -1, top, -top - 1};
    for (int i = 0; i < 200; ++i)
      values.push_back(info->bits == 16 ? static_cast<std::int16_t>(random())
                                        : static_cast<std::int32_t>(random()));
    for (const std::int32_t value : values) {
      for (const SetForm form : {SetForm::ByWidth, SetForm::Long}) {
        for (const Puck puck : kAllPucks) {
          // an answer looks like a SET to group 6
          CanFrame answer = encode_set(0, property, value, form);
          REQUIRE(answer.length == (form == SetForm::Long || info->bits == 32 ? 6 : 4));
          answer.id = static_cast<std::uint16_t>(0x400 | node_id(puck) << 5 | 6);
          const auto reply = decode_reply(answer);
          REQUIRE(reply);
          const auto& got = std::get<ValueReply>(*reply);
          REQUIRE((got.puck == puck && got.property == property && got.value == value));
        }
      }
    }
  }
  CHECK(properties > 80);
}

TEST_CASE("every position of 22 bits is read, whatever the two bits above it", "[puck]") {
  std::mt19937 random(11);
  for (int i = 0; i < 20'000; ++i) {
    const auto motor = static_cast<int>(random() % 4'194'304u) - 2'097'152;
    const auto joint = static_cast<int>(random() % 4'194'304u) - 2'097'152;
    const auto high = [&](int v) { return static_cast<int>((v >> 16 & 0x3f) | (random() & 0xc0)); };
    const auto f = frame(
        0x583, {high(motor), motor >> 8 & 255, motor & 255, high(joint), joint >> 8 & 255, joint & 255});
    const auto reply = decode_reply(f);
    REQUIRE(reply);
    const auto& got = std::get<PositionReply>(*reply);
    REQUIRE((got.motor == motor && got.joint == joint));
  }
}

TEST_CASE("no frame is too strange to be read or refused", "[puck]") {
  std::mt19937 random(13);
  int accepted = 0;
  for (int i = 0; i < 200'000; ++i) {
    CanFrame f;
    f.id = static_cast<std::uint16_t>(random() % 4 ? 0x560 + random() % 0x70 : random());
    f.length = static_cast<std::uint8_t>(random() % 12);
    for (auto& b : f.data) b = static_cast<std::uint8_t>(random());
    accepted += decode_reply(f).has_value();
  }
  CHECK(accepted > 1000);
  CHECK(accepted < 100'000);
}
