#include "control/config/certificate_config.hpp"

namespace colift::control {

// colift experiment certificate --trials 360 --seed 101: the figures certificate.* of 169 lifts, of 89 for
// the load, of 55 with less friction for the slip. lead_m and turning make the bounds of the tilt the
// narrowest in these lifts.
CertificateConfig::CertificateConfig()
    : on_breach("test"),
      mass_sigma(0.05),
      share_below(1.67),
      share_above(1.63),
      load_below(1.66),
      load_above(2.02),
      lead_m(0.014),
      turning(0.5),
      tilt_factor(1.20),
      slip_base_m(0.001),
      slip_factor(1.80) {}

}  // namespace colift::control
