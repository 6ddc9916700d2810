#include "control/arm/arm_loop.hpp"

#include <atomic>
#include <thread>

#include "hal/os/realtime.hpp"
#include "hal/types/spsc_ring.hpp"
#include "hal/types/triple_buffer.hpp"

namespace colift::control {
namespace {

using namespace std::chrono_literals;

constexpr int kCyclesAtEnd = 20;  // the arm gets its last set point some more times before it is left alone
constexpr int kMostCyclesAtEnd = 1000;
constexpr int kMissesAtStart = 50;
constexpr auto kTaskPeriod = 4ms;  // of a task that does not run the arm's cycle itself

bool moves(ArmRequest::Kind kind) {
  using Kind = ArmRequest::Kind;
  return kind == Kind::Hold || kind == Kind::Follow || kind == Kind::Resume || kind == Kind::Back ||
         kind == Kind::StartLift || kind == Kind::RaiseOn || kind == Kind::Stay || kind == Kind::Lower;
}

/// Activation and the first good cycle, in the thread that makes all the others.
hal::Result<> begin(hal::Arm& arm, ArmMotion& motion) {
  if (auto active = arm.activate(); !active) return active;
  for (int misses = 0;; ++misses) {
    const auto state = arm.wait_cycle();
    motion.measured(state);
    if (state) break;
    if (state.error().code != hal::ErrorCode::Timeout || misses >= kMissesAtStart)
      return tl::unexpected(state.error());
  }
  if (const auto command = motion.command()) motion.sent(arm.command(*command));
  return {};
}

}  // namespace

struct ArmLoop::Threaded {
  hal::TripleBuffer<ArmView> views;
  hal::SpscRing<ArmRequest, 64> requests;
  std::atomic<bool> begun{false}, end{false}, ended{false};
  hal::Result<> beginning;  ///< Read once `begun`.
  hal::RealtimeReport realtime;
  std::thread thread;

  void run(hal::Arm& arm, ArmMotion& motion);
};

void ArmLoop::Threaded::run(hal::Arm& arm, ArmMotion& motion) {
  realtime = hal::ask_for_realtime({});
  beginning = begin(arm, motion);
  if (beginning) views.write(motion.view());
  begun.store(true, std::memory_order_release);
  for (int left = beginning ? kMostCyclesAtEnd : 0, rests = 0; left > 0 && rests < kCyclesAtEnd;) {
    motion.measured(arm.wait_cycle());
    while (const auto request = requests.pop()) motion.take(*request);
    if (const auto command = motion.command()) motion.sent(arm.command(*command));
    const ArmView& view = motion.view();
    views.write(view);
    if (!end.load(std::memory_order_relaxed)) continue;
    --left;
    if (view.at_rest || view.link_lost) ++rests;
  }
  arm.deactivate();
  ended.store(true);
}

ArmLoop::ArmLoop(hal::Arm& arm, const hal::RobotModel& model, const planner::ArmGeometry& geometry,
                 const TaskConfig& task, const LoadConfig& load, Drive drive, const CycleLimits& limits)
    : arm_(arm),
      motion_(model, geometry, task, load, limits),
      limits_(limits),
      thread_(drive == Drive::Thread ? std::make_unique<Threaded>() : nullptr) {}

ArmLoop::~ArmLoop() {
  finish();
}

hal::Result<> ArmLoop::start() {
  hal::Result<> beginning;
  if (recorded_) {
    recorded_(view_);
  } else if (thread_) {
    thread_->thread = std::thread([this] { thread_->run(arm_, motion_); });
    while (!thread_->begun.load(std::memory_order_acquire)) std::this_thread::sleep_for(kTaskPeriod);
    beginning = thread_->beginning;
    realtime_ = thread_->realtime.words;
    (void)thread_->views.read(view_);
  } else {
    beginning = begin(arm_, motion_);
    view_ = motion_.view();
  }
  started_ = beginning.has_value();
  return beginning;
}

void ArmLoop::finish() noexcept {
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

void ArmLoop::begin_cycle() {
  if (recorded_) return recorded_(view_);
  if (thread_) {
    std::this_thread::sleep_for(kTaskPeriod);
    (void)thread_->views.read(view_);
    return;
  }
  motion_.measured(arm_.wait_cycle());
  view_ = motion_.view();
}

void ArmLoop::end_cycle() {
  if (thread_ || recorded_) return;
  if (const auto command = motion_.command()) motion_.sent(arm_.command(*command));
  view_ = motion_.view();
}

void ArmLoop::ask(ArmRequest request) {
  request.id = ++last_id_;
  if (moves(request.kind)) motion_id_ = last_id_;
  if (recorded_) return;
  if (!thread_) {
    motion_.take(request);
    view_ = motion_.view();
    return;
  }
  // full only when the arm's thread has stood still for a quarter of a second: then its link is gone, and
  // nothing that could be asked matters until it is back
  while (!thread_->requests.push(request) && !thread_->ended) std::this_thread::sleep_for(1ms);
}

void ArmLoop::hold() {
  ask({ArmRequest::Kind::Hold, 0, nullptr, 0.0, {}});
}

hal::Result<> ArmLoop::follow(const planner::Trajectory& way) {
  // asked here too, where an answer can be given: the arm's cycle may be in another thread
  if (auto can = can_follow(way, view_.running, at_rest(), view_.commanded_rad, limits_); !can) return can;
  ways_.push_back(std::make_shared<const planner::Trajectory>(way));
  ask({ArmRequest::Kind::Follow, 0, ways_.back(), 0.0, {}});
  return {};
}

void ArmLoop::resume(double speed) {
  ask({ArmRequest::Kind::Resume, 0, nullptr, speed, {}});
}

void ArmLoop::go_slow(bool on) {
  ask({ArmRequest::Kind::Slow, 0, nullptr, on ? 1.0 : 0.0, {}});
}

void ArmLoop::back(double speed) {
  ask({ArmRequest::Kind::Back, 0, nullptr, speed, {}});
}

void ArmLoop::unload() {
  ask({ArmRequest::Kind::Unload, 0, nullptr, 0.0, {}});
}

void ArmLoop::start_tare() {
  ask({ArmRequest::Kind::StartTare, 0, nullptr, 0.0, {}});
}

void ArmLoop::end_tare() {
  ask({ArmRequest::Kind::EndTare, 0, nullptr, 0.0, {}});
}

void ArmLoop::start_lift(LiftController::Role role, double height_m, double time_s) {
  ask({ArmRequest::Kind::StartLift, 0, nullptr, height_m, role, time_s});
}

void ArmLoop::raise_on(LiftController::Role role, double height_m, double time_s) {
  ask({ArmRequest::Kind::RaiseOn, 0, nullptr, height_m, role, time_s});
}

void ArmLoop::stay() {
  ask({ArmRequest::Kind::Stay, 0, nullptr, 0.0, {}});
}

void ArmLoop::lower() {
  ask({ArmRequest::Kind::Lower, 0, nullptr, 0.0, {}});
}

void ArmLoop::see_partner(double rise_m) {
  ask({ArmRequest::Kind::SeePartner, 0, nullptr, rise_m, {}});
}

bool ArmLoop::blocked() const {
  return current() && (view_.blocked.why != ArmCycle::Contact::None || view_.way_refused);
}

std::string ArmLoop::why_blocked() const {
  if (view_.way_refused) return "the arm does not stand on its way: it was moved in the meantime";
  return describe(view_.blocked);
}

}  // namespace colift::control
