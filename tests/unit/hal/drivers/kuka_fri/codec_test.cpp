#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <vector>

#include "hal/drivers/kuka_fri/wire/fri_codec.hpp"

namespace colift::hal {
namespace {

template <class Packet>
constexpr std::size_t size_of() {
  return std::is_same_v<Packet, FriMeasurement> ? kFriMeasurementBytes : kFriCommandBytes;
}

template <class Packet>
std::vector<std::byte> bytes_of(const Packet& p) {
  std::vector<std::byte> bytes(size_of<Packet>());
  encode(p, std::span<std::byte, size_of<Packet>()>(bytes));
  return bytes;
}

std::vector<int> at(const std::vector<std::byte>& bytes, std::size_t from, std::size_t count) {
  std::vector<int> part;
  for (std::size_t i = 0; i < count; ++i) part.push_back(std::to_integer<int>(bytes[from + i]));
  return part;
}

/// Any bits, but no NaN: that is not equal to itself.
template <class Packet>
Packet random_packet(std::mt19937_64& random) {
  for (;;) {
    std::vector<std::byte> bytes(size_of<Packet>());
    for (auto& b : bytes) b = static_cast<std::byte>(random());
    for (std::size_t i = 0; i + 3 < bytes.size(); i += 4)
      if ((bytes[i + 3] & std::byte{0x7F}) == std::byte{0x7F}) bytes[i + 3] ^= std::byte{0x20};
    Packet p;
    if (decode(bytes, p, {false, false}) == FriRefusal::None) return p;
  }
}

FriMeasurement plausible() {
  FriMeasurement m;
  m.state = FriState::Monitor;
  m.quality = FriQuality::Ok;
  m.measurement_period_s = m.command_period_s = 0.002f;
  m.safety_limits = 1.0f;
  return m;
}

}  // namespace

TEST_CASE("the published byte vectors of both datagrams", "[fri][codec]") {
  FriMeasurement m;
  m.head.send = 1;
  m.state = FriState::Monitor;
  m.quality = FriQuality::Bad;
  m.measurement_period_s = 0.002f;
  m.power = 0x7F;
  m.control = FriControl::Position;
  const auto b = bytes_of(m);
  CHECK(at(b, 0, 8) == std::vector<int>{0x01, 0x00, 0x00, 0x00, 0x94, 0x03, 0x06, 0x20});
  CHECK(at(b, 144, 4) == std::vector<int>{0x01, 0x00, 0x01, 0x00});
  CHECK(at(b, 148, 4) == std::vector<int>{0x6F, 0x12, 0x03, 0x3B});
  CHECK(at(b, 180, 4) == std::vector<int>{0x7F, 0x00, 0x01, 0x00});

  FriCommand c;
  c.head.send = c.head.reflected = 1;
  c.flags = fri_flag::kJointImpedance;
  c.q_rad[0] = 0.1f;
  auto d = bytes_of(c);
  CHECK(at(d, 0, 8) == std::vector<int>{0x01, 0x00, 0x01, 0x00, 0x78, 0x01, 0x05, 0x10});
  CHECK(at(d, 140, 4) == std::vector<int>{0x35, 0x00, 0x00, 0x00});
  CHECK(at(d, 144, 4) == std::vector<int>{0xCD, 0xCC, 0xCC, 0x3D});
  c.flags = fri_flag::kCartesianImpedance;
  d = bytes_of(c);
  CHECK(at(d, 140, 4) == std::vector<int>{0x00, 0x35, 0x00, 0x00});
}

TEST_CASE("every field stands at its published offset", "[fri][codec]") {
  // offsets and lengths of the vendor's header, typed in here once more
  struct Place {
    std::size_t offset, size;
  };
  const std::vector<Place> measurement = {
      {0, 2},    {2, 2},    {4, 2},    {6, 2},    {8, 64},   {72, 64},  {136, 2},   {138, 2},   {140, 4},
      {144, 2},  {146, 2},  {148, 4},  {152, 4},  {156, 4},  {160, 4},  {164, 4},   {168, 4},   {172, 4},
      {176, 4},  {180, 2},  {182, 2},  {184, 2},  {186, 2},  {188, 28}, {216, 28},  {244, 48},  {292, 28},
      {320, 28}, {348, 48}, {396, 48}, {444, 28}, {472, 28}, {500, 24}, {524, 168}, {692, 196}, {888, 28}};
  std::size_t end = 0;
  for (const Place& p : measurement) {
    CHECK(p.offset == end);
    end = p.offset + p.size;
  }
  CHECK(end == kFriMeasurementBytes);

  FriMeasurement m;
  m.head = {0, 0, 0, 0};
  const auto zero = bytes_of(m);
  const auto only = [&](std::size_t field, const FriMeasurement& changed) {
    const auto b = bytes_of(changed);
    INFO("field " << field);
    bool inside = false;
    for (std::size_t i = 0; i < b.size(); ++i) {
      if (b[i] == zero[i]) continue;
      inside = true;
      CHECK(i >= measurement[field].offset);
      CHECK(i < measurement[field].offset + measurement[field].size);
    }
    CHECK(inside);
    // first and last byte of the field are its own
    CHECK(b[measurement[field].offset] != zero[measurement[field].offset]);
    const std::size_t last = measurement[field].offset + measurement[field].size - 1;
    CHECK(b[last] != zero[last]);
  };
  const float x = std::bit_cast<float>(0x3F8F5A11u);
  const FriMeasurement none = m;
  const auto each = [&](std::size_t field, auto change) {
    m = none;
    change(m);
    only(field, m);
  };
  each(0, [](auto& v) { v.head.send = 0x1234; });
  each(1, [](auto& v) { v.head.reflected = 0x1234; });
  each(2, [](auto& v) { v.head.size = 0x1234; });
  each(3, [](auto& v) { v.head.id = 0x1234; });
  each(4, [&](auto& v) { v.krl.real.fill(x); });
  each(5, [&](auto& v) { v.krl.integer.fill(0x12345678); });
  each(6, [](auto& v) { v.krl.boolean = 0x1234; });
  each(7, [](auto& v) { v.krl.fill = 0x1234; });
  each(8, [&](auto& v) { v.timestamp_s = x; });
  each(9, [](auto& v) { v.state = static_cast<FriState>(0x1234); });
  each(10, [](auto& v) { v.quality = static_cast<FriQuality>(0x1234); });
  each(11, [&](auto& v) { v.measurement_period_s = x; });
  each(12, [&](auto& v) { v.command_period_s = x; });
  each(13, [&](auto& v) { v.safety_limits = x; });
  each(14, [&](auto& v) { v.answer_rate = x; });
  each(15, [&](auto& v) { v.latency_s = x; });
  each(16, [&](auto& v) { v.jitter_s = x; });
  each(17, [&](auto& v) { v.miss_rate = x; });
  each(18, [](auto& v) { v.misses = 0x12345678; });
  each(19, [](auto& v) { v.power = 0x1234; });
  each(20, [](auto& v) { v.control = static_cast<FriControl>(0x1234); });
  each(21, [](auto& v) { v.error = 0x1234; });
  each(22, [](auto& v) { v.warning = 0x1234; });
  each(23, [&](auto& v) { v.temperature_c.fill(x); });
  each(24, [&](auto& v) { v.q_measured_rad.fill(x); });
  each(25, [&](auto& v) { v.cart_measured.fill(x); });
  each(26, [&](auto& v) { v.q_commanded_rad.fill(x); });
  each(27, [&](auto& v) { v.q_commanded_fri_rad.fill(x); });
  each(28, [&](auto& v) { v.cart_commanded.fill(x); });
  each(29, [&](auto& v) { v.cart_commanded_fri.fill(x); });
  each(30, [&](auto& v) { v.tau_measured_nm.fill(x); });
  each(31, [&](auto& v) { v.tau_external_nm.fill(x); });
  each(32, [&](auto& v) { v.wrench_external.fill(x); });
  each(33, [&](auto& v) { v.jacobian.fill(x); });
  each(34, [&](auto& v) { v.mass_matrix.fill(x); });
  each(35, [&](auto& v) { v.gravity_nm.fill(x); });
}

TEST_CASE("every field of a command stands at its published offset", "[fri][codec]") {
  FriCommand none;
  none.head = {0, 0, 0, 0};
  const auto zero = bytes_of(none);
  const float x = std::bit_cast<float>(0x3F8F5A11u);
  const auto check = [&](std::size_t offset, std::size_t size, auto change) {
    FriCommand c = none;
    change(c);
    const auto b = bytes_of(c);
    INFO("offset " << offset);
    for (std::size_t i = 0; i < b.size(); ++i)
      if (b[i] != zero[i]) CHECK((i >= offset && i < offset + size));
    CHECK(b[offset] != zero[offset]);
    CHECK(b[offset + size - 1] != zero[offset + size - 1]);
  };
  check(8, 64, [&](auto& c) { c.krl.real.fill(x); });
  check(72, 64, [&](auto& c) { c.krl.integer.fill(0x12345678); });
  check(136, 2, [](auto& c) { c.krl.boolean = 0x1234; });
  check(140, 4, [](auto& c) { c.flags = 0x12345678; });
  check(144, 28, [&](auto& c) { c.q_rad.fill(x); });
  check(172, 48, [&](auto& c) { c.cart.fill(x); });
  check(220, 28, [&](auto& c) { c.tau_nm.fill(x); });
  check(248, 24, [&](auto& c) { c.wrench.fill(x); });
  check(272, 28, [&](auto& c) { c.stiffness_nm_rad.fill(x); });
  check(300, 28, [&](auto& c) { c.damping.fill(x); });
  check(328, 24, [&](auto& c) { c.cart_stiffness.fill(x); });
  check(352, 24, [&](auto& c) { c.cart_damping.fill(x); });
}

TEMPLATE_TEST_CASE("what was encoded decodes to itself, for any value", "[fri][codec]", FriMeasurement,
                   FriCommand) {
  std::mt19937_64 random(4);
  for (int i = 0; i < 5000; ++i) {
    const auto p = random_packet<TestType>(random);
    const auto bytes = bytes_of(p);
    TestType back;
    REQUIRE(decode(bytes, back, {false, false}) == FriRefusal::None);
    REQUIRE(back == p);
    REQUIRE(bytes_of(back) == bytes);
  }
}

TEMPLATE_TEST_CASE("every single bit of a datagram is somebody's", "[fri][codec]", FriMeasurement,
                   FriCommand) {
  std::mt19937_64 random(5);
  const auto p = random_packet<TestType>(random);
  auto bytes = bytes_of(p);
  for (std::size_t i = 0; i < bytes.size() * 8; ++i) {
    bytes[i / 8] ^= std::byte{1} << (i % 8);
    TestType other;
    REQUIRE(decode(bytes, other, {false, false}) == FriRefusal::None);
    REQUIRE_FALSE(other == p);
    REQUIRE(bytes_of(other) == bytes);
    bytes[i / 8] ^= std::byte{1} << (i % 8);
  }
}

TEST_CASE("a datagram of another length is none", "[fri][codec]") {
  const auto good = bytes_of(plausible());
  for (std::size_t size : {0u, 1u, 8u, 376u, 915u, 917u, 2048u}) {
    auto bytes = good;
    bytes.resize(size);
    FriMeasurement m;
    m.head.send = 77;
    CHECK(decode(bytes, m) == FriRefusal::Size);
    CHECK(m.head.send == 77);
  }
}

TEST_CASE("a header of another protocol is refused, unless nobody looks", "[fri][codec]") {
  FriMeasurement m = plausible();
  m.head.id = 0x2005;
  FriMeasurement out;
  CHECK(decode(bytes_of(m), out) == FriRefusal::HeaderId);
  m.head = {1, 0, 376, kFriMeasurementId};
  CHECK(decode(bytes_of(m), out) == FriRefusal::HeaderSize);
  m.head = {};
  CHECK(decode(bytes_of(m), out) == FriRefusal::HeaderId);
  CHECK(decode(bytes_of(m), out, {false, true}) == FriRefusal::None);
}

TEST_CASE("a number that is none is refused in every field", "[fri][codec]") {
  // the places of all floats: 16 of KRL, 8 of the interface, 7 temperatures and 175 of the data
  std::set<std::size_t> floats;
  for (std::size_t i = 8; i < 72; i += 4) floats.insert(i);
  floats.insert(140);
  for (std::size_t i = 148; i < 176; i += 4) floats.insert(i);
  for (std::size_t i = 188; i < 916; i += 4) floats.insert(i);
  const auto good = bytes_of(plausible());
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity()}) {
    const auto u = std::bit_cast<std::uint32_t>(bad);
    for (const std::size_t place : floats) {
      auto bytes = good;
      for (std::size_t k = 0; k < 4; ++k) bytes[place + k] = static_cast<std::byte>(u >> (8 * k));
      FriMeasurement m;
      INFO("offset " << place);
      const FriRefusal why = decode(bytes, m);
      CHECK(why >= FriRefusal::NotFiniteKrl);
      CHECK(why <= FriRefusal::NotFiniteModel);
    }
  }
}

