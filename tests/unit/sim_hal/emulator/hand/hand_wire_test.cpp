#include "sim_hal/emulator/hand/hand_wire.hpp"

#include <catch2/catch.hpp>
#include <vector>

#include "sim_hal/emulator/hand/hand_property.hpp"

using namespace colift;
using namespace colift::sim_hal;

namespace {

hal::CanFrame frame(int id, const std::vector<int>& bytes) {
  hal::CanFrame f;
  f.id = static_cast<std::uint16_t>(id);
  for (const int b : bytes) f.data[f.length++] = static_cast<std::uint8_t>(b);
  return f;
}

}  // namespace

// Published frames of hands and clients.
TEST_CASE("answers are the frames that real hands send", "[hand][wire]") {
  CHECK(hand_value(11, 0, 1, false, 0x1e05) == frame(0x566, {0x81, 0, 0x05, 0x1e}));
  CHECK(hand_value(11, 0, 0, false, 200) == frame(0x566, {0x80, 0, 0xc8, 0}));
  CHECK(hand_value(11, 0, 25, false, 2010) == frame(0x566, {0x99, 0, 0xda, 0x07}));
  CHECK(hand_value(14, 0, 56, true, 35950) == frame(0x5c6, {0xb8, 0, 0x6e, 0x8c, 0, 0}));
  CHECK(hand_value(12, 0, 73, false, -75) == frame(0x586, {0xc9, 0, 0xb5, 0xff}));
  CHECK(hand_value(11, 6, 48, true, -2) == frame(0x166, {0xb0, 0, 0xfe, 0xff, 0xff, 0xff}));
  CHECK(hand_position(11, 195000, 78000) == frame(0x563, {0x82, 0xf9, 0xb8, 0x81, 0x30, 0xb0}));
  CHECK(hand_position(14, 35952, std::nullopt) == frame(0x5c3, {0x80, 0x8c, 0x70}));
  CHECK(hand_position(13, -2, -1) == frame(0x5a3, {0xbf, 0xff, 0xfe, 0xbf, 0xff, 0xff}));
  CHECK(hand_joint(12, 78000) == frame(0x587, {0x81, 0x30, 0xb0}));
}

TEST_CASE("pads: five rows of twelve bits, or the ten highest", "[hand][wire]") {
  HandCells cells{};
  for (std::size_t i = 0; i < cells.size(); ++i) cells[i] = static_cast<std::uint16_t>(0x100 + i);
  CHECK(hand_pad_row(11, 0, cells) == frame(0x569, {0x01, 0x00, 0x10, 0x11, 0x02, 0x10, 0x31, 0x04}));
  CHECK(hand_pad_row(14, 4, cells) == frame(0x5c9, {0x41, 0x14, 0x11, 0x51, 0x16, 0x11, 0x70, 0x00}));
  HandCells top{};
  const std::vector<std::pair<std::size_t, int>> example{{1, 6},  {2, 4},   {8, 5},  {10, 14}, {12, 7},
                                                         {13, 7}, {14, 11}, {20, 6}, {21, 9},  {24, 3}};
  for (const auto& [cell, n] : example) top[cell - 1] = static_cast<std::uint16_t>(256 * n);
  CHECK(hand_pad_top(11, top) == frame(0x568, {0x98, 0x3a, 0x83, 0x64, 0x5e, 0x77, 0xb6, 0x93}));
}

TEST_CASE("questions and settings in every form that clients use", "[hand][wire]") {
  const auto get = read_hand_request(frame(0x405, {0x30}));
  REQUIRE(get);
  CHECK(get->kind == HandRequest::Kind::Get);
  CHECK((get->group && get->to == 5 && get->from == 0 && get->property == 48));
  CHECK(read_hand_request(frame(0x0cb, {0x08, 0x00}))->from == 6);
  const auto value = [](const std::vector<int>& bytes) {
    const auto r = read_hand_request(frame(0x00b, bytes));
    REQUIRE(r);
    CHECK(r->kind == HandRequest::Kind::Set);
    return r->value;
  };
  CHECK(value({0xb4, 0, 0x4f, 0x3e, 0x01, 0x00}) == 81487);
  CHECK(value({0xad, 0, 0xc8, 0x00}) == 200);
  CHECK(value({0xce, 0, 0, 0, 0, 0}) == 0);
  CHECK(value({0xc9, 0, 0xb5, 0xff}) == -75);
  CHECK(value({0xc9, 0, 0xb5, 0xff, 0xff, 0xff}) == -75);
  const auto packed = read_hand_request(frame(0x405, {0xaa, 0x01, 0x93, 0xf3, 0x80, 0x4b, 0x3e, 0x70}));
  REQUIRE(packed);
  CHECK(packed->kind == HandRequest::Kind::PackedTorque);
  CHECK(packed->torque == std::array<std::int16_t, 4>{100, -200, 300, -400});
}

TEST_CASE("any other frame is none", "[hand][wire]") {
  CHECK_FALSE(read_hand_request(frame(0x00b, {})));
  CHECK_FALSE(read_hand_request(frame(0x00b, {0x30, 0, 0})));
  CHECK_FALSE(read_hand_request(frame(0x00b, {0xb4, 0, 0x4f})));
  CHECK_FALSE(read_hand_request(frame(0x00b, {0xb4, 1, 0x4f, 0})));
  CHECK_FALSE(read_hand_request(frame(0x00b, {0xfb, 0, 0, 0, 0, 0, 0, 0})));
}

TEST_CASE("widths are those that clients list", "[hand][wire]") {
  std::vector<int> wide;
  for (int n = 0; n < 128; ++n)
    if (const auto* p = hand_property(n); p != nullptr && p->wide) wide.push_back(n);
  CHECK(wide == std::vector<int>{48, 50, 52, 54, 56, 58, 66, 68, 74, 88, 94, 96, 98});
  for (const int second : {49, 51, 53, 55, 57, 59, 67, 69, 75, 89, 95, 97, 99, 109, 123, 127})
    CHECK(hand_property(second) == nullptr);
}
