#include "tools/experiments/trials/direct_lift.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "control/arm/arm_commander.hpp"
#include "hal/guards/guarded_arm.hpp"
#include "hal/guards/guarded_hand.hpp"
#include "hal/types/units.hpp"
#include "sim_hal/mujoco/devices/sim_devices.hpp"

namespace colift::experiments {
namespace {

constexpr double kTare_s = 0.2, kClosing_s = 0.1, kSettle_s = 0.3, kReady_s = 0.5;
constexpr double kTooLong_s = 23.0;  // beside the lift itself, which may be slowed
constexpr double kGone_m = 0.05;     // an object that moved so far in the hand is not held

enum class Phase { Tare, Approach, Close, Ready, Lift, Stop, Hold, Over };

/// One lift while it goes on.
class Lift {
 public:
  Lift(sim_hal::SimWorld& world, const planner::MotionPlan& plan, const control::Config& config,
       const LiftObserver& eye)
      : world_(world),
        plan_(plan),
        config_(config),
        eye_(eye),
        arm_(sim_hal::make_sim_arm(world), world.model(), config.guard_arm),
        hand_(sim_hal::make_sim_hand(world), config.guard_hand),
        geometry_(planner::arm_geometry(world.model()).value()),
        commander_(arm_, world.model(), geometry_, config.task, config.load, control::Drive::InStep,
                   config.setpoints) {}

  hal::Result<DirectLift> run() {
    if (auto ok = arm_.configure(); !ok) return tl::unexpected(ok.error());
    if (auto ok = hand_.configure(); !ok) return tl::unexpected(ok.error());
    if (auto ok = hand_.activate(); !ok) return tl::unexpected(ok.error());
    if (auto ok = commander_.start(); !ok) return tl::unexpected(ok.error());
    if (auto ok = hand_.preshape(0.0); !ok) return tl::unexpected(ok.error());
    if (eye_) {
      camera_ = sim_hal::make_sim_camera(world_);
      if (auto ok = camera_->configure(); !ok) return tl::unexpected(ok.error());
      if (auto ok = camera_->activate(); !ok) return tl::unexpected(ok.error());
    }
    commander_.start_tare();
    while (phase_ != Phase::Over) {
      commander_.begin_cycle();
      now_s_ = hal::seconds(world_.elapsed());
      step();
      commander_.end_cycle();
      if (now_s_ > kTooLong_s + config_.task.lift_s / (eye_ ? config_.task.slow_fraction : 1.0))
        end("it takes too long");
      if (commander_.blocked()) end("the arm met something: " + commander_.why_blocked());
    }
    commander_.finish();
    return out_;
  }

 private:
  void go(Phase next) {
    phase_ = next;
    since_s_ = now_s_;
  }
  void end(std::string reason) {
    if (phase_ == Phase::Over) return;
    out_.reason = std::move(reason);
    out_.hit_something = world_.truth().robot_hit_something;
    go(Phase::Over);
  }
  [[nodiscard]] double in_phase_s() const { return now_s_ - since_s_; }

  control::Raise observe(const hal::HandState& hand, LiftPart part) {
    if (!eye_) return control::Raise::On;
    if (auto frame = camera_->next_frame(std::chrono::milliseconds(0)))
      raise_ = eye_(std::move(*frame), {commander_.view().state.q_rad, hal::posture_of(hand)}, part);
    return raise_;
  }

