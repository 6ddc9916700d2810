#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace colift::sim_hal {

// The two datagrams of FRI 1.x as the KRC2lr sees them: little endian, IEEE-754 binary32, no padding but the
// two fill fields, no checksum. Layout: friComm.h rev. 1.17 as public copies agree on it.

inline constexpr std::size_t kMeasurementBytes = 916, kCommandBytes = 376;
inline constexpr std::uint16_t kMeasurementId = 0x2006, kCommandId = 0x1005;

enum class FriState : std::uint16_t { Off = 0, Monitor = 1, Command = 2 };
enum class FriQuality : std::uint16_t { Unacceptable = 0, Bad = 1, Ok = 2, Perfect = 3 };
/// Active controller; $STIFFNESS.STRATEGY is ten times the number.
enum class FriControl : std::uint16_t { Other = 0, Position = 1, CartesianImpedance = 2, JointImpedance = 3 };

/// Bits of cmdFlags: which fields of a command the controller uses.
namespace fri_flag {
inline constexpr std::uint32_t kJointPosition = 0x0001, kJointTorque = 0x0004, kJointStiffness = 0x0010,
                               kJointDamping = 0x0020, kCartPosition = 0x0100, kTcpWrench = 0x0400,
                               kCartStiffness = 0x1000, kCartDamping = 0x2000;
}

using Float6 = std::array<float, 6>;
using Float7 = std::array<float, 7>;
using Float12 = std::array<float, 12>;  ///< Frame: 3 x 4 row-major, [3] [7] [11] = x y z (m).

/// $FRI_TO_* or $FRI_FRM_*; index 0 is KRL's index 1, bit 0 is KRL's first boolean.
struct KrlChannels {
  std::array<float, 16> real{};
  std::array<std::int32_t, 16> integer{};
  std::uint16_t boolean = 0;
};

/// KRC to PC. Everything with six elements is in the order X Y Z, Rz Ry Rx.
struct KrcMeasurement {
  std::uint16_t send = 0, reflected = 0;
  KrlChannels krl;
  float timestamp_s = 0;
  FriState state = FriState::Off;
  FriQuality quality = FriQuality::Unacceptable;
  float measurement_period_s = 0, command_period_s = 0, safety_limits = 1;
  float answer_rate = 0, latency_s = 0, jitter_s = 0, miss_rate = 1;
  std::uint32_t missed = 0;
  std::uint16_t power = 0;  ///< Bit per drive, 0x7F all.
  FriControl control = FriControl::Other;
  std::uint16_t error = 0, warning = 0;
  Float7 temperature_c{};
  Float7 q_rad{};
  Float12 X_WT{};         ///< Measured tool frame in the base frame.
  Float7 q_krl_rad{};     ///< Commanded by KRL (cmdJntPos) ...
  Float7 q_offset_rad{};  ///< ... and what FRI adds to it.
  Float12 X_WT_krl{};     ///< Commanded by KRL ...
  Float12 X_WT_offset{};  ///< ... and what FRI adds: the total frame is their product in this order.
  Float7 tau_nm{};        ///< Sensor torque: holds the arm against gravity and contacts.
  Float7 tau_external_nm{};
  Float6 wrench_external{};             ///< Fx Fy Fz Tz Ty Tx.
  std::array<float, 42> jacobian{};     ///< 6 x 7 row-major, rows X Y Z Rz Ry Rx.
  std::array<float, 49> mass_matrix{};  ///< 7 x 7 (kg m^2).
  Float7 gravity_nm{};
};

/// PC to KRC.
struct KrcCommand {
  std::uint16_t send = 0, reflected = 0;
  KrlChannels krl;
  std::uint32_t flags = 0;
  Float7 q_rad{};
  Float12 X_WT{};
  Float7 tau_nm{};
  Float6 wrench{};  ///< Fx Fy Fz Tz Ty Tx.
  Float7 stiffness_nm_rad{}, damping{};
  Float6 cart_stiffness{}, cart_damping{};  ///< X Y Z Rz Ry Rx.
};

[[nodiscard]] std::array<std::byte, kMeasurementBytes> encode(const KrcMeasurement& measurement);

/// Why a datagram is no command.
enum class NoCommand { WrongLength, WrongId, WrongSizeField };
[[nodiscard]] std::string_view words(NoCommand why);

/// Looks at length, id and size field only: what the fields say is the rules' business (krc_rules.hpp).
struct DecodedCommand {
  std::optional<KrcCommand> command;
  NoCommand why = NoCommand::WrongLength;
};
[[nodiscard]] DecodedCommand decode_command(std::span<const std::byte> bytes);

}  // namespace colift::sim_hal
