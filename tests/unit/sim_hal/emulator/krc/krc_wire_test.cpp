#include "sim_hal/emulator/krc/krc_wire.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "fri_peer.hpp"
#include "sim_hal/emulator/krc/krc_rules.hpp"
#include "sim_hal/synthetic/hash_random.hpp"

using namespace colift;
using namespace colift::sim_hal;

namespace {

std::vector<int> hex(std::span<const std::byte> bytes, std::size_t offset, std::size_t count) {
  std::vector<int> out;
  for (std::size_t i = 0; i < count; ++i) out.push_back(std::to_integer<int>(bytes[offset + i]));
  return out;
}

std::vector<std::byte> random_command(Draws& draws) {
  std::vector<std::byte> bytes(kCommandBytes);
  for (std::byte& b : bytes) b = static_cast<std::byte>(draws.below(256));
  test::set<std::uint16_t>(bytes, 4, 376);
  test::set<std::uint16_t>(bytes, 6, 0x1005);
  return bytes;
}

}  // namespace

TEST_CASE("a measurement has the vendor's bytes at the vendor's places", "[krc]") {
  KrcMeasurement m;
  m.send = 1;
  m.state = FriState::Monitor;
  m.quality = FriQuality::Bad;
  m.measurement_period_s = 0.002f;
  m.power = 0x7F;
  m.control = FriControl::Position;
  const auto bytes = encode(m);
  CHECK(bytes.size() == 916);
  CHECK(hex(bytes, 0, 8) == std::vector<int>{0x01, 0, 0, 0, 0x94, 0x03, 0x06, 0x20});
  CHECK(hex(bytes, 144, 4) == std::vector<int>{1, 0, 1, 0});
  CHECK(hex(bytes, 148, 4) == std::vector<int>{0x6F, 0x12, 0x03, 0x3B});
  CHECK(hex(bytes, 180, 4) == std::vector<int>{0x7F, 0, 1, 0});
}

TEST_CASE("every field of a measurement stands at its offset", "[krc]") {
  KrcMeasurement m;
  m.krl.real[15] = 1;
  m.krl.integer[0] = -2;
  m.krl.boolean = 0x8001;
  m.timestamp_s = 3;
  m.safety_limits = 4;
  m.answer_rate = 5;
  m.latency_s = 6;
  m.jitter_s = 7;
  m.miss_rate = 8;
  m.missed = 9;
  m.error = 10;
  m.warning = 11;
  m.command_period_s = 12;
  m.temperature_c[0] = 13;
  m.q_rad[6] = 14;
  m.X_WT[11] = 15;
  m.q_krl_rad[0] = 16;
  m.q_offset_rad[0] = 17;
  m.X_WT_krl[0] = 18;
  m.X_WT_offset[0] = 19;
  m.tau_nm[0] = 20;
  m.tau_external_nm[0] = 21;
  m.wrench_external[0] = 22;
  m.jacobian[0] = 23;
  m.mass_matrix[0] = 24;
  m.gravity_nm[6] = 25;
  const auto b = encode(m);
  CHECK(test::at<float>(b, 68) == 1);
  CHECK(test::at<std::int32_t>(b, 72) == -2);
  CHECK(test::at<std::uint16_t>(b, 136) == 0x8001);
  CHECK(test::at<float>(b, 140) == 3);
  CHECK(test::at<float>(b, 152) == 12);
  CHECK(test::at<float>(b, 156) == 4);
  CHECK(test::at<float>(b, 160) == 5);
  CHECK(test::at<float>(b, 164) == 6);
  CHECK(test::at<float>(b, 168) == 7);
  CHECK(test::at<float>(b, 172) == 8);
  CHECK(test::at<std::uint32_t>(b, 176) == 9);
  CHECK(test::at<std::uint16_t>(b, 184) == 10);
  CHECK(test::at<std::uint16_t>(b, 186) == 11);
  CHECK(test::at<float>(b, 188) == 13);
  CHECK(test::at<float>(b, 240) == 14);
  CHECK(test::at<float>(b, 288) == 15);
  CHECK(test::at<float>(b, 292) == 16);
  CHECK(test::at<float>(b, 320) == 17);
  CHECK(test::at<float>(b, 348) == 18);
  CHECK(test::at<float>(b, 396) == 19);
  CHECK(test::at<float>(b, 444) == 20);
  CHECK(test::at<float>(b, 472) == 21);
  CHECK(test::at<float>(b, 500) == 22);
  CHECK(test::at<float>(b, 524) == 23);
  CHECK(test::at<float>(b, 692) == 24);
  CHECK(test::at<float>(b, 912) == 25);
}

