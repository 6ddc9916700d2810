#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "perception/organised_cloud.hpp"
#include "perception/target/regions/components.hpp"

namespace colift::perception {

/// Least distance in space between fragments, over pixels that follow one another in a row or column of the
/// image with nothing of the mask between them. Fragments that nowhere follow one another are infinitely far
/// apart. Beside it the same over pixels where the second fragment may hide how the first one goes on.
class FragmentGaps {
 public:
  /// `slot`: for each region of the components its fragment, 0 to n - 1; -1 for none.
  FragmentGaps(const OrganisedCloud& cloud, const Components& components,
               const std::vector<std::int32_t>& slot, std::size_t n);

  /// Infinite where they nowhere follow one another (m).
  [[nodiscard]] double between(std::size_t a, std::size_t b) const;

  /// Over pixels at which `a` is further away from the camera than `b` (m).
  [[nodiscard]] double behind(std::size_t a, std::size_t b) const;

  /// Fragment b becomes part of a.
  void join(std::size_t a, std::size_t b);

 private:
  void near(const OrganisedCloud& cloud, std::int32_t slot_a, std::size_t a, std::int32_t slot_b,
            std::size_t b);

  std::size_t n_;
  std::vector<float> square_, behind_;
};

}  // namespace colift::perception
