#pragma once

namespace colift::sim_hal {

/// MuJoCo's general collision of convex shapes (minkowski portal refinement, as of 2.2) at times takes the
/// end of a thin cylinder for what a box beside it touches: for one step a fingertip that lies on a pipe,
/// some hundredths of a millimetre deep, is 4 mm inside of the pipe's end, and thrown off with 2 kN. From now
/// on, in the whole process, such a contact is that of the capsule of the same size, which MuJoCo computes in
/// closed form. All others stay as they are, to the bit. To be called before the first step; once is enough,
/// more do nothing. Any thread.
void correct_cylinder_contacts();

}  // namespace colift::sim_hal
