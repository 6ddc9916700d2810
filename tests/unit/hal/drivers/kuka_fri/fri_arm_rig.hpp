#pragma once

#include <catch2/catch.hpp>

#include "fake_krc.hpp"
#include "hal/drivers/kuka_fri/fri_driver.hpp"

namespace colift::test {

using hal::ErrorCode;
using hal::FriSession;
using hal::JointVector;

inline hal::ArmState next(hal::Arm& arm) {
  const auto state = arm.wait_cycle();
  if (!state) FAIL(state.error().text());
  return *state;
}

inline hal::ImpedanceCommand hold_at(const JointVector& q) {
  hal::ImpedanceCommand c;
  c.q_rad = q;
  return c;
}

}  // namespace colift::test