TEST_CASE("every field of a command is read from its offset", "[krc]") {
  std::vector<std::byte> b(376);
  test::set<std::uint16_t>(b, 0, 65535);
  test::set<std::uint16_t>(b, 2, 7);
  test::set<std::uint16_t>(b, 4, 376);
  test::set<std::uint16_t>(b, 6, 0x1005);
  test::set<float>(b, 8, 1);
  test::set<std::int32_t>(b, 132, -3);
  test::set<std::uint16_t>(b, 136, 5);
  test::set<std::uint32_t>(b, 140, 0x3501);
  test::set<float>(b, 144, 0.1f);
  test::set<float>(b, 172, 11);
  test::set<float>(b, 220, 12);
  test::set<float>(b, 248, 13);
  test::set<float>(b, 272, 14);
  test::set<float>(b, 300, 15);
  test::set<float>(b, 328, 16);
  test::set<float>(b, 372, 17);
  const auto d = decode_command(b);
  REQUIRE(d.command);
  CHECK(d.command->send == 65535);
  CHECK(d.command->reflected == 7);
  CHECK(d.command->krl.real[0] == 1);
  CHECK(d.command->krl.integer[15] == -3);
  CHECK(d.command->krl.boolean == 5);
  CHECK(d.command->flags == 0x3501);
  CHECK(d.command->q_rad[0] == 0.1f);
  CHECK(d.command->X_WT[0] == 11);
  CHECK(d.command->tau_nm[0] == 12);
  CHECK(d.command->wrench[0] == 13);
  CHECK(d.command->stiffness_nm_rad[0] == 14);
  CHECK(d.command->damping[0] == 15);
  CHECK(d.command->cart_stiffness[0] == 16);
  CHECK(d.command->cart_damping[5] == 17);
}

TEST_CASE("no command is read from another length, another id or another size field", "[krc]") {
  Draws draws(1, 2);
  for (std::size_t size = 0; size < 1000; ++size) {
    const std::vector<std::byte> bytes(size, std::byte{0x11});
    const auto d = decode_command(bytes);
    REQUIRE_FALSE(d.command);
    CHECK((size == 376 ? d.why == NoCommand::WrongId : d.why == NoCommand::WrongLength));
  }
  auto bytes = random_command(draws);
  test::set<std::uint16_t>(bytes, 6, 0x2006);
  CHECK(decode_command(bytes).why == NoCommand::WrongId);
  bytes = random_command(draws);
  test::set<std::uint16_t>(bytes, 4, 916);
  CHECK(decode_command(bytes).why == NoCommand::WrongSizeField);
}

TEST_CASE("any bytes with a good header are judged without harm", "[krc]") {
  Draws draws(2, 3);
  KrcJudgedAt at;
  at.q_rad = at.q_measured_rad = hal::JointVector::Zero();
  at.X_WT = at.X_WT_measured = hal::Pose::Identity();
  at.stiffness_nm_rad.setConstant(1000);
  at.cart_stiffness.setConstant(200);
  at.since_s = 0.002;
  std::set<KrcRule> seen;
  for (int i = 0; i < 20000; ++i) {
    const auto d = decode_command(random_command(draws));
    REQUIRE(d.command);
    KrcCommand c = *d.command;
    at.control = static_cast<FriControl>(draws.below(4));
    if (draws.chance(0.7)) c.flags &= 0x3535;
    at.flags = c.flags;
    const auto breach = check_command(c, at, KrcLimits{});
    const bool none =
        std::any_of(c.q_rad.begin(), c.q_rad.end(), [](float q) { return !(std::abs(q) < 4.0f); });
    if ((c.flags & fri_flag::kJointPosition) != 0 && none) REQUIRE(breach);
    if (breach) seen.insert(breach->rule);
    (void)check_entry(c, at, KrcLimits{});
  }
  CHECK(seen.size() >= 3);
}

TEST_CASE("six-dimensional fields change their order and joints do not", "[krc]") {
  Vector6 v;
  v << 1, 2, 3, 4, 5, 6;
  CHECK(wire_order(v) == Float6{1, 2, 3, 6, 5, 4});
  CHECK(usual_order(wire_order(v)) == v);
  hal::Pose X = hal::Pose::Identity();
  X.translation() << 7, 8, 9;
  const Float12 f = wire_frame(X);
  CHECK(f[3] == 7);
  CHECK(f[7] == 8);
  CHECK(f[11] == 9);
  REQUIRE(frame_of(f));
  Float12 no_rotation = f;
  no_rotation[0] = 2;
  CHECK_FALSE(frame_of(no_rotation));
}
