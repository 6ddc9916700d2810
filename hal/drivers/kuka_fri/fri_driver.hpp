#pragma once

#include <atomic>
#include <memory>

#include "hal/arm.hpp"
#include "hal/drivers/kuka_fri/cart_set_point.hpp"
#include "hal/drivers/kuka_fri/fri_config.hpp"
#include "hal/drivers/kuka_fri/fri_exchange.hpp"
#include "hal/drivers/kuka_fri/fri_status.hpp"
#include "hal/drivers/kuka_fri/wire/packet_clock.hpp"
#include "hal/drivers/kuka_fri/wire/sample_period.hpp"
#include "hal/types/latest_value.hpp"
#include "hal/types/spsc_ring.hpp"

namespace colift::hal {

/// FriConfig's words as what the driver works with.
struct FriMode {
  FriControl control = FriControl::JointImpedance;
  std::int32_t strategy = 30;
  std::uint32_t flags = fri_flag::kJointImpedance;
  [[nodiscard]] static FriMode of(const std::string& control, bool null_space_posture);
};

/// One cycle of the connection: a datagram goes through the session, the hand-shake and the set points, and
/// an answer is made of them. FriArm decides when. Real-time safe after open().
class FriDriver {
 public:
  FriDriver(const FriConfig& config, const Endpoint& krc, std::unique_ptr<DatagramLink> link,
            const Clock& clock);

  /// As new, but time goes on. Before the link is opened anew.
  void reset();
  /// Another strategy from now on. In monitor mode: the flags change with it.
  void set_control(const std::string& control);

  enum class Took { Packet, Nothing, Broken };
  /// Waits for the next datagram, about one and a half periods; what it says goes through everything.
  Took take();
  /// Whose content cannot be, so far.
  [[nodiscard]] std::uint64_t unsound_datagrams() const;
  /// Answers the datagram that was taken, once.
  void answer();
  /// take(), and at once the answer that needs no user.
  Took exchange();

  /// A command of the user; on None it is part of the next answer.
  FriLimit set(const ImpedanceCommand& c);
  FriLimit set_position(const JointVector& q_rad);
  FriLimit set(const JointVector* posture_rad, const Pose& X, const SixVector& stiffness,
               const SixVector& damping_ratio, const SixVector& wrench);
  void count_refused(const FriLimit& limit);

  [[nodiscard]] ArmState state() const;
  void publish();

  FriConfig config;
  FriMode mode;
  const Clock& clock;
  FriExchange wire;
  SessionMachine session;
  std::unique_ptr<HandShake> hand_shake;
  FriMeasurement m;    ///< The last good datagram.
  bool open = false;   ///< It has no answer yet.
  bool seen = false;   ///< There was one.
  bool quiet = false;  ///< All of KRL's variables are sent as 0.
  FriStatus status;

  LatestValue<FriStatus> latest_status;
  LatestValue<FriMeasurement> latest_measurement;
  SpscRing<FriEvent, 256> events;

 private:
  void note_stall(Timestamp asked, Timestamp until);
  /// Why it is not certain that the sender is the KRC; None when it is.
  [[nodiscard]] FriReason sender_doubt() const;
  void note_misses(bool first);
  void move_set_points(const FriExchange::Packet& packet, bool may_before);
  void brake();
  void start_gains();
  [[nodiscard]] bool mirrors_joints() const;
  /// Without a datagram for so long the link counts as lost: with a long period not after a few of them (s).
  [[nodiscard]] double lost_after_s() const;
  /// Part of the limits that the controller grants.
  [[nodiscard]] double granted() const {
    return m.safety_limits > 0.0F ? static_cast<double>(m.safety_limits) : 1.0;
  }
  void bear_load();

  JointSetPoint joint_;
  CartSetPoint cart_;
  PacketClock packet_clock_;
  Timestamp measured_at_{0}, arrived_at_{0}, due_{0};
  std::uint64_t unsound_before_ = 0;  ///< Datagrams with content that cannot be, up to the last usable one.
  SamplePeriod sample_;
  double period_s_;         ///< Of sample_: time ...
  double limit_s_;          ///< ... and what a step may use.
  int steps_ = 1;           ///< Periods that the open cycle's command may span.
  bool commanded_ = false;  ///< The open cycle has the user's command.
  bool led_ = false;        ///< The open cycle's set point was mirrored or braked already.
  bool first_ = false;      ///< The next command is a first one.
  // how long this thread did not run although a datagram was due
  Timestamp left_at_{0}, commanding_since_{0};
  double stall_s_ = 0.0;
  // the KRC's count of misses one to two seconds ago, while it was commanded
  Timestamp misses_at_{0};
  std::uint32_t misses_ = 0, misses_before_ = 0;
  KrlChannels krl_;
  JointVector tau_ = JointVector::Zero(), stiffness_, damping_;
  SixVector wrench_ = SixVector::Zero(), cart_stiffness_, cart_damping_;
  SixVector hangs_ = SixVector::Zero();  ///< What keeps up the load that hung there before command mode,
  SixVector borne_ = SixVector::Zero();  ///< and how much of it is added by now.
};

}  // namespace colift::hal
