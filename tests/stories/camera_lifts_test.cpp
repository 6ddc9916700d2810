// Whole lifts whose camera fails in each phase as a Kinect behind its capture process does: the process
// killed, stopped, the cable gone, pictures that are none, old or full of holes (safety-and-faults, rows 1 to
// 9 and 11). In lock step, behind the guard; what the process itself does stands in
// unit/sim_hal/camera_emulator, and whole lifts with it in tests/camera.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <deque>
#include <iterator>
#include <limits>
#include <optional>
#include <string>

#include "control/task/run_job.hpp"
#include "hal/guards/guarded_arm.hpp"
#include "hal/guards/guarded_camera.hpp"
#include "hal/guards/guarded_hand.hpp"
#include "sim_hal/mujoco/devices/sim_devices.hpp"
#include "sim_hal/synthetic/hash_random.hpp"
#include "tests/support/fault_table.hpp"
#include "tests/support/thorough.hpp"

namespace {

using namespace colift;
using namespace std::chrono_literals;
using control::Task;
using Result = control::RunRecord::Result;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// What the driver shows of a fault, from a moment on.
struct Fault {
  enum class Kind {
    None,
    Killed,
    Stopped,
    Unplugged,
    Silent,
    Blind,
    Zeros,
    HalfSize,
    Stuck,
    Late,
    Moved,
    Old,   ///< Pictures come later and later, up to `value` s after their exposure.
    Holes  ///< `value` of the pixels never see anything: sunlight, in blots.
  };
  Kind kind = Kind::None;
  double for_s = 0.0;
  double value = 0.0;
};

constexpr double kGetsOlder = 0.25;  // seconds a second
constexpr std::size_t kBlot = 16;    // pixels of a side

class FailingCamera final : public hal::DepthCamera {
 public:
  FailingCamera(std::unique_ptr<hal::DepthCamera> inner, const hal::Clock& clock, const hal::Vec3& up_C)
      : inner_(std::move(inner)), clock_(clock), up_C_(up_C) {}
  void fail(const Fault& fault) {
    fault_ = fault;
    since_ = clock_.now();
  }
  hal::Result<> configure() override {
    ++opened;
    return gone() ? hal::Result<>(hal::failure(hal::ErrorCode::LinkLost, "test", words_))
                  : inner_->configure();
  }
  hal::Result<> activate() override { return inner_->activate(); }
  void deactivate() noexcept override { inner_->deactivate(); }
  hal::DeviceHealth health() const override { return inner_->health(); }

  hal::Result<hal::DepthFrame> next_frame(std::chrono::milliseconds timeout) override {
    using Kind = Fault::Kind;
    auto frame = inner_->next_frame(timeout);
    if (gone()) return hal::failure(hal::ErrorCode::LinkLost, "test", words_);
    if (fault_.kind == Kind::Old) frame = held_back(std::move(frame));
    if (!frame) return frame;
    frame->up_C = up_C_;
    if (!active()) {
      last_ = frame->depth_m;
      return frame;
    }
    switch (fault_.kind) {
      case Kind::Silent:
      case Kind::Stopped:
        return hal::failure(hal::ErrorCode::Timeout, "test", "none");
      case Kind::Blind:
        std::fill(frame->depth_m.begin(), frame->depth_m.end(), kNan);
        break;
      case Kind::Zeros:
        std::fill(frame->depth_m.begin(), frame->depth_m.end(), 0.0f);
        break;
      case Kind::HalfSize:
        frame->depth_m.resize(frame->depth_m.size() / 2);
        break;
      case Kind::Stuck:
        frame->depth_m = last_;
        break;
      case Kind::Late:
        frame->exposed_at -= 600ms;
        break;
      case Kind::Moved:
        frame->up_C = Eigen::AngleAxisd(0.087, hal::Vec3::UnitX()) * up_C_;
        break;
      case Kind::Holes:
        for (std::size_t i = 0; i < frame->depth_m.size(); ++i) {
          const std::size_t blot = i / 640 / kBlot * (640 / kBlot) + i % 640 / kBlot;
          if (sim_hal::unit(sim_hal::hash(3, 97, blot)) < fault_.value) frame->depth_m[i] = kNan;
        }
        break;
      default:
        break;
    }
    return frame;
  }
  int opened = 0;

