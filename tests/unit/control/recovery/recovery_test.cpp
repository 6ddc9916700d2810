// The recovery with a mock arm, a hand and an operator that do what the test says.
#include "control/recovery/recovery.hpp"

#include <catch2/catch.hpp>
#include <map>

#include "../task/phase_rig.hpp"

using namespace colift;
using namespace colift::control;
using namespace colift::control::test;

namespace {

struct RecoveryRig {
  explicit RecoveryRig(const JointVector& start_rad = away()) {
    sim_hal::ArmScript script;
    script.start_rad = start_rad;
    script.external_nm = [this](hal::Timestamp, const JointVector& q) {
      Eigen::Matrix<double, 6, 1> wrench = Eigen::Matrix<double, 6, 1>::Zero();
      wrench[2] = -load_n(palm_m(q)) - arm_push_n(q);
      return JointVector(hal::jacobian(hal::built_in_robot(), q, hal::Vec3::Zero()).transpose() * wrench);
    };
    auto made_arm = std::make_unique<sim_hal::MockArm>(script, clock);
    arm = made_arm.get();
    robot.arm = std::move(made_arm);
    auto made_hand = std::make_unique<ScriptedHand>();
    hand = made_hand.get();
    robot.hand = std::move(made_hand);
    robot.camera = std::make_unique<ScriptedCamera>();
    robot.clock = std::make_unique<SharedClock>(clock);
    hooks.confirm = [this](RecoveryStep step, const std::string& what) {
      asked.push_back(step);
      announced[step] = what;
      opened_before = opened_before || (step == RecoveryStep::Release && !hand->commands.empty());
      height_asked_m = palm_m(arm->q_rad());
      return answer(step);
    };
    hooks.may_move = [this] { return key_held(); };
    hooks.interrupted = [this] { return interrupted; };
    hooks.say = [this](const std::string& line) { said += line + "\n"; };
    answer = [this](RecoveryStep step) {
      if (step == RecoveryStep::Release) hand->now = {};  // obeys at once
      return Confirmation::Yes;
    };
  }
  static JointVector away() {
    JointVector q = phase_home();
    q[0] += 0.4;
    return q;
  }
  static double palm_m(const JointVector& q) {
    return hal::hand_pose(hal::built_in_robot(), q).translation().z();
  }
  void hold_something() {
    hand->now.held = true;
    hand->now.finger_rad.fill(1.3);
  }
  RecoveryRecord run() {
    Recovery recovery(robot, {hal::built_in_robot(), hand_model, nullptr, hal::Pose::Identity()}, Config{},
                      {Method::Fast, 1, Drive::InStep, phase_home()}, stopwatch);
    return recovery.run(hooks);
  }

  hal::ManualClock clock, stopwatch;
  planner::HandModel hand_model;
  hal::Robot robot;
  sim_hal::MockArm* arm = nullptr;
  ScriptedHand* hand = nullptr;
  std::function<double(double palm_m)> load_n = [](double) { return 0.0; };
  std::function<double(const JointVector&)> arm_push_n = [](const JointVector&) { return 0.0; };
  JointVector sets_out_rad = JointVector::Zero();
  std::function<Confirmation(RecoveryStep)> answer;
  std::function<bool()> key_held = [] { return true; };
  RecoveryHooks hooks;
  std::vector<RecoveryStep> asked;
  std::map<RecoveryStep, std::string> announced;
  bool interrupted = false, opened_before = false;
  double height_asked_m = 0.0;
  std::string said;
};

}  // namespace

TEST_CASE("an open hand at home needs nothing, and nothing is asked", "[recovery]") {
  RecoveryRig rig(phase_home());
  const RecoveryRecord record = rig.run();
  CHECK(record.recovered);
  CHECK(rig.asked.empty());
  CHECK_FALSE(rig.arm->last_command());
}

TEST_CASE("a hand that does not answer may hold something: nothing moves", "[recovery]") {
  RecoveryRig rig;
  rig.hand->error = hal::Error{hal::ErrorCode::LinkLost, "hand.state", "silent"};
  const RecoveryRecord record = rig.run();
  CHECK_FALSE(record.recovered);
  CHECK(record.device_failed);
  CHECK_FALSE(rig.arm->last_command());
  CHECK(rig.hand->commands.empty());
  CHECK_THAT(rig.said, Catch::Contains("hand: unknown"));
}

TEST_CASE("what is not confirmed is not done", "[recovery]") {
  RecoveryRig rig;
  rig.hold_something();
  rig.answer = [](RecoveryStep) { return Confirmation::No; };
  const RecoveryRecord record = rig.run();
  CHECK_FALSE(record.recovered);
  CHECK(rig.asked == std::vector{RecoveryStep::Lower});
  CHECK_FALSE(rig.arm->last_command());
  CHECK(rig.hand->commands.empty());
}

