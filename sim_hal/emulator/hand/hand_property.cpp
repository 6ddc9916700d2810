#include "sim_hal/emulator/hand/hand_property.hpp"

#include <array>

namespace colift::sim_hal {
namespace {

using A = HandProperty::Access;
constexpr bool kWide = true, kShort = false;

// Numbers, widths and factory values as Barrett's clients have them.
constexpr std::array kRows{
    HandProperty{0, "VERS", kShort, A::Read, 0, 200, 200},
    HandProperty{1, "ROLE", kShort, A::Locked, 0, 0x1e05, 0x1605},
    HandProperty{2, "SN", kShort, A::Locked, 0, 1, 1},
    HandProperty{3, "ID", kShort, A::Both, 0, 11, 14},
    HandProperty{4, "ERROR", kShort, A::Read, 0, 0, 0},
    HandProperty{5, "STAT", kShort, A::Both, 0, 0, 0},
    HandProperty{6, "ADDR", kShort, A::Both, 0, 0, 0},
    HandProperty{7, "VALUE", kShort, A::Both, 0, 0, 0},
    HandProperty{8, "MODE", kShort, A::Both, 0, 0, 0},
    HandProperty{9, "TEMP", kShort, A::Read, 0, 30, 30},
    HandProperty{10, "PTEMP", kShort, A::Locked, 0, 0, 0},
    HandProperty{11, "OTEMP", kShort, A::Both, 0, 60, 60},
    HandProperty{12, "BAUD", kShort, A::Both, 0, 0, 0},
    HandProperty{13, "LOCK", kShort, A::Command, 0, 0, 0},
    HandProperty{14, "DIG0", kShort, A::Locked, 0, 0, 0},
    HandProperty{15, "DIG1", kShort, A::Locked, 0, 0, 0},
    HandProperty{16, "FET0", kShort, A::Both, 0, 0, 0},
    HandProperty{17, "FET1", kShort, A::Both, 0, 0, 0},
    HandProperty{18, "ANA0", kShort, A::Read, 0, 0, 0},
    HandProperty{19, "ANA1", kShort, A::Read, 0, 0, 0},
    HandProperty{20, "THERM", kShort, A::Read, 0, 30, 30},
    HandProperty{21, "VBUS", kShort, A::Read, 0, 48, 48},
    HandProperty{22, "IMOTOR", kShort, A::Read, 0, 2048, 2048},
    HandProperty{23, "VLOGIC", kShort, A::Read, 0, 3, 3},
    HandProperty{24, "ILOGIC", kShort, A::Read, 0, 0, 0},
    HandProperty{25, "SG", kShort, A::Read, 0, 2048, 2048},
    HandProperty{26, "GRPA", kShort, A::Both, 0, 0, 0},
    HandProperty{27, "GRPB", kShort, A::Both, 0, 7, 7},
    HandProperty{28, "GRPC", kShort, A::Both, 0, 5, 5},
    HandProperty{29, "CMD", kShort, A::Command, 0, 0, 0},
    HandProperty{30, "SAVE", kShort, A::Command, 0, 0, 0},
    HandProperty{31, "LOAD", kShort, A::Command, 0, 0, 0},
    HandProperty{32, "DEF", kShort, A::Command, 0, 0, 0},
    HandProperty{33, "FIND", kShort, A::Command, 0, 0, 0},
    HandProperty{34, "X0", kShort, A::Both, 0, 0, 0},
    HandProperty{35, "X1", kShort, A::Both, 0, 0, 0},
    HandProperty{36, "X2", kShort, A::Both, 0, 0, 0},
    HandProperty{37, "X3", kShort, A::Both, 0, 0, 0},
    HandProperty{38, "X4", kShort, A::Both, 0, 0, 0},
    HandProperty{39, "X5", kShort, A::Both, 0, 0, 0},
    HandProperty{40, "X6", kShort, A::Both, 0, 0, 0},
    HandProperty{41, "X7", kShort, A::Both, 0, 0, 0},
    HandProperty{42, "T", kShort, A::Both, 0, 0, 0},
    HandProperty{43, "MT", kShort, A::Both, 0, 2200, 2200},
    HandProperty{44, "V", kShort, A::Both, 0, 0, 0},
    HandProperty{45, "MV", kShort, A::Both, 0, 200, 50},
    HandProperty{46, "MCV", kShort, A::Both, 0, 200, 200},
    HandProperty{47, "MOV", kShort, A::Both, 0, 200, 200},
    HandProperty{48, "P", kWide, A::Both, 0, 0, 0},
    HandProperty{50, "DP", kWide, A::Both, 0, 45000, 17975},
    HandProperty{52, "E", kWide, A::Both, 0, 0, 0},
    HandProperty{54, "OT", kWide, A::Both, 0, 0, 0},
    HandProperty{56, "CT", kWide, A::Both, 0, 195000, 35950},
    HandProperty{58, "M", kWide, A::Command, 0, 0, 0},
    HandProperty{60, "DS", kShort, A::Both, 0, 25600, 25600},
    HandProperty{61, "MOFST", kShort, A::Both, 0, 0, 0},
    HandProperty{62, "IOFST", kShort, A::Both, 0, 0, 0},
    HandProperty{63, "UPSECS", kShort, A::Read, 0, 0, 0},
    HandProperty{64, "OD", kShort, A::Locked, 0, 0, 0},
    HandProperty{65, "MDS", kShort, A::Both, 0, 0, 0},
    HandProperty{66, "MECH", kWide, A::Read, 0, 0, 0},
    HandProperty{68, "CTS", kWide, A::Both, 0, 4096, 4096},
    HandProperty{70, "PIDX", kShort, A::Both, 0, 1, 4},
    HandProperty{71, "HSG", kShort, A::Both, 0, 0, 0},
    HandProperty{72, "LSG", kShort, A::Both, 0, 0, 0},
    HandProperty{73, "IVEL", kShort, A::Both, 0, -75, -75},
    HandProperty{74, "IOFF", kWide, A::Both, 0, 0, 0},
    HandProperty{76, "MPE", kShort, A::Both, 0, 0, 0},
    HandProperty{77, "HOLD", kShort, A::Both, 0, 0, 1},
    HandProperty{78, "TSTOP", kShort, A::Both, 0, 50, 150},
    HandProperty{79, "KP", kShort, A::Both, 0, 500, 1000},
    HandProperty{80, "KD", kShort, A::Both, 0, 2500, 10000},
    HandProperty{81, "KI", kShort, A::Both, 0, 0, 0},
    HandProperty{82, "ACCEL", kShort, A::Both, 0, 200, 200},
    HandProperty{83, "TENST", kShort, A::Both, 0, 0, 0},
    HandProperty{84, "TENSO", kShort, A::Both, 0, 0, 0},
    HandProperty{85, "JIDX", kShort, A::Both, 0, 8, 11},
    HandProperty{86, "IPNM", kShort, A::Both, 0, 20000, 20000},
    HandProperty{87, "HALLS", kShort, A::Locked, 0, 0, 0},
    HandProperty{88, "HALLH", kWide, A::Locked, 0, 7, 7},
    HandProperty{90, "POLES", kShort, A::Both, 0, 6, 6},
    HandProperty{91, "IKP", kShort, A::Both, 0, 500, 500},
    HandProperty{92, "IKI", kShort, A::Both, 0, 204, 204},
    HandProperty{93, "IKCOR", kShort, A::Both, 0, 102, 102},
    HandProperty{94, "EN", kWide, A::Both, 0, 0, 0},
    HandProperty{96, "JP", kWide, A::Read, 0, 0, 0},
    HandProperty{98, "JOFST", kWide, A::Both, 0, 0, 0},
    HandProperty{100, "TIE", kShort, A::Both, 0, 0, 0},
    HandProperty{101, "ECMAX", kShort, A::Read, 0, 0, 0},
    HandProperty{102, "ECMIN", kShort, A::Read, 0, 0, 0},
    HandProperty{103, "LFLAGS", kShort, A::Read, 0, 0, 0},
    HandProperty{104, "LCTC", kShort, A::Read, 0, 0, 0},
    HandProperty{105, "LCVC", kShort, A::Read, 0, 0, 0},
    HandProperty{106, "TACT", kShort, A::Both, 142, 0, 0},
    HandProperty{107, "TACTID", kShort, A::Read, 145, 1, 1},
    HandProperty{108, "IHIT", kShort, A::Both, 175, 1700, 2200},
};

constexpr auto kRowOf = [] {
  std::array<std::int8_t, 128> rows{};
  rows.fill(-1);
  for (std::size_t i = 0; i < kRows.size(); ++i)
    rows[static_cast<std::size_t>(kRows[i].number)] = static_cast<std::int8_t>(i);
  return rows;
}();

}  // namespace

const HandProperty* hand_property(int number) {
  if (number < 0 || number > 127) return nullptr;
  const auto row = kRowOf[static_cast<std::size_t>(number)];
  return row < 0 ? nullptr : &kRows[static_cast<std::size_t>(row)];
}

std::string hand_property_name(int number) {
  const HandProperty* p = hand_property(number);
  return p == nullptr ? "property " + std::to_string(number) : std::string(p->name);
}

}  // namespace colift::sim_hal
