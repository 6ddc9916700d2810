#include "sim_hal/people/soft_body.hpp"

#include <algorithm>
#include <cmath>

namespace colift::sim_hal {
namespace {

constexpr double kTick_s = 0.001;
constexpr double kDampingRatio = 0.7;  // of the muscles
constexpr double kLoss_s_m = 0.4;      // of flesh: loses a tenth of the force at 0.25 m/s
constexpr double kMaxLoss = 0.3;

/// Mass that moves, and the muscles that hold it: stiffness of a posture that is held without care, and what
/// it holds before the person yields. Assumed, of the size that studies of posture find.
struct Group {
  double mass_kg, stiffness_n_m, strength_n;
};
constexpr Group kHead{4.4, 1500.0, 60.0}, kTrunk{40.0, 2500.0, 150.0}, kUpperArm{3.0, 1000.0, 80.0},
    kLowerArm{2.0, 600.0, 60.0}, kHand{0.6, 300.0, 40.0}, kLeg{75.0, 3000.0, 150.0};
constexpr std::array<Group, kBodyGroups> kGroups{kHead,     kTrunk, kUpperArm, kUpperArm, kLowerArm,
                                                 kLowerArm, kHand,  kHand,     kLeg,      kLeg,
                                                 kLeg,      kLeg,   kLeg,      kLeg};

}  // namespace

std::size_t group_of(const Shape& part) {
  const std::size_t side = part.left ? 1 : 0;
  switch (part.part) {
    case BodyPart::Head:
      return 0;
    case BodyPart::None:
    case BodyPart::Neck:
    case BodyPart::Shoulders:
    case BodyPart::Trunk:
      return 1;
    case BodyPart::UpperArm:
      return 2 + side;
    case BodyPart::LowerArm:
      return 4 + side;
    case BodyPart::Hand:
      return 6 + side;
    case BodyPart::Thigh:
      return 8 + side;
    case BodyPart::LowerLeg:
      return 10 + side;
    case BodyPart::Foot:
      return 12 + side;
  }
  return 1;
}

std::array<Vec3, kBodyGroups> SoftBody::zeros() {
  std::array<Vec3, kBodyGroups> all;
  all.fill(Vec3::Zero());
  return all;
}

void SoftBody::step(const std::array<Vec3, kBodyGroups>& force_W) {
  for (std::size_t g = 0; g < kBodyGroups; ++g) {
    const bool still = offset_[g].isZero(0.0) && velocity_[g].isZero(0.0) && force_W[g].isZero(0.0);
    if (still) continue;
    const Group& group = kGroups[g];
    const double damping = 2.0 * kDampingRatio * std::sqrt(group.stiffness_n_m * group.mass_kg);
    Vec3 muscle = -group.stiffness_n_m * offset_[g] - damping * velocity_[g];
    if (muscle.norm() > group.strength_n) muscle *= group.strength_n / muscle.norm();
    velocity_[g] += kTick_s / group.mass_kg * (force_W[g] + muscle);
    offset_[g] += kTick_s * velocity_[g];
    // where it was, to a thousandth of a millimetre: the script has it again
    if (force_W[g].isZero(0.0) && offset_[g].norm() < 1e-6 && velocity_[g].norm() < 1e-6) {
      offset_[g].setZero();
      velocity_[g].setZero();
    }
  }
}

bool SoftBody::at_rest() const {
  for (std::size_t g = 0; g < kBodyGroups; ++g)
    if (!offset_[g].isZero(0.0) || !velocity_[g].isZero(0.0)) return false;
  return true;
}

double contact_force_n(const RegionProperties& region, double depth_m, double closing_m_s) {
  if (depth_m <= 0.0) return 0.0;
  const double loss = std::clamp(kLoss_s_m * closing_m_s, -kMaxLoss, kMaxLoss);
  return region.stiffness_n_m * depth_m * (1.0 + loss);
}

}  // namespace colift::sim_hal