  void step() {
    const auto state = hand_.state();
    if (!state) return end(state.error().text());
    if (phase_ >= Phase::Ready)
      out_.most_tilt_deg = std::max(out_.most_tilt_deg, hal::rad_to_deg(world_.truth().tilt_rad));
    switch (phase_) {
      case Phase::Tare:
        if (in_phase_s() < kTare_s || state->moving) return;
        commander_.end_tare();
        if (auto way = commander_.follow(plan_.approach); !way) return end(way.error().text());
        return go(Phase::Approach);
      case Phase::Approach:
        if (!commander_.done() || !commander_.at_rest()) return;
        if (auto closing = hand_.close(config_.task.close_torque_nm); !closing)
          return end(closing.error().text());
        return go(Phase::Close);
      case Phase::Close:
        observe(*state, LiftPart::Before);
        if (state->moving || in_phase_s() < kClosing_s) return;
        if (!state->held) return end("the fingers met nothing");
        return go(Phase::Ready);
      case Phase::Ready:
        observe(*state, LiftPart::Before);
        if (in_phase_s() < kReady_s) return;
        out_.held = state->held && world_.truth().robot_touches_object;
        if (!out_.held) return end("the hand closed, and does not touch the object");
        commander_.start_lift(control::LiftController::Role::Lead, config_.task.lift_height_m,
                              config_.task.lift_s);
        return go(Phase::Lift);
      case Phase::Lift:
        if (commander_.end_of_reach()) return end("the arm has come to the end of its reach");
        out_.slip_m = world_.truth().slip_m;
        raise(observe(*state, LiftPart::Raising));
        if (phase_ != Phase::Lift) return;
        if (!commander_.lift_at_rest()) at_rest_s_ = now_s_;
        if (now_s_ - at_rest_s_ < kSettle_s) return;
        return go(Phase::Hold);
      case Phase::Stop:
        observe(*state, LiftPart::Raising);
        if (in_phase_s() < kSettle_s) return;
        return go(Phase::Hold);
      case Phase::Hold:
        observe(*state, LiftPart::Top);
        return hold(state->held);
      case Phase::Over:
        return;
    }
  }

  void raise(control::Raise how) {
    if (how == control::Raise::Enough) {
      commander_.hold();
      return go(Phase::Stop);
    }
    const bool slowly = how == control::Raise::Slowly;
    if (slowly != slow_) commander_.go_slow(slowly);
    slow_ = slowly;
  }

  void hold(bool held) {
    const sim_hal::SimTruth truth = world_.truth();
    ++n_;
    tilt_ += hal::rad_to_deg(truth.tilt_rad);
    height_ += truth.height_m;
    robot_n_ += truth.robot_force_W.z();
    share_ += truth.robot_force_W.z() /
              (truth.robot_force_W.z() + truth.partner_force_W.z() + truth.floor_force_W.z());
    out_.slip_m = std::max(out_.slip_m, truth.slip_m);
    const control::ArmView& view = commander_.view();
    if (view.wrench_W) {
      out_.measured.force += view.wrench_W->force;
      out_.measured.torque += view.wrench_W->torque;
      out_.palm_W += hal::hand_pose(world_.model(), view.state.q_rad).translation();
    }
    if (in_phase_s() < config_.task.hold_s) return;
    out_.tilt_deg = tilt_ / n_;
    out_.height_m = height_ / n_;
    out_.robot_n = robot_n_ / n_;
    out_.share_robot = share_ / n_;
    out_.measured.force /= n_;
    out_.measured.torque /= n_;
    out_.palm_W /= n_;
    out_.lifted = held && truth.robot_touches_object && out_.slip_m < kGone_m;
    end(out_.lifted ? ""
                    : fmt::format("the hand lost the object, which slipped {:.0f} mm", 1e3 * out_.slip_m));
  }

  sim_hal::SimWorld& world_;
  const planner::MotionPlan& plan_;
  const control::Config& config_;
  const LiftObserver& eye_;
  std::unique_ptr<hal::DepthCamera> camera_;
  hal::GuardedArm arm_;
  hal::GuardedHand hand_;
  planner::ArmGeometry geometry_;
  control::ArmCommander commander_;
  Phase phase_ = Phase::Tare;
  control::Raise raise_ = control::Raise::On;
  bool slow_ = false;
  double now_s_ = 0.0, since_s_ = 0.0, at_rest_s_ = 0.0;
  DirectLift out_;
  int n_ = 0;
  double tilt_ = 0.0, height_ = 0.0, robot_n_ = 0.0, share_ = 0.0;
};

}  // namespace

hal::Result<DirectLift> lift_directly(sim_hal::Scenario scenario, const planner::MotionPlan& plan,
                                      const control::Config& config, std::uint64_t seed,
                                      const LiftObserver& eye) {
  scenario.partner.arrives_s = 0.1;
  scenario.partner.events.clear();
  scenario.faults.clear();
  sim_hal::SimConfig sim;
  sim.start_rad = plan.approach.start();
  auto world = sim_hal::SimWorld::make(scenario, hal::built_in_robot(), seed, sim);
  if (!world) return tl::unexpected(world.error());
  return Lift(**world, plan, config, eye).run();
}

}  // namespace colift::experiments
