#pragma once

#include <cstdint>

#include "sim_hal/people/body_region.hpp"

namespace colift::sim_hal {

inline constexpr int kPartner = -1;

/// Somebody is touched at this moment.
struct BodyContact {
  enum class By : std::uint8_t { Robot, Object, Static };
  By by = By::Robot;
  int person = 0;  ///< Place in the scenario's people; kPartner: who carries the other side.
  BodyRegion region = BodyRegion::Hand;
  bool left = false;  ///< Of a limb.
  Vec3 at_W = Vec3::Zero();
  Vec3 force_W = Vec3::Zero();  ///< On the person (N).
  double force_n = 0.0;         ///< Normal part of it.
  double other_m_s = 0.0;       ///< How fast the surface of the other moves towards the person.
  double closing_m_s = 0.0;     ///< How fast they come together, the person's own motion in it.
};

}  // namespace colift::sim_hal
