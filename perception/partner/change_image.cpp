#include "perception/partner/change_image.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace colift::perception {
ChangeImage::ChangeImage(const ReferenceImage& reference, const NoiseModel& noise, const ChangeConfig& config,
                         const PixelWindow& window)
    : width_(reference.cloud.width()),
      pixel_area_(1.0 / (reference.cloud.intrinsics.fx * reference.cloud.intrinsics.fy)),
      noise_(noise),
      config_(config),
      window_(window) {
  const int height = reference.cloud.height();
  const auto width = static_cast<std::size_t>(width_);
  words_ = (width + 63) / 64;
  mask_.assign(words_ * static_cast<std::size_t>(height + 2), 0);
  unseen_.assign(mask_.size(), 0);
  thinned_.assign(mask_.size(), 0);

  limit_m_ = change_limits(reference, noise, config, window);
}

void ChangeImage::compare(const OrganisedCloud& current) {
  runs_.clear();
  run_area_.clear();
  components_.clear();
  parent_.clear();
  blob_parent_.clear();
  if (window_.empty()) return;
  mark(current.depth_m.data());
  thin();
  find_runs(current.depth_m.data());
  number_components();
}

// One bit for each pixel nearer than its limit. Row v of the image is row v + 1 of the mask, so that thin()
// may look above the first and below the last. A NaN on either side compares false.
void ChangeImage::mark(const float* depth_m) {
  const int first = window_.u_begin / 64, last = (window_.u_end - 1) / 64;
  for (int v = window_.v_begin; v < window_.v_end; ++v) {
    const std::size_t row = static_cast<std::size_t>(v) * static_cast<std::size_t>(width_);
    std::uint64_t* bits = mask_.data() + static_cast<std::size_t>(v + 1) * words_;
    std::uint64_t* missing = unseen_.data() + static_cast<std::size_t>(v + 1) * words_;
    for (int w = first; w <= last; ++w) {
      const float* depth = depth_m + row + static_cast<std::size_t>(w) * 64;
      const float* limit = limit_m_.data() + row + static_cast<std::size_t>(w) * 64;
      const int count = std::min(64, width_ - w * 64);
      std::uint64_t word = 0, nan = 0;
      int i = 0;
#if defined(__SSE2__)
      for (; i + 16 <= count; i += 16) {
        const auto sixteen = [i](auto&& four) {
          const __m128i low = _mm_packs_epi32(four(i), four(i + 4)),
                        high = _mm_packs_epi32(four(i + 8), four(i + 12));
          return static_cast<std::uint64_t>(
                     static_cast<std::uint32_t>(_mm_movemask_epi8(_mm_packs_epi16(low, high))))
                 << i;
        };
        word |= sixteen([&](int at) {
          return _mm_castps_si128(_mm_cmplt_ps(_mm_loadu_ps(depth + at), _mm_loadu_ps(limit + at)));
        });
        nan |= sixteen([&](int at) {
          const __m128 d = _mm_loadu_ps(depth + at);
          return _mm_castps_si128(_mm_cmpunord_ps(d, d));
        });
      }
#endif
      for (; i < count; ++i) {
        word |= static_cast<std::uint64_t>(depth[i] < limit[i]) << i;
        nan |= static_cast<std::uint64_t>(depth[i] != depth[i]) << i;
      }
      missing[w] = nan;
      bits[w] = word;
    }
  }
}

// Keeps a changed pixel when none of its four neighbours is seen unchanged: 64 pixels in a handful of
// instructions. A neighbour without depth does not count against it, else every dropout would cost five
// pixels of a finger.
void ChangeImage::thin() {
  const int first = window_.u_begin / 64, last = (window_.u_end - 1) / 64;
  for (int v = window_.v_begin; v < window_.v_end; ++v) {
    const std::size_t at = static_cast<std::size_t>(v + 1) * words_;
    const auto mine = [&](std::size_t word) { return mask_[word] | unseen_[word]; };
    for (int w = first; w <= last; ++w) {
      const std::size_t i = at + static_cast<std::size_t>(w);
      if (mask_[i] == 0) {
        thinned_[i] = 0;
        continue;
      }
      const std::uint64_t here = mine(i);
      const std::uint64_t left = here << 1 | (w > 0 ? mine(i - 1) >> 63 : 0);
      const std::uint64_t right = here >> 1 | (w + 1 < static_cast<int>(words_) ? mine(i + 1) << 63 : 0);
      thinned_[i] = mask_[i] & left & right & mine(i - words_) & mine(i + words_);
    }
  }
}

