#include "sim_hal/mujoco/engine/cylinder_contact.hpp"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <mutex>

namespace colift::sim_hal {
namespace {

// Contacts here are tenths of a millimetre deep (solref, solimp in mjcf.cpp).
constexpr mjtNum kDeep_m = 0.001, kAlongAxis = 0.5;

mjfCollision as_convex = nullptr, as_capsule = nullptr;

int cylinder_and_box(const mjModel* m, const mjData* d, mjContact* contacts, int cylinder, int box,
                     mjtNum margin) {
  const int n = as_convex(m, d, contacts, cylinder, box, margin);
  const mjtNum radius = m->geom_size[3 * cylinder], half_length = m->geom_size[3 * cylinder + 1];
  if (n == 0 || radius > half_length) return n;
  const mjtNum* X = d->geom_xmat + 9 * cylinder;  // its axis is z, the third column
  const bool wrong = std::any_of(contacts, contacts + n, [&](const mjContact& c) {
    const mjtNum along = c.frame[0] * X[2] + c.frame[1] * X[5] + c.frame[2] * X[8];
    return c.dist < -kDeep_m && std::abs(along) > kAlongAxis;
  });
  return wrong ? as_capsule(m, d, contacts, cylinder, box, margin) : n;
}

}  // namespace

void correct_cylinder_contacts() {
  static std::once_flag once;
  std::call_once(once, [] {
    as_convex = mjCOLLISIONFUNC[mjGEOM_CYLINDER][mjGEOM_BOX];
    as_capsule = mjCOLLISIONFUNC[mjGEOM_CAPSULE][mjGEOM_BOX];
    mjCOLLISIONFUNC[mjGEOM_CYLINDER][mjGEOM_BOX] = cylinder_and_box;
  });
}

}  // namespace colift::sim_hal
