#pragma once

#include <cstdint>
#include <string_view>

namespace colift::hal::barrett {

/// Numbers of the puck's properties as they stand in byte 0 of a frame (firmware 132 and later). Written by
/// nobody here: ADDR, VALUE, BAUD, LOCK, SAVE, LOAD, DEF and the motor's electronics.
enum class Property : std::uint8_t {
  Vers = 0,
  Role = 1,
  Sn = 2,
  Id = 3,
  Error = 4,
  Stat = 5,
  Addr = 6,
  Value = 7,
  Mode = 8,
  Temp = 9,
  Ptemp = 10,
  Otemp = 11,
  Baud = 12,
  Lock = 13,
  Dig0 = 14,
  Dig1 = 15,
  Fet0 = 16,
  Fet1 = 17,
  Ana0 = 18,
  Ana1 = 19,
  Therm = 20,
  Vbus = 21,
  Imotor = 22,
  Vlogic = 23,
  Ilogic = 24,
  Sg = 25,
  GrpA = 26,
  GrpB = 27,
  GrpC = 28,
  Cmd = 29,
  Save = 30,
  Load = 31,
  Def = 32,
  Find = 33,
  X0 = 34,
  X1 = 35,
  X2 = 36,
  X3 = 37,
  X4 = 38,
  X5 = 39,
  X6 = 40,
  X7 = 41,
  T = 42,
  Mt = 43,
  V = 44,
  Mv = 45,
  Mcv = 46,
  Mov = 47,
  P = 48,
  Dp = 50,
  E = 52,
  Ot = 54,
  Ct = 56,
  M = 58,
  Ds = 60,
  Mofst = 61,
  Iofst = 62,
  Upsecs = 63,
  Od = 64,
  Mds = 65,
  Mech = 66,
  Cts = 68,
  Pidx = 70,
  Hsg = 71,
  Lsg = 72,
  Ivel = 73,
  Ioff = 74,
  Mpe = 76,
  Hold = 77,
  Tstop = 78,
  Kp = 79,
  Kd = 80,
  Ki = 81,
  Accel = 82,
  Tenst = 83,
  Tenso = 84,
  Jidx = 85,
  Ipnm = 86,
  Halls = 87,
  Hallh = 88,
  Poles = 90,
  Ikp = 91,
  Iki = 92,
  Ikcor = 93,
  En = 94,
  Jp = 96,
  Jofst = 98,
  Tie = 100,
  Ecmax = 101,
  Ecmin = 102,
  Lflags = 103,
  Lctc = 104,
  Lcvc = 105,
  Tact = 106,
  Tactid = 107,
  Ihit = 108,
};

struct PropertyInfo {
  std::string_view name;  ///< The maker's, in capitals.
  std::uint8_t bits;      ///< 16 or 32 on the wire.
  bool readable, writable;
};

/// Null for a number that no firmware of the hand has, and for the second word of a 32-bit property.
[[nodiscard]] const PropertyInfo* property_info(std::uint8_t number) noexcept;
[[nodiscard]] const PropertyInfo& property_info(Property property) noexcept;

// values of STAT
inline constexpr int kStatReset = 0, kStatError = 1, kStatReady = 2;
// values of MODE
inline constexpr int kModeIdle = 0, kModePid = 3, kModeTrapezoid = 5;
// values of CMD
inline constexpr int kCmdInitialise = 13;
// values of ROLE: the product in the low five bits, options above
inline constexpr int kRoleProduct = 0x1f, kProductHand = 5, kRoleStrain = 0x0800, kRoleTactile = 0x1000;
// values of TACT
inline constexpr int kTactOff = 0, kTactTop10 = 1, kTactFull = 2, kTactTare = 3;
inline constexpr int kTactidBroken = -2;

}  // namespace colift::hal::barrett
