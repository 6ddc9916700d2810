#pragma once

#include <cstdint>
#include <vector>

#include "hal/config/range.hpp"
#include "perception/ground/image_border.hpp"
#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"
#include "perception/target/regions/components.hpp"
#include "perception/target/regions/fragments.hpp"

namespace colift::perception {

/// How a region that cannot be carried as a whole is cut apart.
struct SecondLookConfig {
  int window_px = 4;
  double max_slope_deg = 78.0;
  double slope_sigma = 6.0;
  int min_pixels = 300;
  double max_small_fraction = 0.08;

  template <class Visitor>
  void visit(Visitor& v) {
    v("window_px", window_px, hal::Range{1, 50},
      "Half the distance over which the slope of the depth is taken (px); sensors smear an edge over up to 8 "
      "px.");
    v("max_slope_deg", max_slope_deg, hal::Range{1, 90},
      "Max angle between a surface's normal and the view (deg); steeper is the smeared edge of something in "
      "front.");
    v("slope_sigma", slope_sigma, hal::Range{0, 100},
      "Depth difference that is noise in that slope, in standard deviations of the depth noise.");
    v("min_pixels", min_pixels, hal::Range{1, 1e6}, "Min number of pixels of a part that is looked at.");
    v("max_small_fraction", max_small_fraction, hal::kFraction,
      "Max number of pixels of a leg or strut, as a fraction of the part's that it belongs to.");
  }
};

/// The parts of objects that hang together with what stands behind them.
struct SecondLook {
  Components components;
  std::vector<Fragment> parts;     ///< Their labels are those of `components`; largest first.
  std::vector<std::size_t> whole;  ///< Of each part: the object that it comes from.
};

/// Cuts objects apart where their depth rises more steeply over several pixels than a surface in view can:
/// active stereo and cameras whose depth is mapped onto their colour image draw a ramp from an object's edge
/// to the wall behind it, along which no two neighbouring pixels jump. The ramps go to the parts that they
/// begin at, as far as neighbouring pixels agree. `label`: the regions of the first look, to which the
/// objects' labels belong.
[[nodiscard]] SecondLook look_again(const OrganisedCloud& cloud, const std::vector<std::int32_t>& label,
                                    const std::vector<Fragment>& objects, const Ground& ground,
                                    const ImageBorder& border, const DepthJump& jump, const NoiseModel& noise,
                                    const FragmentConfig& fragments, const SecondLookConfig& config);

}  // namespace colift::perception
