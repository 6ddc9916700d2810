#pragma once

#include <functional>

#include "hal/config/range.hpp"
#include "perception/target/regions/fragments.hpp"

namespace colift::perception {

/// What may be an arm or a leg of somebody, though the view shows it apart from him. Chosen on
/// `colift experiment stances --seed 501`.
struct LimbPartConfig {
  double touching_m = 0.15;
  double behind_m = 0.8;
  double max_span_m = 0.75;
  double min_thickness_m = 0.048;
  double max_thickness_m = 0.13;
  double max_body_span_m = 2.6;
  double min_cut_height_m = 0.87;

  template <class Visitor>
  void visit(Visitor& v) {
    v("touching_m", touching_m, hal::kNotNegative,
      "Max distance on the ground of a limb as large as the rest that is seen of a person (m).");
    v("behind_m", behind_m, hal::kNotNegative,
      "Max distance on the ground of a limb that is seen right beside a person, whose own body hides where "
      "it begins (m).");
    v("max_span_m", max_span_m, hal::kPositive,
      "Max diagonal of the footprint of such a limb (m): pipes and tables are longer.");
    v("min_thickness_m", min_thickness_m, hal::kNotNegative,
      "Min median thickness of it across the view (m): the slats of a chair are thinner.");
    v("max_thickness_m", max_thickness_m, hal::kPositive, "Max median thickness of it (m).");
    v("max_body_span_m", max_body_span_m, hal::kPositive,
      "Max diagonal of the footprint of a person who lies with stretched arms (m).");
    v("min_cut_height_m", min_cut_height_m, hal::kNotNegative,
      "Min height of what may be a person by that alone, because the view cuts it (m).");
  }
};

/// Whether a part is near enough a body, small enough and as thick as a limb to belong to it. `thickness`:
/// its median thickness across the view (m), asked for when all else fits. `max_fraction`: of the body's
/// pixels.
[[nodiscard]] bool is_limb_of(const Fragment& part, const Fragment& body, double max_fraction,
                              const std::function<double()>& thickness, const LimbPartConfig& config = {});

}  // namespace colift::perception
