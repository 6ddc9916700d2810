#include "hal/drivers/barrett_can/pucks/puck_property.hpp"

#include <array>
#include <cassert>
#include <utility>

namespace colift::hal::barrett {
namespace {

// name, bits, readable, writable (locked properties count as not writable); numbers and widths agree in the
// maker's library, its Python client and its older C library
constexpr std::pair<Property, PropertyInfo> kList[] = {
    {Property::Vers, {"VERS", 16, true, false}},
    {Property::Role, {"ROLE", 16, true, false}},
    {Property::Sn, {"SN", 16, true, false}},
    {Property::Id, {"ID", 16, true, true}},
    {Property::Error, {"ERROR", 16, true, false}},
    {Property::Stat, {"STAT", 16, true, true}},
    {Property::Addr, {"ADDR", 16, true, true}},
    {Property::Value, {"VALUE", 16, true, true}},
    {Property::Mode, {"MODE", 16, true, true}},
    {Property::Temp, {"TEMP", 16, true, false}},
    {Property::Ptemp, {"PTEMP", 16, true, false}},
    {Property::Otemp, {"OTEMP", 16, true, true}},
    {Property::Baud, {"BAUD", 16, true, true}},
    {Property::Lock, {"LOCK", 16, false, true}},
    {Property::Dig0, {"DIG0", 16, true, false}},
    {Property::Dig1, {"DIG1", 16, true, false}},
    {Property::Fet0, {"FET0", 16, true, true}},
    {Property::Fet1, {"FET1", 16, true, true}},
    {Property::Ana0, {"ANA0", 16, true, false}},
    {Property::Ana1, {"ANA1", 16, true, false}},
    {Property::Therm, {"THERM", 16, true, false}},
    {Property::Vbus, {"VBUS", 16, true, false}},
    {Property::Imotor, {"IMOTOR", 16, true, false}},
    {Property::Vlogic, {"VLOGIC", 16, true, false}},
    {Property::Ilogic, {"ILOGIC", 16, true, false}},
    {Property::Sg, {"SG", 16, true, false}},
    {Property::GrpA, {"GRPA", 16, true, true}},
    {Property::GrpB, {"GRPB", 16, true, true}},
    {Property::GrpC, {"GRPC", 16, true, true}},
    {Property::Cmd, {"CMD", 16, false, true}},
    {Property::Save, {"SAVE", 16, false, true}},
    {Property::Load, {"LOAD", 16, false, true}},
    {Property::Def, {"DEF", 16, false, true}},
    {Property::Find, {"FIND", 16, false, true}},
    {Property::X0, {"X0", 16, true, true}},
    {Property::X1, {"X1", 16, true, true}},
    {Property::X2, {"X2", 16, true, true}},
    {Property::X3, {"X3", 16, true, true}},
    {Property::X4, {"X4", 16, true, true}},
    {Property::X5, {"X5", 16, true, true}},
    {Property::X6, {"X6", 16, true, true}},
    {Property::X7, {"X7", 16, true, true}},
    {Property::T, {"T", 16, true, true}},
    {Property::Mt, {"MT", 16, true, true}},
    {Property::V, {"V", 16, true, true}},
    {Property::Mv, {"MV", 16, true, true}},
    {Property::Mcv, {"MCV", 16, true, true}},
    {Property::Mov, {"MOV", 16, true, true}},
    {Property::P, {"P", 32, true, true}},
    {Property::Dp, {"DP", 32, true, true}},
    {Property::E, {"E", 32, true, true}},
    {Property::Ot, {"OT", 32, true, true}},
    {Property::Ct, {"CT", 32, true, true}},
    {Property::M, {"M", 32, false, true}},
    {Property::Ds, {"DS", 16, true, true}},
    {Property::Mofst, {"MOFST", 16, true, true}},
    {Property::Iofst, {"IOFST", 16, true, true}},
    {Property::Upsecs, {"UPSECS", 16, true, false}},
    {Property::Od, {"OD", 16, true, false}},
    {Property::Mds, {"MDS", 16, true, true}},
    {Property::Mech, {"MECH", 32, true, false}},
    {Property::Cts, {"CTS", 32, true, true}},
    {Property::Pidx, {"PIDX", 16, true, true}},
    {Property::Hsg, {"HSG", 16, true, true}},
    {Property::Lsg, {"LSG", 16, true, true}},
    {Property::Ivel, {"IVEL", 16, true, true}},
    {Property::Ioff, {"IOFF", 32, true, true}},
    {Property::Mpe, {"MPE", 16, true, true}},
    {Property::Hold, {"HOLD", 16, true, true}},
    {Property::Tstop, {"TSTOP", 16, true, true}},
    {Property::Kp, {"KP", 16, true, true}},
    {Property::Kd, {"KD", 16, true, true}},
    {Property::Ki, {"KI", 16, true, true}},
    {Property::Accel, {"ACCEL", 16, true, true}},
    {Property::Tenst, {"TENST", 16, true, true}},
    {Property::Tenso, {"TENSO", 16, true, true}},
    {Property::Jidx, {"JIDX", 16, true, true}},
    {Property::Ipnm, {"IPNM", 16, true, true}},
    {Property::Halls, {"HALLS", 16, true, false}},
    {Property::Hallh, {"HALLH", 32, true, false}},
    {Property::Poles, {"POLES", 16, true, true}},
    {Property::Ikp, {"IKP", 16, true, true}},
    {Property::Iki, {"IKI", 16, true, true}},
    {Property::Ikcor, {"IKCOR", 16, true, true}},
    {Property::En, {"EN", 32, true, true}},
    {Property::Jp, {"JP", 32, true, false}},
    {Property::Jofst, {"JOFST", 32, true, true}},
    {Property::Tie, {"TIE", 16, true, true}},
    {Property::Ecmax, {"ECMAX", 16, true, false}},
    {Property::Ecmin, {"ECMIN", 16, true, false}},
    {Property::Lflags, {"LFLAGS", 16, true, false}},
    {Property::Lctc, {"LCTC", 16, true, false}},
    {Property::Lcvc, {"LCVC", 16, true, false}},
    {Property::Tact, {"TACT", 16, true, true}},
    {Property::Tactid, {"TACTID", 16, true, false}},
    {Property::Ihit, {"IHIT", 16, true, true}},
};

constexpr auto make_table() {
  std::array<PropertyInfo, 128> table{};
  for (const auto& [property, info] : kList) table[static_cast<std::size_t>(property)] = info;
  return table;
}

constexpr std::array<PropertyInfo, 128> kTable = make_table();

}  // namespace

const PropertyInfo* property_info(std::uint8_t number) noexcept {
  if (number >= kTable.size() || kTable[number].bits == 0) return nullptr;
  return &kTable[number];
}

const PropertyInfo& property_info(Property property) noexcept {
  const PropertyInfo* info = property_info(static_cast<std::uint8_t>(property));
  assert(info != nullptr);
  return *info;
}

}  // namespace colift::hal::barrett
