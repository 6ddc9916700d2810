#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "perception/organised_cloud.hpp"
#include "perception/target/regions/components.hpp"
#include "perception/target/regions/fragments.hpp"

namespace colift::perception {

/// What is open around an object in the image: stretches of pixels in a row that are neither its own nor
/// missing, and that hang together over their sides. A missing pixel is a barrier: a shadow beside a rim is
/// no door.
class OpenRuns {
 public:
  struct Run {
    int row, first, last;  ///< Pixels first..last of a row of the image.
  };

  /// In the window around the object. `pixels`: its own, ascending, not empty.
  OpenRuns(const OrganisedCloud& cloud, const std::vector<std::uint32_t>& pixels);

  [[nodiscard]] const std::vector<Run>& runs() const { return runs_; }
  /// Whether the object surrounds a run.
  [[nodiscard]] bool enclosed(std::size_t run) { return opening(run) != kOutside; }
  /// The same number for all runs that hang together; kOutside for what the object does not surround.
  [[nodiscard]] std::int32_t opening(std::size_t run) { return root(static_cast<std::int32_t>(run + 1)); }
  static constexpr std::int32_t kOutside = 0;

 private:
  std::int32_t root(std::int32_t i);
  void unite(std::size_t a, std::size_t b);

  std::vector<Run> runs_;
  std::vector<std::int32_t> parent_;  // union-find; entry 0 is the outside, entry i + 1 is run i
};

/// Number of openings through an object, as between the rungs of a ladder, of at least `min_area_m2` at the
/// object's depth.
[[nodiscard]] int count_openings(const OrganisedCloud& cloud, const Components& components,
                                 const Fragment& object, double min_area_m2);

}  // namespace colift::perception
