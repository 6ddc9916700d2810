#include <algorithm>

#include "perception/partner/partner_grasp.hpp"

// Which skin near the object belongs to one touch: cells along the object's surface, and what hangs together
// on them; and where hands were seen in the frames before.

namespace colift::perception {

void PartnerFinder::number_patch_cells() {
  Eigen::AlignedBox3f box;
  for (const auto& p : grid_.patches()) box.extend(p);
  const auto cell = static_cast<float>(config_.hand_cell_m);
  std::size_t cells = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    cells_[a] = static_cast<int>(box.sizes()[static_cast<int>(a)] / cell) + 1;
    cells *= static_cast<std::size_t>(cells_[a]);
  }
  hand_of_cell_.assign(cells, -1);
  for (const auto& p : grid_.patches()) {
    const Eigen::Vector3f at = (p - box.min()) / cell;
    cell_of_patch_.push_back((static_cast<int>(at.z()) * cells_[1] + static_cast<int>(at.y())) * cells_[0] +
                             static_cast<int>(at.x()));
  }
}

void PartnerFinder::note_hands(const OrganisedCloud& current, const PartnerObservation& observation) {
  known_hands_.clear();
  for (const PartnerContact& hand : observation.contacts) known_hands_.push_back(current.project(hand.skin));
  unseen_frames_ = 0;
}

// What an object's edge leaves of a hand may be about as small as the smallest part that is looked at.
double PartnerFinder::min_part_m2(const PixelWindow& box) const {
  const int gap = config_.body_gap_px;
  const bool known = std::any_of(known_hands_.begin(), known_hands_.end(), [&](const auto& at) {
    return at.u > box.u_begin - gap && at.u < box.u_end + gap && at.v > box.v_begin - gap &&
           at.v < box.v_end + gap;
  });
  return known ? config_.min_known_part_m2 : config_.min_part_m2;
}

// Skin on one connected part of the object's surface is one hand.
void PartnerFinder::separate_hands() {
  for (const std::int32_t c : touched_cells_) hand_of_cell_[static_cast<std::size_t>(c)] = -1;
  touched_cells_.clear();
  hands_ = 0;
  constexpr std::int32_t kUnnumbered = -2;
  for (const Skin& s : skin_) {
    if (s.distance_m > hand_gap(s.depth_m)) continue;
    const std::int32_t c = cell_of_patch_[static_cast<std::size_t>(s.patch)];
    if (hand_of_cell_[static_cast<std::size_t>(c)] == kUnnumbered) continue;
    hand_of_cell_[static_cast<std::size_t>(c)] = kUnnumbered;
    touched_cells_.push_back(c);
  }
  std::vector<std::int32_t> wave;
  for (const std::int32_t seed : touched_cells_) {
    if (hand_of_cell_[static_cast<std::size_t>(seed)] != kUnnumbered) continue;
    hand_of_cell_[static_cast<std::size_t>(seed)] = hands_;
    wave.assign(1, seed);
    while (!wave.empty()) {
      const std::int32_t c = wave.back();
      wave.pop_back();
      const int x = c % cells_[0], y = c / cells_[0] % cells_[1], z = c / (cells_[0] * cells_[1]);
      for (int nz = std::max(0, z - 1); nz <= std::min(cells_[2] - 1, z + 1); ++nz) {
        for (int ny = std::max(0, y - 1); ny <= std::min(cells_[1] - 1, y + 1); ++ny) {
          for (int nx = std::max(0, x - 1); nx <= std::min(cells_[0] - 1, x + 1); ++nx) {
            const std::int32_t n = (nz * cells_[1] + ny) * cells_[0] + nx;
            if (hand_of_cell_[static_cast<std::size_t>(n)] != kUnnumbered) continue;
            hand_of_cell_[static_cast<std::size_t>(n)] = hands_;
            wave.push_back(n);
          }
        }
      }
    }
    ++hands_;
  }
  for (Skin& s : skin_) {
    s.hand = s.distance_m > hand_gap(s.depth_m)
                 ? -1
                 : hand_of_cell_[static_cast<std::size_t>(cell_of_patch_[static_cast<std::size_t>(s.patch)])];
  }
}

}  // namespace colift::perception
