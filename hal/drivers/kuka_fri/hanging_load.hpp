#pragma once

#include "hal/arm.hpp"
#include "hal/drivers/kuka_fri/cart_set_point.hpp"

namespace colift::hal {

/// No more than a loaded LWR can bear at its flange: each component clamped (N, N m).
[[nodiscard]] SixVector bounded_wrench(const SixVector& wrench);

/// The wrench to be added in Cartesian impedance so that an arm which hangs loaded on the springs of the KRL
/// program stays where it is; x y z rx ry rz, in the controller's task frame. `m`: in monitor mode, at rest;
/// `now`: the same as an ArmState.
///
/// The springs of Cartesian impedance begin without tension at the measured pose, and the arm would sink by
/// all that hangs there. It is a load only where joint torques explain the sag, and where the estimated
/// wrench and the sag of the tool agree in direction (cosine above 0.8); which of both signs the controller
/// gives the wrench shows in that. Else zero.
[[nodiscard]] SixVector wrench_against_load(const FriMeasurement& m, const ArmState& now);

}  // namespace colift::hal
