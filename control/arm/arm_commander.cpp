#include "control/arm/arm_commander.hpp"

#include <atomic>
#include <thread>

#include "hal/os/realtime.hpp"
#include "hal/types/spsc_ring.hpp"
#include "hal/types/triple_buffer.hpp"

namespace colift::control {
namespace {

using namespace std::chrono_literals;

// At the end the arm gets its last set point some more times before it is left alone. The figures count
// cycles and were chosen for periods of 1 to 5 ms: one that does not come to rest is left after 1 to 5 s.
constexpr int kCyclesAtEnd = 20;
constexpr int kMostCyclesAtEnd = 1000;
constexpr auto kTaskPeriod = 4ms;  // of a task that does not run the arm's cycle: eight cycles per frame

/// Activation and the first good cycle, in the thread that makes all the others.
hal::Result<> begin(hal::Arm& arm, ArmController& controller, int max_misses) {
  if (auto active = arm.activate(); !active) return active;
  for (int misses = 0;; ++misses) {
    const auto state = arm.wait_cycle();
    controller.measured(state);
    if (state) break;
    if (state.error().code != hal::ErrorCode::Timeout || misses >= max_misses)
      return tl::unexpected(state.error());
  }
  if (const auto command = controller.command()) controller.sent(arm.command(*command));
  return {};
}

}  // namespace

struct ArmCommander::Threaded {
  hal::TripleBuffer<ArmView> views;
  hal::SpscRing<ArmRequest, 64> requests;
  Heartbeat task;
  std::atomic<bool> begun{false}, end{false}, ended{false};
  hal::Result<> beginning;  ///< Read once `begun`.
  hal::RealtimeReport realtime;
  std::thread thread;

