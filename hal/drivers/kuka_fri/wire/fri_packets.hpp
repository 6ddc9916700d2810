#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace colift::hal {

// The two datagrams of KUKA's Fast Research Interface 1.x as plain values, every field by name. Layout and
// units as in the vendor's header friComm.h (rev. 1.17, 2010), which several public drivers of the LWR carry;
// states and rules as in Schreiber, Stemmer, Bischoff, "The Fast Research Interface for the KUKA Lightweight
// Robot", ICRA 2010 workshop.
//
// Frames are row-major 3 x 4: r00 r01 r02 x r10 r11 r12 y r20 r21 r22 z. What is six-dimensional goes
// X Y Z Rz Ry Rx. Joints are in the order of the arm: A1 A2 E1 A3 A4 A5 A6 of KRL.

inline constexpr std::size_t kFriMeasurementBytes = 916, kFriCommandBytes = 376;
inline constexpr std::uint16_t kFriMeasurementId = 0x2006, kFriCommandId = 0x1005;
inline constexpr std::uint16_t kFriAllDrives = 0x7F;

using FriJoints = std::array<float, 7>;
using FriFrame = std::array<float, 12>;
using FriSix = std::array<float, 6>;

enum class FriState : std::uint16_t { Off = 0, Monitor = 1, Command = 2, Invalid = 0xFFFF };
enum class FriQuality : std::uint16_t { Unacceptable = 0, Bad = 1, Ok = 2, Perfect = 3, Invalid = 0xFFFF };
/// What controls the arm, with the value of $STIFFNESS.STRATEGY: 10, 20, 30; all else is Other.
enum class FriControl : std::uint16_t { Other = 0, Position = 1, CartesianImpedance = 2, JointImpedance = 3 };

/// Which fields of a command the controller uses.
namespace fri_flag {
inline constexpr std::uint32_t kJointPosition = 0x0001, kJointTorque = 0x0004, kJointStiffness = 0x0010,
                               kJointDamping = 0x0020, kCartPosition = 0x0100, kCartWrench = 0x0400,
                               kCartStiffness = 0x1000, kCartDamping = 0x2000;
inline constexpr std::uint32_t kPositionMode = kJointPosition;
inline constexpr std::uint32_t kJointImpedance = 0x0035, kCartesianImpedance = 0x3500;
inline constexpr std::uint32_t kAll = kJointImpedance | kCartesianImpedance;
}  // namespace fri_flag

struct FriHeader {
  std::uint16_t send = 0;       ///< Counts the sender's datagrams, 65535 then 0.
  std::uint16_t reflected = 0;  ///< `send` of the last datagram that the sender received.
  std::uint16_t size = 0;       ///< Bytes.
  std::uint16_t id = 0;
  friend bool operator==(const FriHeader&, const FriHeader&) = default;
};

/// $FRI_TO_* in a measurement, $FRI_FRM_* in a command. C index = KRL index - 1, bit i = boolean i + 1.
struct KrlChannels {
  std::array<float, 16> real{};
  std::array<std::int32_t, 16> integer{};
  std::uint16_t boolean = 0;
  std::uint16_t fill = 0;
  friend bool operator==(const KrlChannels&, const KrlChannels&) = default;
};

/// From the controller to the PC.
struct FriMeasurement {
  FriHeader head{0, 0, kFriMeasurementBytes, kFriMeasurementId};
  KrlChannels krl;
  // interface
  float timestamp_s = 0;  ///< float: coarser than a millisecond after 2.3 hours.
  FriState state = FriState::Off;
  FriQuality quality = FriQuality::Unacceptable;
  float measurement_period_s = 0, command_period_s = 0;
  float safety_limits = 0;  ///< 0 to 1: part of the limits that is granted.
  float answer_rate = 0, latency_s = 0, jitter_s = 0, miss_rate = 0;  ///< Over the last 100 datagrams.
  std::uint32_t misses = 0;                                           ///< Answers that never came.
  // robot
  std::uint16_t power = 0;  ///< Bit per drive.
  FriControl control = FriControl::Other;
  std::uint16_t error = 0, warning = 0;  ///< Bit per drive.
  FriJoints temperature_c{};
  // data
  FriJoints q_measured_rad{};
  FriFrame cart_measured{};
  FriJoints q_commanded_rad{};      ///< Of KRL, before FRI.
  FriJoints q_commanded_fri_rad{};  ///< What FRI adds to it.
  FriFrame cart_commanded{};        ///< Of KRL, before FRI.
  FriFrame cart_commanded_fri{};
  FriJoints tau_measured_nm{};       ///< Link side: with gravity and dynamics.
  FriJoints tau_external_nm{};       ///< Estimate of the controller.
  FriSix wrench_external{};          ///< Fx Fy Fz Tz Ty Tx (N, N m), task frame.
  std::array<float, 42> jacobian{};  ///< 6 x 7, row-major, rows X Y Z Rz Ry Rx, task frame.
  std::array<float, 49> mass_matrix{};
  FriJoints gravity_nm{};
  friend bool operator==(const FriMeasurement&, const FriMeasurement&) = default;
};

/// From the PC to the controller.
struct FriCommand {
  FriHeader head{0, 0, kFriCommandBytes, kFriCommandId};
  KrlChannels krl;
  std::uint32_t flags = 0;  ///< fri_flag
  FriJoints q_rad{};        ///< Whole position, not an offset.
  FriFrame cart{};
  FriJoints tau_nm{};
  FriSix wrench{};  ///< Fx Fy Fz Tz Ty Tx (N, N m)
  FriJoints stiffness_nm_rad{};
  FriJoints damping{};
  FriSix cart_stiffness{};  ///< X Y Z (N/m) Rz Ry Rx (N m/rad)
  FriSix cart_damping{};
  friend bool operator==(const FriCommand&, const FriCommand&) = default;
};

}  // namespace colift::hal
