#include "sim_hal/people/body_region.hpp"

namespace colift::sim_hal {
namespace {

struct Row {
  std::string_view name;
  RegionProperties properties;
};

constexpr std::array<Row, kBodyRegions> kRows{{
    {"hand", {75e3, 0.6}},
    {"lower-arm", {40e3, 2.0}},
    {"upper-arm", {30e3, 3.0}},
    {"abdomen", {10e3, 40.0}},
    {"chest", {25e3, 40.0}},
    {"back", {35e3, 40.0}},
    {"thigh", {50e3, 75.0}},
    {"lower-leg", {60e3, 75.0}},
    {"foot", {75e3, 75.0}},
    {"face", {75e3, 4.4}},
    {"skull", {150e3, 4.4}},
    {"neck", {25e3, 4.4}},
}};

const Row& row(BodyRegion region) {
  return kRows[static_cast<std::size_t>(region)];
}

}  // namespace

std::string_view to_string(BodyRegion region) {
  return row(region).name;
}

RegionProperties properties_of(BodyRegion region) {
  return row(region).properties;
}

BodyRegion region_of(BodyPart part, double along, const Vec3& push_W, const Vec3& facing_W) {
  const double from_front = -push_W.dot(facing_W);
  switch (part) {
    case BodyPart::Head:
      // half of the head's circumference is face, ear to ear
      return from_front > 0.0 && push_W.z() > -0.7 ? BodyRegion::Face : BodyRegion::Skull;
    case BodyPart::Neck:
      return BodyRegion::Neck;
    case BodyPart::Shoulders:
      return BodyRegion::Back;
    case BodyPart::Trunk:
      if (from_front < -0.3) return BodyRegion::Back;
      return along < 0.5 ? BodyRegion::Abdomen : BodyRegion::Chest;
    case BodyPart::UpperArm:
      return BodyRegion::UpperArm;
    case BodyPart::LowerArm:
      return BodyRegion::LowerArm;
    case BodyPart::Thigh:
      return BodyRegion::Thigh;
    case BodyPart::LowerLeg:
      return BodyRegion::LowerLeg;
    case BodyPart::Foot:
      return BodyRegion::Foot;
    case BodyPart::Hand:
    case BodyPart::None:
      break;
  }
  return BodyRegion::Hand;
}

}  // namespace colift::sim_hal
