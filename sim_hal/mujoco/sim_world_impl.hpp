#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <optional>
#include <vector>

#include "hal/os/inheriting_mutex.hpp"
#include "sim_hal/mujoco/arm_control.hpp"
#include "sim_hal/mujoco/engine/physics.hpp"
#include "sim_hal/mujoco/sim_helpers.hpp"
#include "sim_hal/mujoco/sim_partner.hpp"
#include "sim_hal/mujoco/sim_people.hpp"
#include "sim_hal/mujoco/sim_person.hpp"
#include "sim_hal/mujoco/sim_world.hpp"
#include "sim_hal/mujoco/support_block.hpp"

namespace colift::sim_hal {

inline constexpr hal::Duration kTick = std::chrono::milliseconds(1);

/// Moved by one thread, read by others.
class WorldClock final : public hal::Clock {
 public:
  [[nodiscard]] hal::Timestamp now() const override { return hal::Timestamp(now_.load()); }
  void set(hal::Timestamp now) { now_ = now.count(); }
  void advance(hal::Duration by) { now_.fetch_add(by.count()); }

 private:
  std::atomic<hal::Timestamp::rep> now_{0};
};

struct SimWorld::Impl {
  hal::InheritingMutex mutex = {};  // of everything below; the clock is read without it
  Scenario scenario;
  hal::RobotModel model;
  ObjectParts object;
  SimConfig config;
  std::uint64_t seed;
  std::unique_ptr<Physics> physics;
  ArmControl arm;
  HandDrive hand;
  SimPartner partner;
  SimHelpers helpers = {};
  std::optional<SupportBlock> support;
  bool support_stands = false;
  WorldClock clock = {};
  std::atomic<hal::Timestamp::rep> start{0};
  std::vector<PartnerFigure> figures = {};  // one for each of the partner's holds
  struct Aside {
    Vec3 shoulder_W = Vec3::Zero();  // from the contact, when he has stepped aside
    double from_s = 0.0;
  };
  std::vector<std::optional<Aside>> aside = {};  // of each figure
  std::vector<Shape> clutter;
  SimPeople people;
  bool clutter_moves = false;
  std::vector<std::string> entered = {};  // states of the task
  std::function<void(const TickReport&)> observer = {};
  hal::JointVector command_rad = {};
  bool commanded = false;

  ArmReading arm_reading = {};
  HandReading hand_reading = {};
  hal::JointVector external_nm = hal::JointVector::Zero();
  std::optional<SimPartner::Action> partner_action = {};
  Pose X_WT0 = Pose::Identity();

  // the grasp: which one counts, where its middle lies, and how the object lay in the palm
  int grasp = 0;
  Vec3 grip_T = Vec3::Zero();
  std::optional<Vec3> robot_T = {};  // the last grasp that had the object
  Pose X_HT_locked = Pose::Identity();

  void tick();
  void push();
  [[nodiscard]] bool pushed() const;
  void note_grasp();
  [[nodiscard]] Pose palm() const { return physics->link_pose(model.palm); }
  [[nodiscard]] double now_s() const { return hal::seconds(clock.now() - hal::Timestamp(start.load())); }
  void place_partners();
  [[nodiscard]] World around_partner() const;  ///< Where he cannot stand.
  bool partner_steps_aside(const Vec3& direction_W);
  void report();
  [[nodiscard]] SimTruth truth() const;
  [[nodiscard]] hal::HandState hand_state() const;
  [[nodiscard]] SimPeople::Figure partner_figure() const;
  void move_clutter();
  /// The object's pieces at a pose, for the camera and for people.
  [[nodiscard]] std::vector<Shape> object_shapes(const Pose& X_WT) const;
};

}  // namespace colift::sim_hal
