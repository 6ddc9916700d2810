#include "control/config/certificate_config.hpp"

namespace colift::control {

CertificateConfig::CertificateConfig()
    : on_breach("test"),
      mass_sigma(0.05),
      share_below(1.96),
      share_above(1.96),
      load_below(1.96),
      load_above(1.96),
      lead_m(0.018),
      turning(0.2),
      tilt_factor(1.5),
      slip_base_m(0.001),
      slip_factor(4.0) {}

}  // namespace colift::control
