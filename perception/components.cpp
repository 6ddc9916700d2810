#include "perception/components.hpp"

#include <algorithm>
#include <cstddef>

namespace colift::perception {
namespace {

struct Run {
  int row, first, last;  // pixels first..last of a row, without a jump in between
};

std::int32_t root(std::vector<std::int32_t>& parent, std::int32_t i) {
  while (parent[static_cast<std::size_t>(i)] != i) {
    const std::int32_t up = parent[static_cast<std::size_t>(i)];
    parent[static_cast<std::size_t>(i)] = parent[static_cast<std::size_t>(up)];
    i = up;
  }
  return i;
}

void unite(std::vector<std::int32_t>& parent, std::int32_t a, std::int32_t b) {
  a = root(parent, a);
  b = root(parent, b);
  // the smaller index stays, so that numbering follows the image
  if (a < b) parent[static_cast<std::size_t>(b)] = a;
  else parent[static_cast<std::size_t>(a)] = b;
}

}  // namespace

Components connected_components(const std::vector<float>& depth_m, const std::vector<std::uint8_t>& mask, int width,
                                int height, const DepthJump& jump) {
  std::vector<Run> runs;
  std::vector<std::int32_t> parent;
  runs.reserve(8192);
  parent.reserve(8192);

  std::size_t above_begin = 0, above_end = 0;  // the runs of the row above
  for (int row = 0; row < height; ++row) {
    const std::size_t offset = static_cast<std::size_t>(row) * static_cast<std::size_t>(width);
    const std::uint8_t* m = mask.data() + offset;
    const float* d = depth_m.data() + offset;
    const std::size_t begin = runs.size();
    for (int u = 0; u < width;) {
      if (!m[u]) {
        ++u;
        continue;
      }
      int last = u;
      while (last + 1 < width && m[last + 1] && jump.same_surface(d[last], d[last + 1])) ++last;
      parent.push_back(static_cast<std::int32_t>(runs.size()));
      runs.push_back({row, u, last});
      u = last + 1;
    }
    // join with the runs above that overlap by a pixel or a corner and meet at equal depth somewhere
    const float* d_above = d - width;
    std::size_t a = above_begin;
    for (std::size_t r = begin; r < runs.size(); ++r) {
      while (a < above_end && runs[a].last < runs[r].first - 1) ++a;
      for (std::size_t k = a; k < above_end && runs[k].first <= runs[r].last + 1; ++k) {
        const int from = std::max(runs[r].first, runs[k].first - 1);
        const int to = std::min(runs[r].last, runs[k].last + 1);
        bool meet = false;
        for (int u = from; u <= to && !meet; ++u) {
          const int lo = std::max(u - 1, runs[k].first), hi = std::min(u + 1, runs[k].last);
          for (int w = lo; w <= hi && !meet; ++w) meet = jump.same_surface(d[u], d_above[w]);
        }
        if (meet) unite(parent, static_cast<std::int32_t>(r), static_cast<std::int32_t>(k));
      }
    }
    above_begin = begin;
    above_end = runs.size();
  }

  Components result;
  result.label.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), Components::kNone);
  std::vector<std::int32_t> number(runs.size(), Components::kNone);
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const std::size_t top = static_cast<std::size_t>(root(parent, static_cast<std::int32_t>(r)));
    if (number[top] == Components::kNone) {
      number[top] = static_cast<std::int32_t>(result.pixels.size());
      result.pixels.push_back(0);
    }
    const std::int32_t n = number[top];
    const std::size_t offset = static_cast<std::size_t>(runs[r].row) * static_cast<std::size_t>(width);
    std::fill(result.label.begin() + static_cast<std::ptrdiff_t>(offset + static_cast<std::size_t>(runs[r].first)),
              result.label.begin() + static_cast<std::ptrdiff_t>(offset + static_cast<std::size_t>(runs[r].last) + 1), n);
    result.pixels[static_cast<std::size_t>(n)] += static_cast<std::uint32_t>(runs[r].last - runs[r].first + 1);
  }
  return result;
}

}  // namespace colift::perception