 private:
  using Frame = hal::Result<hal::DepthFrame>;
  /// Pictures in their order, each when it is old enough.
  Frame held_back(Frame frame) {
    if (frame) waiting_.push_back(std::move(*frame));
    const double delay = active() ? std::min(fault_.value, kGetsOlder * age()) : 0.0;
    while (!active() && waiting_.size() > 1) waiting_.pop_front();
    if (waiting_.empty() || hal::seconds(clock_.now() - waiting_.front().exposed_at) < delay)
      return hal::failure(hal::ErrorCode::Timeout, "test", "none yet");
    Frame out = std::move(waiting_.front());
    waiting_.pop_front();
    return out;
  }
  [[nodiscard]] double age() const { return hal::seconds(clock_.now() - since_); }
  [[nodiscard]] bool active() const { return fault_.kind != Fault::Kind::None && age() < fault_.for_s; }
  [[nodiscard]] bool gone() {
    using Kind = Fault::Kind;
    if (!active()) return false;
    if (fault_.kind == Kind::Killed) words_ = "the capture process ended with signal 9";
    if (fault_.kind == Kind::Unplugged) words_ = "no Kinect on USB";
    if (fault_.kind == Kind::Stopped) words_ = "no frame for 0.2 s";
    return fault_.kind == Kind::Killed || fault_.kind == Kind::Unplugged ||
           (fault_.kind == Kind::Stopped && age() > 0.2);
  }

