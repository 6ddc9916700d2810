#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace colift::sim_hal {

/// Numbers of the properties that the emulated firmware does something with; hand_property.cpp has them all.
namespace prop {
inline constexpr int kVers = 0, kRole = 1, kSn = 2, kId = 3, kError = 4, kStat = 5, kMode = 8, kTemp = 9,
                     kPtemp = 10, kOtemp = 11, kTherm = 20, kVbus = 21, kImotor = 22, kSg = 25, kGrpA = 26,
                     kGrpB = 27, kGrpC = 28, kCmd = 29, kSave = 30, kLoad = 31, kDef = 32, kT = 42, kMt = 43,
                     kV = 44, kMv = 45, kMcv = 46, kMov = 47, kP = 48, kDp = 50, kE = 52, kOt = 54, kCt = 56,
                     kM = 58, kDs = 60, kUpsecs = 63, kPidx = 70, kHsg = 71, kLsg = 72, kIvel = 73,
                     kHold = 77, kTstop = 78, kAccel = 82, kJp = 96, kTact = 106, kTactid = 107, kIhit = 108;
}  // namespace prop

/// A property as the firmware from version 132 on has it.
struct HandProperty {
  enum class Access : std::uint8_t { Read, Write, Both, Locked, Command };
  int number = 0;
  std::string_view name;
  bool wide = false;  ///< 32 bits on the wire.
  Access access = Access::Both;
  int since = 0;                        ///< Firmware.
  std::int32_t finger = 0, spread = 0;  ///< The factory's values.

  [[nodiscard]] bool readable() const { return access != Access::Write && access != Access::Command; }
  [[nodiscard]] bool writable() const { return access != Access::Read && access != Access::Locked; }
};

/// Null: no firmware has it, or it is the second word of a 32-bit one.
[[nodiscard]] const HandProperty* hand_property(int number);
/// Its name, or "property NUMBER".
[[nodiscard]] std::string hand_property_name(int number);

}  // namespace colift::sim_hal
