#include "perception/target/person/limb_part.hpp"

namespace colift::perception {
namespace {

// in the image
bool side_by_side(const Fragment& a, const Fragment& b) {
  constexpr int kApart_px = 4;
  return a.u_min <= b.u_max + kApart_px && b.u_min <= a.u_max + kApart_px && a.v_min <= b.v_max + kApart_px &&
         b.v_min <= a.v_max + kApart_px;
}

}  // namespace

bool is_limb_of(const Fragment& part, const Fragment& body, double max_fraction,
                const std::function<double()>& thickness, const LimbPartConfig& c) {
  if (part.pixels > body.pixels || footprint_span(part) > c.max_span_m) return false;
  const double gap = footprint_gap(part, body);
  const bool behind = gap <= c.behind_m && side_by_side(part, body) &&
                      static_cast<double>(part.pixels) <= max_fraction * static_cast<double>(body.pixels);
  if (gap > c.touching_m && !behind) return false;
  const double thick = thickness();
  return thick >= c.min_thickness_m && thick <= c.max_thickness_m;
}

}  // namespace colift::perception
