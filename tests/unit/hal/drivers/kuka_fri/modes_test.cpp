// Position and Cartesian impedance control: other flags, other orders of axes.
#include <catch2/catch.hpp>

#include "fake_krc.hpp"

namespace colift {
namespace {

using hal::ErrorCode;
using hal::JointVector;
using hal::SixVector;
using test::FakeKrc;

hal::FriConfig config(const char* control) {
  hal::FriConfig c = FakeKrc::quick();
  c.control = control;
  return c;
}

}  // namespace

TEST_CASE("position control sends nothing but positions", "[fri][modes]") {
  FakeKrc krc;
  krc.m.control = hal::FriControl::Position;
  const auto arm = krc.arm(config("position"));
  REQUIRE(arm->configure());
  REQUIRE(arm->activate());
  JointVector q = arm->wait_cycle()->q_rad;
  REQUIRE(arm->command_position(q));
  REQUIRE(arm->wait_cycle());
  CHECK_FALSE(arm->command({}));
  q[4] += 0.0001;
  REQUIRE(arm->command_position(q));
  REQUIRE(arm->wait_cycle());
  CHECK(static_cast<double>(krc.heard.back().q_rad[4]) == Approx(q[4]).margin(1e-6));
  for (const auto& c : krc.heard) CHECK(c.flags == 0x0001);
  q[4] += 0.05;
  const auto refused = arm->command_position(q);
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::LimitExceeded);
}

TEST_CASE("Cartesian six-vectors go over the wire as X Y Z Rz Ry Rx", "[fri][modes]") {
  FakeKrc krc;
  krc.m.control = hal::FriControl::CartesianImpedance;
  const auto arm = krc.arm(config("cartesian_impedance"));
  REQUIRE(arm->configure());
  REQUIRE(arm->activate());
  REQUIRE(arm->wait_cycle());
  hal::CartesianCommand c;
  c.X = hal::from_wire_frame(krc.m.cart_measured);
  c.stiffness << 100, 200, 300, 40, 50, 60;
  c.damping_ratio << 0.1, 0.2, 0.3, 0.4, 0.5, 0.6;
  c.wrench << 0.1, 0.2, 0.3, 0.04, 0.05, 0.06;
  REQUIRE(arm->command_cartesian(c));
  REQUIRE(arm->wait_cycle());
  const auto& heard = krc.heard.back();
  CHECK(heard.flags == 0x3500);
  CHECK(heard.cart_stiffness == hal::FriSix{100, 200, 300, 60, 50, 40});
  CHECK(heard.cart_damping == hal::FriSix{0.1f, 0.2f, 0.3f, 0.6f, 0.5f, 0.4f});
  CHECK(heard.wrench == hal::FriSix{0.1f, 0.2f, 0.3f, 0.06f, 0.05f, 0.04f});
  CHECK(heard.cart == krc.m.cart_measured);
  CHECK(krc.torque_outside == 0);
}

TEST_CASE("outside of command mode the frame is the measured one of the same datagram", "[fri][modes]") {
  FakeKrc krc;
  krc.start_when_good = false;
  krc.m.control = hal::FriControl::CartesianImpedance;
  krc.tamper = [n = 0](hal::FriMeasurement& m) mutable {
    m.cart_measured[3] = 0.4f + 0.001f * static_cast<float>(n++ % 7);
    return true;
  };
  const auto arm = krc.arm(config("cartesian_impedance"));
  REQUIRE(arm->configure());
  for (int i = 0; i < 50; ++i) REQUIRE(arm->wait_cycle());
  REQUIRE(krc.heard.size() > 40);
  for (const auto& c : krc.heard)
    for (const auto& t : krc.told)
      if (t.head.send == c.head.reflected) CHECK(c.cart == t.cart_measured);
}