  std::unique_ptr<hal::DepthCamera> inner_;
  const hal::Clock& clock_;
  hal::Vec3 up_C_;
  Fault fault_;
  hal::Timestamp since_{0};
  std::string words_;
  std::vector<float> last_;
  std::deque<hal::DepthFrame> waiting_;
};

struct Lift {
  control::RunRecord record;
  sim_hal::SimTruth truth;
  int opened = 0;
  double stops_after_s = NAN;  ///< From the fault to the state that follows from it.
};

Lift lift_with(const Fault& fault, Task in) {
  const sim_hal::Scenario scenario = sim_hal::built_in_scenario();
  const hal::RobotModel& model = hal::built_in_robot();
  auto world = sim_hal::SimWorld::make(scenario, model, 1, sim_hal::SimConfig{}).value();
  control::Config config = control::run_defaults();
  const hal::Pose X_WC = sim_hal::camera_pose(scenario.camera);
  const hal::Vec3 up_C = X_WC.linear().transpose() * hal::Vec3::UnitZ();
  hal::Robot robot;
  robot.clock = sim_hal::make_sim_clock(*world);
  robot.arm = std::make_unique<hal::GuardedArm>(sim_hal::make_sim_arm(*world), model, config.guard_arm);
  robot.hand = std::make_unique<hal::GuardedHand>(sim_hal::make_sim_hand(*world), config.guard_hand);
  auto failing = std::make_unique<FailingCamera>(sim_hal::make_sim_camera(*world), *robot.clock, up_C);
  FailingCamera& camera = *failing;
  robot.camera =
      std::make_unique<hal::GuardedCamera>(std::move(failing), config.guard_camera, *robot.clock, up_C);
  config.task.lift_height_m = scenario.task.height;
  config.task.hold_s = 1.0;
  config.task.intent_lead_s = 0.0;                               // the arm moves when the fault comes
  if (in == Task::Observe) config.task.partner_timeout_s = 5.0;  // nobody needs to be waited for
  const planner::HandModel hand;
  const auto tables = std::make_shared<planner::HandCollision>(hand, config.candidates.collision);
  const hal::SteadyClock wall;
  const control::RigView rig{model, hand, tables, X_WC};
  Lift lift;
  std::optional<hal::Timestamp> failed_at;
  if (in == Task::Observe) {
    failed_at = robot.clock->now();
    camera.fail(fault);
  }
  control::JobHooks hooks;
  hooks.changed = [&](Task, Task to) {
    if (failed_at && std::isnan(lift.stops_after_s))
      lift.stops_after_s = hal::seconds(robot.clock->now() - *failed_at);
    if (failed_at || to != in) return;
    failed_at = robot.clock->now();
    camera.fail(fault);
  };
  auto record = control::run_job(robot, rig, config, {control::Method::Fast, 1}, hooks, wall);
  REQUIRE(record);
  lift.record = std::move(*record);
  lift.truth = world->truth();
  lift.opened = camera.opened;
  return lift;
}

std::string told(const Lift& lift) {
  std::string all = lift.record.reason + "\n";
  for (const auto& s : lift.record.states)
    all += std::to_string(hal::seconds(s.at)) + " " + std::string(control::word(s.state)) + ": " + s.reason +
           "\n";
  for (const auto& f : lift.record.faults) all += f.device + ": " + f.what + "\n";
  return all;
}

bool came_to(const Lift& lift, Task state) {
  return std::any_of(lift.record.states.begin(), lift.record.states.end(),
                     [&](const auto& s) { return s.state == state; });
}

bool said(const Lift& lift, const std::string& words, const std::string& device = "camera") {
  return std::any_of(lift.record.faults.begin(), lift.record.faults.end(), [&](const auto& f) {
    return f.device == device && f.what.find(words) != std::string::npos;
  });
}

/// Time in a state, the first time it came to it.
double seconds_in(const Lift& lift, Task state) {
  const auto& all = lift.record.states;
  for (std::size_t i = 0; i + 1 < all.size(); ++i)
    if (all[i].state == state) return hal::seconds(all[i + 1].at - all[i].at);
  return NAN;
}

struct Loss {
  Fault fault;
  std::string says;
  /// Of the fault catalogue: in await-partner, on the way, and while loaded, where these have rows of their
  /// own.
  std::string_view row, row_loaded;
};
const Loss kLosses[] = {
    {{Fault::Kind::Killed, 1.5}, "signal 9", "4 library crashes", "4 library crashes"},
    {{Fault::Kind::Stopped, 2.0}, "no", "4 library hangs", "4 library hangs"},
    {{Fault::Kind::Unplugged, 3.0}, "no Kinect", "2 unplugged", "3 unplugged"},
    {{Fault::Kind::Silent, 1.0}, "no good frame", "2 silent", "3 silent"},
    {{Fault::Kind::Blind, 1.0}, "shows nothing", "5 no depth", "5 no depth"},
    {{Fault::Kind::Zeros, 1.0}, "no depth camera", "5 all zeros", "5 all zeros"},
    {{Fault::Kind::HalfSize, 1.0}, "pixels", "6 wrong size", "6 wrong size"},
    {{Fault::Kind::Stuck, 1.0}, "same picture", "7 stuck", "7 stuck"},
    {{Fault::Kind::Late, 1.5}, "older", "8 late", "8 late"},
};

}  // namespace

TEST_CASE("the faults of the camera that are injected here", "[.fault-table]") {
  for (std::size_t i = 0; i < std::size(kLosses); ++i) {
    tests::print_fault(kLosses[i].row, Task::Approach, tests::chosen(i, 0));
    tests::print_fault(kLosses[i].row_loaded, Task::Lift, tests::chosen(i, 1));
    tests::print_fault(kLosses[i].row_loaded, Task::Hold, tests::chosen(i, 2));
  }
  tests::print_fault("1 unplugged", Task::AwaitPartner, true);
  tests::print_fault("11 moved", Task::AwaitPartner, true);
  tests::print_fault("8 older and older", Task::Approach, true);
  tests::print_fault("9 half the pixels missing", Task::Observe, true);
}