  void run(hal::Arm& arm, ArmController& controller, int max_misses);
};

void ArmCommander::Threaded::run(hal::Arm& arm, ArmController& controller, int max_misses) {
  hal::name_thread("colift-arm");
  realtime = hal::ask_for_realtime({});
  beginning = begin(arm, controller, max_misses);
  if (beginning) views.write(controller.view());
  begun.store(true, std::memory_order_release);
  for (int left = beginning ? kMostCyclesAtEnd : 0, rests = 0; left > 0 && rests < kCyclesAtEnd;) {
    controller.measured(arm.wait_cycle());
    while (const auto request = requests.pop()) controller.take(*request);
    controller.heed_task(task.count());
    if (const auto command = controller.command()) controller.sent(arm.command(*command));
    const ArmView& view = controller.view();
    views.write(view);
    if (!end.load(std::memory_order_relaxed)) continue;
    --left;
    if (view.at_rest || view.link_lost) ++rests;
  }
  arm.deactivate();
  ended.store(true);
}

ArmCommander::ArmCommander(hal::Arm& arm, const hal::RobotModel& model, const planner::ArmGeometry& geometry,
                           const TaskConfig& task, const LoadConfig& load, Drive drive,
                           const SetpointLimits& limits, const ForceMonitorConfig& force)
    : arm_(arm),
      controller_(model, geometry, task, load, limits, force, arm.abilities()),
      limits_(limits),
      max_misses_(task.supervision.arm_max_misses_at_activation),
      thread_(drive == Drive::Thread ? std::make_unique<Threaded>() : nullptr) {}

ArmCommander::~ArmCommander() {
  finish();
}

hal::Result<> ArmCommander::start() {
  hal::Result<> beginning;
  if (recorded_) {
    recorded_(view_);
  } else if (thread_) {
    thread_->thread = std::thread([this] { thread_->run(arm_, controller_, max_misses_); });
    while (!thread_->begun.load(std::memory_order_acquire)) std::this_thread::sleep_for(kTaskPeriod);
    beginning = thread_->beginning;
    realtime_ = thread_->realtime.words;
    (void)thread_->views.read(view_);
  } else {
    beginning = begin(arm_, controller_, max_misses_);
    view_ = controller_.view();
  }
  started_ = beginning.has_value();
  return beginning;
}

void ArmCommander::finish() noexcept {
  if (recorded_) {
    started_ = false;
  } else if (thread_ && thread_->thread.joinable()) {
    if (started_) ask({ArmRequest::Kind::Hold, 0, nullptr, 0.0, {}});
    thread_->end = true;
    thread_->thread.join();
    (void)thread_->views.read(view_);
  } else if (started_) {
    hold();
    for (int left = kMostCyclesAtEnd, rests = 0; left > 0 && rests < kCyclesAtEnd; --left) {
      begin_cycle();
      if (view_.misses > 0) break;
      end_cycle();
      if (view_.at_rest) ++rests;
    }
    arm_.deactivate();
  }
  started_ = false;
}

void ArmCommander::begin_cycle() {
  if (recorded_) return recorded_(view_);
  if (thread_) {
    thread_->task.beat();
    std::this_thread::sleep_for(kTaskPeriod);
    (void)thread_->views.read(view_);
    return;
  }
  controller_.measured(arm_.wait_cycle());
  view_ = controller_.view();
}

void ArmCommander::end_cycle() {
  if (thread_ || recorded_) return;
  if (const auto command = controller_.command()) controller_.sent(arm_.command(*command));
  view_ = controller_.view();
}

void ArmCommander::ask(ArmRequest request) {
  request.id = ++last_id_;
  if (moves(request.kind)) motion_id_ = last_id_;
  if (recorded_) return;
  if (!thread_) {
    controller_.take(request);
    view_ = controller_.view();
    return;
  }
  thread_->task.beat();  // who has just computed for long asks now, and is there
  // full only when the arm's thread has stood still for a quarter of a second: then its link is gone, and
  // nothing that could be asked matters until it is back
  while (!thread_->requests.push(request) && !thread_->ended) std::this_thread::sleep_for(1ms);
}

void ArmCommander::hold() {
  ask({ArmRequest::Kind::Hold, 0, nullptr, 0.0, {}});
}

hal::Result<> ArmCommander::follow(const planner::Trajectory& trajectory) {
  // asked here too, where an answer can be given: the arm's cycle may be in another thread
  if (auto can = can_follow(trajectory, view_.running, at_rest(), view_.commanded_rad, limits_); !can)
    return can;
  goes_back_ = false;
  trajectories_.push_back(std::make_shared<const planner::Trajectory>(trajectory));
  ask({ArmRequest::Kind::Follow, 0, trajectories_.back(), 0.0, {}});
  return {};
}

void ArmCommander::resume(double speed) {
  goes_back_ = false;
  ask({ArmRequest::Kind::Resume, 0, nullptr, speed, {}});
}

void ArmCommander::go_slow(bool on) {
  ask({ArmRequest::Kind::Slow, 0, nullptr, on ? 1.0 : 0.0, {}});
}

void ArmCommander::set_scale(double scale) {
  ask({ArmRequest::Kind::Scale, 0, nullptr, scale, {}});
}

void ArmCommander::back(double speed) {
  goes_back_ = true;
  ask({ArmRequest::Kind::Back, 0, nullptr, speed, {}});
}

void ArmCommander::unload() {
  ask({ArmRequest::Kind::Unload, 0, nullptr, 0.0, {}});
}

void ArmCommander::ease() {
  ask({ArmRequest::Kind::Ease, 0, nullptr, 0.0, {}});
}

void ArmCommander::start_tare() {
  ask({ArmRequest::Kind::StartTare, 0, nullptr, 0.0, {}});
}

void ArmCommander::end_tare() {
  ask({ArmRequest::Kind::EndTare, 0, nullptr, 0.0, {}});
}

void ArmCommander::start_lift(LiftController::Role role, double height_m, double time_s,
                              const HandLine& line) {
  ask({ArmRequest::Kind::StartLift, 0, nullptr, height_m, role, time_s, HandLoad::Empty, line});
}

void ArmCommander::raise_on(LiftController::Role role, double height_m, double time_s, const HandLine& line) {
  ask({ArmRequest::Kind::RaiseOn, 0, nullptr, height_m, role, time_s, HandLoad::Empty, line});
}

void ArmCommander::resume_lift() {
  ask({ArmRequest::Kind::ResumeLift, 0, nullptr, 0.0, {}});
}

void ArmCommander::stay() {
  ask({ArmRequest::Kind::Stay, 0, nullptr, 0.0, {}});
}

void ArmCommander::lower() {
  ask({ArmRequest::Kind::Lower, 0, nullptr, 0.0, {}});
}

void ArmCommander::see_partner(double rise_m) {
  ask({ArmRequest::Kind::SeePartner, 0, nullptr, rise_m, {}});
}

void ArmCommander::pause() {
  ask({.kind = ArmRequest::Kind::Pause});
}

void ArmCommander::yield() {
  ask({.kind = ArmRequest::Kind::Yield});
}

void ArmCommander::expect(HandLoad load) {
  ask({.kind = ArmRequest::Kind::Expect, .load = load});
}

bool ArmCommander::blocked() const {
  return current() && (view_.blocked.why != SetpointGenerator::Contact::None || view_.trajectory_refused ||
                       view_.stalled || view_.force);
}

bool ArmCommander::touched() const {
  return blocked() && !view_.trajectory_refused && !view_.stalled;
}

std::string ArmCommander::why_blocked() const {
  if (view_.trajectory_refused) return "the arm is not on its path: it was moved meanwhile";
  if (view_.stalled) return describe_stall(view_);
  if (view_.force) return describe(view_.force);
  return describe(view_.blocked);
}

}  // namespace colift::control
