#include "control/arm/contact_wrench.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "control/lift/load_estimator.hpp"
#include "hal/types/units.hpp"

using namespace colift;
using namespace colift::control;
using hal::JointVector;
using hal::Vec3;

namespace {

constexpr double kLimit_n = 30.0;  // at which an approach stops
constexpr TorqueErrors kErrors{0.25, 0.3};

const hal::RobotModel& robot() {
  return hal::built_in_robot();
}

JointVector bent_by(double elbow_rad) {
  return (JointVector() << 0.55, -0.51, 1.2, elbow_rad, 0.4, 0.76, -0.16).finished();
}

// A force on the hand, `lever_m` before the palm, as joint torques.
JointVector torques(const JointVector& q, const Vec3& force_n, double lever_m = 0.0) {
  return hal::jacobian(robot(), q, {0, 0, lever_m}).topRows<3>().transpose() * force_n;
}

double felt_n(const JointVector& q, const JointVector& tare_q, const JointVector& tau) {
  return contact_wrench(robot(), q, palm_rise(robot(), tare_q), tau, kErrors).force.norm();
}

}  // namespace

TEST_CASE("torque errors and a tool that was weighed wrong are no contact, however straight the elbow is",
          "[contact]") {
  const JointVector home = bent_by(-1.6);
  double plain_n = 0.0;
  for (const double elbow : {-0.05, -0.1, -0.13, -0.2, -0.5, 0.1, 0.9}) {
    CAPTURE(elbow);
    const JointVector q = bent_by(elbow);
    std::mt19937_64 bits(7);
    std::uniform_real_distribution<double> part(-1.0, 1.0);
    for (int i = 0; i < 500; ++i) {
      const Vec3 tool(0, 0, -0.3 * part(bits) * hal::kGravity_m_s2);
      JointVector tau = torques(q, tool, 0.05) - torques(home, tool, 0.05);
      for (double& t : tau) t += 0.3 * part(bits);
      CHECK(felt_n(q, home, tau) < kLimit_n);
      plain_n = std::max(plain_n, palm_wrench(robot(), q, tau).force.norm());
    }
  }
  CHECK(plain_n > kLimit_n);  // without the prior one of them would have been
}

TEST_CASE("a push is felt in every direction, a little later near a straight elbow", "[contact]") {
  const JointVector home = bent_by(-1.6);
  for (const double elbow : {-0.1, -0.3, -0.9, -1.4})
    for (const Vec3& along :
         {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(1, 1, 1), Vec3(-1, 1, 0)}) {
      const JointVector q = bent_by(elbow);
      const Vec3 push = 50.0 * along.normalized();
      const double n = felt_n(q, home, torques(q, push, 0.1));
      CAPTURE(elbow, along.transpose(), n);
      CHECK(n > kLimit_n);
      CHECK(n < 55.0);
      if (elbow < -0.5) CHECK(n > 45.0);
    }
}

TEST_CASE("where nothing errs a contact is what the palm feels", "[contact]") {
  const JointVector q = bent_by(-1.2);
  const JointVector tau = torques(q, {3, -8, 20});
  const hal::Wrench plain = palm_wrench(robot(), q, tau),
                    mine = contact_wrench(robot(), q, palm_rise(robot(), bent_by(-1.6)), tau, {});
  CHECK((plain.force - mine.force).norm() < 1e-3);
  CHECK((plain.torque - mine.torque).norm() < 1e-3);
}