TEST_CASE("a camera that is lost on the approach stops the arm, which plans anew when it sees again",
          "[camera][faults]") {
  for (std::size_t i = 0; i < std::size(kLosses); ++i) {
    if (!tests::chosen(i, 0)) continue;
    const auto& [fault, words, row, row_loaded] = kLosses[i];
    const Lift lift = lift_with(fault, Task::Approach);
    INFO(words << "\n" << told(lift));
    CHECK(came_to(lift, Task::Halt));
    CHECK(said(lift, words));
    CHECK(said(lift, "is back"));
    CHECK(lift.stops_after_s < 0.45);
    CHECK_FALSE(lift.truth.robot_hit_something);
    CHECK(lift.record.outcome == Result::Lifted);
  }
}

TEST_CASE(
    "a camera that is lost while the object is carried slows the arm, and it is said; force leads the lift",
    "[camera][faults]") {
  const Task in = GENERATE(Task::Lift, Task::Hold);
  for (std::size_t i = 0; i < std::size(kLosses); ++i) {
    const auto& [fault, words, row, row_loaded] = kLosses[i];
    if (!tests::chosen(i, in == Task::Lift ? 1 : 2)) continue;
    const Lift lift = lift_with(fault, in);
    INFO(control::word(in) << ": " << words << "\n" << told(lift));
    CHECK(said(lift, words));
    CHECK(lift.record.outcome == Result::Lifted);
    CHECK_FALSE(lift.record.hand_keeps_grip);
    CHECK_FALSE(came_to(lift, Task::Halt));
    if (in != Task::Lift) continue;
    CHECK(said(lift, "continues at reduced speed: no camera image", "arm"));
    CHECK(seconds_in(lift, Task::Lift) > 2.5);  // 2.3 s with a camera
  }
}

TEST_CASE("a camera that is lost while a partner is awaited is waited for, without end and without motion",
          "[camera][faults]") {
  const Lift lift = lift_with({Fault::Kind::Unplugged, 8.0}, Task::AwaitPartner);
  INFO(told(lift));
  CHECK(said(lift, "no Kinect"));
  CHECK(lift.opened >= 4);  // every two seconds
  CHECK(lift.opened <= 6);
  CHECK(lift.record.outcome == Result::Lifted);
}

TEST_CASE("a camera that was moved is not looked through any more", "[camera][faults]") {
  const Lift lift = lift_with({Fault::Kind::Moved, 1e9}, Task::AwaitPartner);
  INFO(told(lift));
  CHECK(said(lift, "calibrate"));
  CHECK(lift.record.outcome == Result::Refused);
  CHECK_FALSE(came_to(lift, Task::Approach));
}

TEST_CASE("pictures that are old slow the arm on its way", "[camera][faults]") {
  const Lift old = lift_with({Fault::Kind::Old, 1e9, 0.21}, Task::Approach);
  INFO(told(old));
  CHECK(said(old, "continues at reduced speed: the camera's pictures are", "arm"));
  CHECK_FALSE(came_to(old, Task::Halt));
  REQUIRE(old.record.plan);
  const double planned_s = old.record.plan->transit.duration_s() + old.record.plan->approach.duration_s();
  CHECK(seconds_in(old, Task::Approach) > 1.3 * planned_s);
  CHECK(old.record.outcome == Result::Lifted);
}

TEST_CASE("nothing is grasped in a picture that is half holes; when the sun has gone it is",
          "[camera][faults]") {
  const Lift blinded = lift_with({Fault::Kind::Holes, 1e9, 0.5}, Task::Observe);
  INFO(told(blinded));
  CHECK(blinded.record.outcome == Result::Refused);
  CHECK_THAT(blinded.record.reason, Catch::Contains("of the pixels on and about the object see nothing"));
  CHECK_FALSE(came_to(blinded, Task::Approach));

  const Lift lift = lift_with({Fault::Kind::Holes, 1.0, 0.5}, Task::Observe);
  INFO(told(lift));
  CHECK(seconds_in(lift, Task::Observe) > 1.0);
  CHECK(lift.record.outcome == Result::Lifted);
}