TEST_CASE("a Cartesian command keeps its speed, its range and its start", "[fri][modes]") {
  FakeKrc krc;
  krc.m.control = hal::FriControl::CartesianImpedance;
  const auto arm = krc.arm(config("cartesian_impedance"));
  REQUIRE(arm->configure());
  REQUIRE(arm->activate());
  REQUIRE(arm->wait_cycle());
  hal::CartesianCommand good;
  good.X = hal::from_wire_frame(krc.m.cart_measured);
  const auto refused = [&](auto change) {
    hal::CartesianCommand c = good;
    change(c);
    const auto done = arm->command_cartesian(c);
    return !done && done.error().code == ErrorCode::LimitExceeded;
  };
  CHECK(refused([](auto& c) { c.X.translation().x() += 0.01; }));
  CHECK(refused([](auto& c) { c.X.rotate(Eigen::AngleAxisd(0.05, hal::Vec3::UnitY())); }));
  REQUIRE(arm->command_cartesian(good));
  REQUIRE(arm->wait_cycle());
  CHECK(refused([](auto& c) { c.X.translation().x() += 0.0011; }));  // 0.5 m/s is 0.001 m in 2 ms
  CHECK(refused([](auto& c) { c.X.rotate(Eigen::AngleAxisd(0.0031, hal::Vec3::UnitY())); }));
  CHECK(refused([](auto& c) { c.X.linear() *= 1.01; }));
  CHECK(refused([](auto& c) { c.X.translation().z() = std::nan(""); }));
  CHECK(refused([](auto& c) { c.stiffness[2] = 5001; }));
  CHECK(refused([](auto& c) { c.stiffness[3] = 301; }));
  CHECK(refused([](auto& c) { c.damping_ratio[3] = 1.01; }));
  CHECK(refused([](auto& c) { c.wrench[0] = 301; }));
  good.X.translation().x() += 0.0009;
  good.X.rotate(Eigen::AngleAxisd(0.0029, hal::Vec3::UnitY()));
  CHECK(arm->command_cartesian(good));
}

TEST_CASE("a stopped frame brakes and stays", "[fri][modes]") {
  FakeKrc krc;
  krc.m.control = hal::FriControl::CartesianImpedance;
  const auto arm = krc.arm(config("cartesian_impedance"));
  REQUIRE(arm->configure());
  REQUIRE(arm->activate());
  REQUIRE(arm->wait_cycle());
  hal::CartesianCommand c;
  c.X = hal::from_wire_frame(krc.m.cart_measured);
  REQUIRE(arm->command_cartesian(c));
  for (int i = 0; i < 20; ++i) {
    REQUIRE(arm->wait_cycle());
    c.X.translation().y() += 0.0004;  // 0.2 m/s
    REQUIRE(arm->command_cartesian(c));
  }
  arm->stop();
  const double from = c.X.translation().y();
  for (int i = 0; i < 300; ++i) REQUIRE(arm->wait_cycle());
  const double way = static_cast<double>(krc.heard.back().cart[7]) - from;
  CHECK(way == Approx(0.02).margin(0.001));  // v^2 / 2a with 1 m/s^2
  CHECK(krc.heard.back().cart == krc.heard[krc.heard.size() - 2].cart);
}

TEST_CASE("a posture goes along when it is asked for", "[fri][modes]") {
  FakeKrc krc;
  krc.m.control = hal::FriControl::CartesianImpedance;
  hal::FriConfig c = config("cartesian_impedance");
  c.null_space_posture = true;
  const auto arm = krc.arm(c);
  REQUIRE(arm->configure());
  REQUIRE(arm->activate());
  hal::CartesianCommand command;
  command.X = hal::from_wire_frame(krc.m.cart_measured);
  command.posture_rad = arm->wait_cycle()->q_rad;
  REQUIRE(arm->command_cartesian(command));
  REQUIRE(arm->wait_cycle());
  (*command.posture_rad)[0] += 0.0002;
  REQUIRE(arm->command_cartesian(command));
  REQUIRE(arm->wait_cycle());
  CHECK(krc.heard.back().flags == 0x3501);
  CHECK(static_cast<double>(krc.heard.back().q_rad[0]) == Approx((*command.posture_rad)[0]).margin(1e-6));
}

TEST_CASE("six-vectors change their order and back", "[fri][modes]") {
  SixVector v;
  v << 1, 2, 3, 4, 5, 6;
  CHECK(hal::to_wire_order(v) == hal::FriSix{1, 2, 3, 6, 5, 4});
  CHECK(hal::from_wire_order(hal::to_wire_order(v)) == v);
}

}  // namespace colift
