#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "hal/drivers/kuka_fri/wire/fri_packets.hpp"

namespace colift::hal {

/// Why bytes are not a datagram of FRI.
enum class FriRefusal : std::uint8_t {
  None,
  Size,
  HeaderId,
  HeaderSize,
  NotFinite,  // of a command
  NotFiniteKrl,
  NotFiniteLink,
  NotFiniteTemperature,
  NotFiniteJoint,
  NotFiniteFrame,
  NotFiniteTorque,
  NotFiniteModel,
  State,
  Quality,
  Control,
  SampleTime,
  SafetyLimits,
  Statistics,
  Temperature,
  JointPosition,
  CartesianPose,
  JointTorque,
  Wrench,
  Jacobian,
  MassMatrix,
  Flags,
  Stiffness,
  Damping,
};
inline constexpr std::size_t kFriRefusals = 28;
[[nodiscard]] std::string_view to_string(FriRefusal refusal) noexcept;

/// What decoding looks at besides the size. Some servers leave their header empty: then `header` is off.
struct FriChecks {
  bool header = true;
  bool values = true;  ///< Not finite, outside an enumeration, beyond what the arm can be.
};

/// Little-endian bytes into a value. On refusal `out` is as it was. Real-time safe.
[[nodiscard]] FriRefusal decode(std::span<const std::byte> bytes, FriMeasurement& out,
                                FriChecks checks = {}) noexcept;
[[nodiscard]] FriRefusal decode(std::span<const std::byte> bytes, FriCommand& out,
                                FriChecks checks = {}) noexcept;

/// The value as it is, header too: counters, size and id are the caller's.
void encode(const FriMeasurement& value, std::span<std::byte, kFriMeasurementBytes> bytes) noexcept;
void encode(const FriCommand& value, std::span<std::byte, kFriCommandBytes> bytes) noexcept;

/// The values of a measurement or command alone: can an LWR's controller mean this?
[[nodiscard]] FriRefusal implausible(const FriMeasurement& value) noexcept;
[[nodiscard]] FriRefusal implausible(const FriCommand& value) noexcept;

}  // namespace colift::hal