TEST_CASE("a held object is lowered until it is borne, then the hand opens and the arm goes home",
          "[recovery]") {
  RecoveryRig rig;
  rig.hold_something();
  const double start_m = RecoveryRig::palm_m(RecoveryRig::away());
  rig.load_n = [&](double palm_m) { return palm_m > start_m - 0.03 && rig.hand->now.held ? 20.0 : 0.0; };
  double released_at_m = 0.0;
  rig.answer = [&](RecoveryStep step) {
    if (step == RecoveryStep::Release) {
      released_at_m = rig.height_asked_m;
      rig.hand->now = {};
    }
    return Confirmation::Yes;
  };
  const RecoveryRecord record = rig.run();
  INFO(rig.said);
  CHECK(record.recovered);
  CHECK(rig.asked ==
        std::vector{RecoveryStep::Lower, RecoveryStep::Release, RecoveryStep::DrawBack, RecoveryStep::Home});
  CHECK(start_m - released_at_m > 0.029);
  CHECK(start_m - released_at_m < 0.06);
  CHECK_FALSE(rig.opened_before);
  CHECK(rig.hand->commands == std::vector<std::string>{"release"});
  CHECK((rig.arm->q_rad() - phase_home()).cwiseAbs().maxCoeff() < 1e-3);
}

TEST_CASE("an object without ground under it stays in the hand", "[recovery]") {
  RecoveryRig rig;
  rig.hold_something();
  rig.load_n = [](double) { return 20.0; };
  const RecoveryRecord record = rig.run();
  INFO(rig.said);
  CHECK_FALSE(record.recovered);
  CHECK(rig.asked == std::vector{RecoveryStep::Lower, RecoveryStep::TakeOver});
  CHECK(record.steps.back().step == RecoveryStep::Held);
  CHECK_THAT(record.reason, Catch::Contains("a person has to take it"));
  CHECK(rig.hand->commands.empty());
}

TEST_CASE("an object that cannot be lowered is taken by a person, and the arm goes home", "[recovery]") {
  RecoveryRig rig;
  rig.hold_something();
  bool taken = false;
  rig.load_n = [&](double) { return taken ? 0.5 : 20.0; };
  rig.answer = [&](RecoveryStep step) {
    if (step == RecoveryStep::Release) rig.hand->now = {};
    if (step != RecoveryStep::TakeOver) return Confirmation::Yes;
    taken = true;
    return Confirmation::PersonHolds;
  };
  const RecoveryRecord record = rig.run();
  INFO(rig.said);
  CHECK(record.recovered);
  CHECK_THAT(rig.said, Catch::Contains("a person bears the object"));
}

TEST_CASE("a load that may be an error of measurement is no evidence of support", "[recovery]") {
  RecoveryRig rig;
  rig.hold_something();
  rig.load_n = [](double) { return 1.0; };
  CHECK_FALSE(rig.run().recovered);
  CHECK(rig.hand->commands.empty());
}

TEST_CASE("who says that a person holds the object is asked again with what the hand still bears",
          "[recovery]") {
  RecoveryRig rig;
  rig.hold_something();
  rig.load_n = [&](double) { return rig.hand->now.held ? 20.0 : 0.0; };
  bool opens = true;
  rig.answer = [&](RecoveryStep step) {
    if (step == RecoveryStep::Lower) return Confirmation::PersonHolds;
    if (step == RecoveryStep::Release && !opens) return Confirmation::No;
    if (step == RecoveryStep::Release) rig.hand->now = {};
    return Confirmation::Yes;
  };
  SECTION("and has it opened there") {
    const RecoveryRecord record = rig.run();
    INFO(rig.said);
    CHECK(record.recovered);
    CHECK_THAT(rig.said, Catch::Contains("a person holds the object, as the operator says: 20 N are left"));
  }
  SECTION("or not") {
    opens = false;
    CHECK_FALSE(rig.run().recovered);
    CHECK(rig.hand->commands.empty());
  }
  CHECK_THAT(rig.announced[RecoveryStep::Release], Catch::Contains("bears 20 N"));
}

