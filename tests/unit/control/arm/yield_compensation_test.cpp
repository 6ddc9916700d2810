// What holds up the load of an arm that yields, and what becomes of it when the load is gone.
#include "control/arm/yield_compensation.hpp"

#include <catch2/catch.hpp>

using namespace colift;
using namespace colift::control;
using hal::JointVector;

namespace {

constexpr double kPeriod_s = 0.005, kSupport_n = 40.0;

struct Loaded {
  YieldCompensation compensation;
  JointVector load_nm = JointVector::Zero();
  Loaded() {
    load_nm[1] = 36.0;
    compensation.start(load_nm, kSupport_n);
  }
  double a2_nm(double seconds, double load_n, bool quiet = true) {
    JointVector now = JointVector::Zero();
    for (int i = 0; i < static_cast<int>(seconds / kPeriod_s + 0.5); ++i)
      now = compensation.step(load_n, quiet, kPeriod_s);
    return now[1];
  }
};

}  // namespace

TEST_CASE("a load that is felt stays compensated, also where a person bears half of it") {
  Loaded arm;
  CHECK(arm.a2_nm(5.0, kSupport_n) == 36.0);
  CHECK(arm.a2_nm(5.0, 0.5 * kSupport_n) == 36.0);
  CHECK_FALSE(arm.compensation.lost());
}

TEST_CASE("a load that is gone is not held up any longer, and held again when it is back") {
  Loaded arm;
  CHECK(arm.a2_nm(0.1, 0.0) == 36.0);  // a swinging load may feel like that for a moment
  CHECK(arm.a2_nm(0.3, 0.0) == 0.0);
  CHECK(arm.compensation.lost());
  CHECK(arm.a2_nm(0.4, kSupport_n) == 36.0);
  CHECK_FALSE(arm.compensation.lost());
}

TEST_CASE("who pushes the hand up takes no load from it") {
  Loaded arm;
  CHECK(arm.a2_nm(3.0, -30.0, /*quiet=*/false) == 36.0);
  CHECK_FALSE(arm.compensation.lost());
}

TEST_CASE("an empty hand has no load to lose") {
  Loaded arm;
  arm.compensation.start(arm.load_nm, 2.0);  // an error of the arm's model
  CHECK(arm.a2_nm(3.0, 0.0) == 36.0);
  CHECK_FALSE(arm.compensation.lost());
  arm.compensation.drop();
  CHECK(arm.a2_nm(3.0, 0.0) == 0.0);
}

TEST_CASE("a figure that is not a number changes nothing") {
  Loaded arm;
  CHECK(arm.a2_nm(3.0, NAN) == 36.0);
  CHECK(arm.compensation.step(0.0, true, NAN)[1] == 36.0);
}