TEST_CASE("what no LWR can mean is refused, with the reason", "[fri][codec]") {
  FriMeasurement out;
  const auto refusal = [&](auto change) {
    FriMeasurement m = plausible();
    change(m);
    return decode(bytes_of(m), out);
  };
  CHECK(refusal([](auto&) {}) == FriRefusal::None);
  CHECK(refusal([](auto& m) { m.state = static_cast<FriState>(3); }) == FriRefusal::State);
  CHECK(refusal([](auto& m) { m.quality = FriQuality::Invalid; }) == FriRefusal::Quality);
  CHECK(refusal([](auto& m) { m.control = static_cast<FriControl>(4); }) == FriRefusal::Control);
  CHECK(refusal([](auto& m) { m.measurement_period_s = -0.002f; }) == FriRefusal::SampleTime);
  CHECK(refusal([](auto& m) { m.safety_limits = 1.5f; }) == FriRefusal::SafetyLimits);
  CHECK(refusal([](auto& m) { m.latency_s = -1.0f; }) == FriRefusal::Statistics);
  CHECK(refusal([](auto& m) { m.temperature_c[3] = 4000.0f; }) == FriRefusal::Temperature);
  CHECK(refusal([](auto& m) { m.q_measured_rad[1] = 2.4f; }) == FriRefusal::JointPosition);
  CHECK(refusal([](auto& m) { m.q_measured_rad[0] = 2.4f; }) == FriRefusal::None);
  CHECK(refusal([](auto& m) {
          m.q_commanded_rad[0] = 3.0f;
          m.q_commanded_fri_rad[0] = 0.5f;
        }) == FriRefusal::JointPosition);
  CHECK(refusal([](auto& m) { m.cart_measured[0] = 2.0f; }) == FriRefusal::CartesianPose);
  CHECK(refusal([](auto& m) { m.tau_measured_nm[6] = 2e3f; }) == FriRefusal::JointTorque);
  CHECK(refusal([](auto& m) { m.jacobian[41] = 1e3f; }) == FriRefusal::Jacobian);
  CHECK(refusal([](auto& m) { m.gravity_nm[0] = -1e6f; }) == FriRefusal::MassMatrix);
  CHECK(refusal([](auto& m) { m.wrench_external[5] = 1e9f; }) == FriRefusal::Wrench);

  FriCommand back;
  const auto bad_command = [&](auto change) {
    FriCommand c;
    change(c);
    return decode(bytes_of(c), back);
  };
  CHECK(bad_command([](auto&) {}) == FriRefusal::None);
  CHECK(bad_command([](auto& c) { c.flags = 0x0002; }) == FriRefusal::Flags);
  CHECK(bad_command([](auto& c) { c.stiffness_nm_rad[2] = 2001.0f; }) == FriRefusal::Stiffness);
  CHECK(bad_command([](auto& c) { c.cart_stiffness[3] = 301.0f; }) == FriRefusal::Stiffness);
  CHECK(bad_command([](auto& c) { c.damping[0] = 1.01f; }) == FriRefusal::Damping);
  CHECK(bad_command([](auto& c) { c.cart[0] = std::nanf(""); }) == FriRefusal::NotFinite);
}

TEST_CASE("every refusal has words of its own", "[fri][codec]") {
  std::set<std::string_view> words;
  for (std::size_t i = 0; i < kFriRefusals; ++i) words.insert(to_string(static_cast<FriRefusal>(i)));
  CHECK(words.size() == kFriRefusals);
}

}  // namespace colift::hal