TEST_CASE("a hand that does not open is freed, and opened again", "[recovery]") {
  RecoveryRig rig;
  rig.hold_something();
  int openings = 0, frees_at = RecoveryConfig().attempts;
  rig.answer = [&](RecoveryStep step) {
    if (step == RecoveryStep::Lower) return Confirmation::PersonHolds;
    if (step == RecoveryStep::Release && ++openings == frees_at) rig.hand->now = {};
    return Confirmation::Yes;
  };
  SECTION("freed") {
    CHECK(rig.run().recovered);
  }
  SECTION("not freed: the arm holds") {
    ++frees_at;
    CHECK_FALSE(rig.run().recovered);
  }
  CHECK(openings == RecoveryConfig().attempts);
  CHECK(rig.hand->commands == std::vector<std::string>(static_cast<std::size_t>(openings), "release"));
}

TEST_CASE("an arm that meets something on its way home is freed, and moves on", "[recovery]") {
  RecoveryRig rig;
  rig.hold_something();
  int ways = 0;
  bool freed = false, always = false;
  rig.arm_push_n = [&](const JointVector& q) {
    const bool moved = ways > 0 && (q - rig.sets_out_rad).cwiseAbs().maxCoeff() > 0.01;
    return moved && !freed ? 60.0 * ways : 0.0;  // what presses at the start is none of the way's
  };
  rig.answer = [&](RecoveryStep step) {
    if (step == RecoveryStep::Lower) return Confirmation::PersonHolds;
    if (step == RecoveryStep::Release) rig.hand->now = {};
    if (step == RecoveryStep::Home) {
      rig.sets_out_rad = rig.arm->q_rad();
      freed = ++ways > 1 && !always;
    }
    return Confirmation::Yes;
  };
  SECTION("freed") {
    const RecoveryRecord record = rig.run();
    INFO(rig.said);
    CHECK(record.recovered);
  }
  SECTION("not freed: the arm holds") {
    always = true;
    const RecoveryRecord record = rig.run();
    INFO(rig.said);
    CHECK_FALSE(record.recovered);
    CHECK(record.steps.back().step == RecoveryStep::Held);
    CHECK(record.arm_at_rest);
  }
  CHECK(ways == (always ? RecoveryConfig().attempts : 2));
  CHECK_THAT(rig.said, Catch::Contains("unexpected contact"));
}

TEST_CASE("a hand that points up a little is drawn back level, not into the ground", "[recovery]") {
  // turned about A6 until the palm points up by a few degrees to a quarter of a right angle
  const double up = GENERATE(0.1, 0.3);
  JointVector start = RecoveryRig::away();
  const auto upward = [](const JointVector& q) {
    return hal::hand_pose(hal::built_in_robot(), q).linear()(2, 2);
  };
  const double side = upward(start + 0.01 * JointVector::Unit(5)) > upward(start) ? 1.0 : -1.0;
  while (upward(start) < up) start[5] += 0.01 * side;
  RecoveryRig rig(start);
  double lowest_m = RecoveryRig::palm_m(start), back_m = 0.0;
  const hal::Vec3 from = hal::hand_pose(hal::built_in_robot(), start).translation();
  rig.key_held = [&] {
    if (rig.asked.back() == RecoveryStep::DrawBack) {
      lowest_m = std::min(lowest_m, RecoveryRig::palm_m(rig.arm->q_rad()));
      const hal::Vec3 now = hal::hand_pose(hal::built_in_robot(), rig.arm->q_rad()).translation();
      back_m = std::max(back_m, (now - from).head<2>().norm());
    }
    return true;
  };
  const RecoveryRecord record = rig.run();
  INFO(rig.said);
  CHECK(record.recovered);
  CHECK(back_m > 0.05);
  CHECK(RecoveryRig::palm_m(start) - lowest_m < 0.002);
}

TEST_CASE("the arm moves while the key is held, and stops when it is released", "[recovery]") {
  RecoveryRig rig;
  int cycle = 0;
  double fastest_released = 0.0;
  JointVector before = RecoveryRig::away();
  rig.key_held = [&] {
    ++cycle;
    // released for a second after each half second; after 0.4 s of it everything is at rest
    const bool held = cycle % 300 < 100;
    if (cycle % 300 > 180)
      fastest_released = std::max(fastest_released, (rig.arm->q_rad() - before).cwiseAbs().maxCoeff());
    before = rig.arm->q_rad();
    return held;
  };
  const RecoveryRecord record = rig.run();
  INFO(rig.said);
  CHECK(record.recovered);
  CHECK(cycle > 600);
  CHECK(fastest_released < 1e-9);
}

TEST_CASE("an interruption holds the arm wherever it is", "[recovery]") {
  RecoveryRig rig;
  rig.key_held = [&] {
    rig.interrupted = true;
    return true;
  };
  const RecoveryRecord record = rig.run();
  CHECK(record.interrupted);
  CHECK(record.steps.back().step == RecoveryStep::Held);
  CHECK(record.arm_at_rest);
}