void ChangeImage::find_runs(const float* depth_m) {
  const auto jump0 = static_cast<float>(config_.jump_m + 4.0 * noise_.sigma0_m);
  const auto jump2 = static_cast<float>(4.0 * noise_.sigma2_per_m + 2.0 * noise_.step2_per_m);
  const auto join = [](std::vector<std::int32_t>& parent, std::size_t a, std::size_t b) {
    const auto root = [&parent](std::size_t i) {
      while (static_cast<std::size_t>(parent[i]) != i) {
        parent[i] = parent[static_cast<std::size_t>(parent[i])];
        i = static_cast<std::size_t>(parent[i]);
      }
      return i;
    };
    const std::size_t one = root(a), other = root(b);
    parent[std::max(one, other)] = static_cast<std::int32_t>(std::min(one, other));
  };
  const int first = window_.u_begin / 64, last = (window_.u_end - 1) / 64;
  std::size_t above = 0, above_end = 0;  // runs of the row above
  for (int v = window_.v_begin; v < window_.v_end; ++v) {
    const float* depth = depth_m + static_cast<std::size_t>(v) * static_cast<std::size_t>(width_);
    const float* upper = depth - width_;
    const std::uint64_t* bits = thinned_.data() + static_cast<std::size_t>(v + 1) * words_;
    const std::size_t row_begin = runs_.size();
    int open = -1;  // column at which the bit run that continues from the word before began
    const auto close = [&](int end) {
      // cut where the depth jumps
      float area = 0.0F;
      int begin = open;
      for (int u = open; u < end; ++u) {
        const float z = depth[u];
        area += z * z;
        const bool cut = u + 1 < end && std::abs(depth[u + 1] - z) > jump0 + jump2 * z * z;
        if (!cut && u + 1 < end) continue;
        runs_.push_back({v, begin, u + 1, 0});
        run_area_.push_back(static_cast<double>(area) * pixel_area_);
        parent_.push_back(static_cast<std::int32_t>(parent_.size()));
        blob_parent_.push_back(begin == open ? parent_.back() : blob_parent_.back());
        begin = u + 1;
        area = 0.0F;
      }
      open = -1;
    };
    for (int w = first; w <= last; ++w) {
      std::uint64_t word = bits[w];
      int at = 0;
      while (at < 64) {
        if (open < 0) {
          if (word == 0) break;
          const int skip = std::countr_zero(word);
          at += skip;
          word >>= skip;
          open = w * 64 + at;
        }
        const int ones = std::countr_one(word);
        at += ones;
        if (at >= 64) break;
        close(w * 64 + at);
        word = ones == 64 ? 0 : word >> ones;
      }
    }
    if (open >= 0) close(std::min((last + 1) * 64, width_));

    // join with the row above where both overlap and no jump lies between
    std::size_t a = above;
    for (std::size_t r = row_begin; r < runs_.size(); ++r) {
      while (a < above_end && runs_[a].u_end <= runs_[r].u_begin) ++a;
      for (std::size_t b = a; b < above_end && runs_[b].u_begin < runs_[r].u_end; ++b) {
        const std::int32_t left = std::max(runs_[r].u_begin, runs_[b].u_begin);
        const std::int32_t right = std::min(runs_[r].u_end, runs_[b].u_end);
        if (left >= right) continue;
        join(blob_parent_, r, b);
        for (std::int32_t u = left; u < right; ++u) {
          if (std::abs(depth[u] - upper[u]) > jump0 + jump2 * depth[u] * depth[u]) continue;
          join(parent_, r, b);
          break;
        }
      }
    }
    above = row_begin;
    above_end = runs_.size();
  }
}

void ChangeImage::number_components() {
  // a parent is never behind its child, so one pass in order meets every root first
  blob_area_.assign(runs_.size(), 0.0);
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    const auto p = static_cast<std::size_t>(parent_[i]);
    if (p == i) {
      runs_[i].component = static_cast<std::int32_t>(components_.size());
      components_.emplace_back().box = {runs_[i].u_begin, runs_[i].v, runs_[i].u_end, runs_[i].v + 1};
    } else {
      runs_[i].component = runs_[p].component;
    }
    auto& component = components_[static_cast<std::size_t>(runs_[i].component)];
    component.area_m2 += run_area_[i];
    component.pixels += runs_[i].u_end - runs_[i].u_begin;
    component.box.u_begin = std::min(component.box.u_begin, runs_[i].u_begin);
    component.box.u_end = std::max(component.box.u_end, runs_[i].u_end);
    component.box.v_end = runs_[i].v + 1;
    blob_parent_[i] = blob_parent_[static_cast<std::size_t>(blob_parent_[i])];
    blob_area_[static_cast<std::size_t>(blob_parent_[i])] += run_area_[i];
  }
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    components_[static_cast<std::size_t>(runs_[i].component)].blob_m2 =
        blob_area_[static_cast<std::size_t>(blob_parent_[i])];
  }
}

}  // namespace colift::perception
