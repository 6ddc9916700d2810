#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "perception/bodies/block_grid.hpp"
#include "perception/change_limit.hpp"
#include "perception/noise_model.hpp"

namespace colift::perception {

/// Blocks of 4 x 4 pixels in which frames show what lies clearly behind the reference, for half a second and
/// beside others of the kind: what stood there was carried off. From then on they are compared with what is
/// seen now, so that somebody who stands where it stood is noticed. Allocation-free after construction.
class LimitRenewal {
 public:
  /// `reference_m`: its depth by pixel, NaN where nothing was measured; `keeps`: by block, not 0 where
  /// nothing is renewed: the object, which moves and comes back.
  LimitRenewal(std::span<const float> reference_m, std::size_t width, const NoiseModel& noise,
               const ChangeConfig& config, std::vector<std::uint8_t> keeps);

  /// With every frame, of which each looks at a third of the rows of blocks. `robot`: by block, not 0 where
  /// nothing is known because of it; `limit_m`: by pixel, as of change_limits(); `behind_m`: depth of the
  /// background by block. Both are moved back where it is due. Returns how many blocks were.
  std::size_t update(std::span<const float> depth_m, std::span<const std::uint8_t> robot,
                     std::span<float> limit_m, std::span<float> behind_m);

 private:
  void look(std::size_t row, std::span<const float> depth_m, std::span<const std::uint8_t> robot);
  [[nodiscard]] bool has_company(std::size_t block) const;
  void move_back(std::size_t block, std::span<const float> depth_m, std::span<float> limit_m,
                 std::span<float> behind_m);

  BlockGrid grid_;
  ChangeMargin margin_;
  std::vector<std::uint8_t> keeps_, looks_;  // by block; looks in a row that showed what lies behind
  std::vector<float> far_m_;  // by pixel: beyond it nothing is left of what the reference shows
  std::vector<float> past_;   // by column of pixels: how many of a block's row
  std::size_t frame_ = 0;
};

}  // namespace colift::perception
