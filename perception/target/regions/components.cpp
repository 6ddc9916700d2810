#include "perception/target/regions/components.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

namespace colift::perception {
namespace {

using Run = Components::Run;

// first place of a byte in row[from..to), `to` if there is none
int find(const std::uint8_t* row, int from, int to, std::uint8_t byte) {
  if (from >= to) return to;
  const void* at = std::memchr(row + from, byte, static_cast<std::size_t>(to - from));
  return at ? static_cast<int>(static_cast<const std::uint8_t*>(at) - row) : to;
}

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
  if (a < b)
    parent[static_cast<std::size_t>(b)] = a;
  else
    parent[static_cast<std::size_t>(a)] = b;
}

}  // namespace

std::vector<std::int32_t> Components::labels(int width, int height) const {
  std::vector<std::int32_t> out(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), kNone);
  for (const Run& run : runs) {
    const auto row = out.begin() + static_cast<std::ptrdiff_t>(run.row) * width;
    std::fill(row + run.first, row + run.last + 1, run.label);
  }
  return out;
}

Components connected_components(const std::vector<float>& depth_m, const std::vector<std::uint8_t>& mask,
                                int width, int height, const DepthJump& jump) {
  std::vector<Run> runs;
  std::vector<std::int32_t> parent;
  runs.reserve(8192);
  parent.reserve(8192);

  std::vector<std::uint8_t> links(static_cast<std::size_t>(width));
  std::uint8_t* together = links.data();
  const float base = jump.base_m, growth = jump.growth_per_m;
  std::size_t above_begin = 0, above_end = 0;  // the runs of the row above
  for (int row = 0; row < height; ++row) {
    const std::size_t offset = static_cast<std::size_t>(row) * static_cast<std::size_t>(width);
    const std::uint8_t* m = mask.data() + offset;
    const float* d = depth_m.data() + offset;
    const std::size_t begin = runs.size();
    // where a pixel and its right neighbour hang together, in a loop without branches
    for (int u = 0; u + 1 < width; ++u) {
      const float near = d[u] < d[u + 1] ? d[u] : d[u + 1];
      const std::uint8_t same = std::abs(d[u] - d[u + 1]) <= base + growth * near * near ? 1 : 0;
      together[u] = static_cast<std::uint8_t>(same & m[u] & m[u + 1]);
    }
    for (int u = find(m, 0, width, 1); u < width;) {
      const int last = find(together, u, width - 1, 0);
      parent.push_back(static_cast<std::int32_t>(runs.size()));
      runs.push_back({row, u, last, Components::kNone});
      u = find(m, last + 1, width, 1);
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
  std::vector<std::int32_t> number(runs.size(), Components::kNone);
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const std::size_t top = static_cast<std::size_t>(root(parent, static_cast<std::int32_t>(r)));
    if (number[top] == Components::kNone) {
      number[top] = static_cast<std::int32_t>(result.pixels.size());
      result.pixels.push_back(0);
    }
    const std::int32_t n = runs[r].label = number[top];
    result.pixels[static_cast<std::size_t>(n)] +=
        static_cast<std::uint32_t>(runs[r].last - runs[r].first + 1);
  }
  result.runs = std::move(runs);
  return result;
}

}  // namespace colift::perception
