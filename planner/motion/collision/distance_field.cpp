#include "planner/motion/collision/distance_field.hpp"

#include <algorithm>
#include <cmath>

namespace colift::planner {
namespace {

constexpr int kMostCells = 120;  // its square has to leave room in 16 bits for another one
/// Rounding of single precision in p and in the interpolation (cells^2, at coordinates of some metres).
constexpr float kRounding = 1e-3f;

/// A stack of rows of corners, with the least value of each row to skip rows that hold nothing.
struct Rows {
  int length, count;
  std::vector<std::int16_t> values, least;

  Rows(int row_length, int rows, std::int16_t fill)
      : length(row_length),
        count(rows),
        values(static_cast<std::size_t>(row_length) * static_cast<std::size_t>(rows), fill),
        least(static_cast<std::size_t>(rows), fill) {}
  [[nodiscard]] std::int16_t* row(int r) { return values.data() + static_cast<std::ptrdiff_t>(r) * length; }
  [[nodiscard]] const std::int16_t* row(int r) const {
    return values.data() + static_cast<std::ptrdiff_t>(r) * length;
  }
};

void lower(std::int16_t* into, const std::int16_t* from, std::int16_t add, int n) {
  for (int i = 0; i < n; ++i) {
    const auto other = static_cast<std::int16_t>(from[i] + add);
    into[i] = other < into[i] ? other : into[i];
  }
}

/// The corners of obstacle cells are at 0, all others at `far`.
Rows mark_corners(const perception::CellGrid& grid, const std::vector<std::uint8_t>& is_obstacle,
                  std::int16_t far) {
  Rows rows(grid.nx + 1, (grid.ny + 1) * (grid.nz + 1), far);
  std::size_t cell = 0;
  for (int iz = 0; iz < grid.nz; ++iz) {
    for (int iy = 0; iy < grid.ny; ++iy) {
      const int r = iz * (grid.ny + 1) + iy;
      for (int ix = 0; ix < grid.nx; ++ix, ++cell) {
        if (is_obstacle[cell] == 0) continue;
        for (const int at : {r, r + 1, r + grid.ny + 1, r + grid.ny + 2}) {
          rows.row(at)[ix] = rows.row(at)[ix + 1] = 0;
          rows.least[static_cast<std::size_t>(at)] = 0;
        }
      }
    }
  }
  return rows;
}

/// Squared distances within each row.
void along_rows(Rows& rows, int reach) {
  for (int r = 0; r < rows.count; ++r) {
    if (rows.least[static_cast<std::size_t>(r)] != 0) continue;
    std::int16_t* v = rows.row(r);
    int since = reach;
    for (int i = 0; i < rows.length; ++i) {
      since = v[i] == 0 ? 0 : std::min(since + 1, reach);
      v[i] = static_cast<std::int16_t>(since);
    }
    since = reach;
    for (int i = rows.length - 1; i >= 0; --i) {
      since = v[i] == 0 ? 0 : std::min(since + 1, reach);
      const int d = std::min<int>(v[i], since);
      v[i] = static_cast<std::int16_t>(d * d);
    }
  }
}

/// Squared distances across rows: the least of each row's neighbours plus their squared distance. Because
/// distances are cut at `reach`, looking that far is exact, and cheaper than a lower envelope of parabolas
/// (Felzenszwalb and Huttenlocher 2012) as it runs eight corners at a time. Rows `stride` apart are
/// neighbours; there are `n` in a line and lines start at the given rows.
void across_rows(const Rows& in, Rows& out, int reach, int stride, int n, int line_start) {
  const int far = reach * reach;
  for (int i = 0; i < n; ++i) {
    const int r = line_start + i * stride;
    std::int16_t* into = out.row(r);
    int least = far;
    for (int k = std::max(-reach, -i); k <= std::min(reach, n - 1 - i); ++k) {
      const int from = r + k * stride;
      const int best = in.least[static_cast<std::size_t>(from)] + k * k;
      if (best >= far) continue;
      lower(into, in.row(from), static_cast<std::int16_t>(k * k), in.length);
      least = std::min(least, best);
    }
    out.least[static_cast<std::size_t>(r)] = static_cast<std::int16_t>(least);
  }
}

}  // namespace

DistanceField::DistanceField(const perception::CellGrid& grid, const std::vector<std::uint8_t>& is_obstacle,
                             double max_m)
    : origin_(grid.origin.cast<float>()),
      cell_m_(static_cast<float>(grid.cell_m)),
      per_m_(static_cast<float>(1.0 / grid.cell_m)) {
  const int reach = std::clamp(static_cast<int>(std::ceil(max_m / grid.cell_m - 1e-9)), 1, kMostCells);
  max_m_ = static_cast<float>(reach) * cell_m_;
  if (std::none_of(is_obstacle.begin(), is_obstacle.end(), [](std::uint8_t o) { return o != 0; })) return;
  nx_ = grid.nx + 1;
  ny_ = grid.ny + 1;
  nz_ = grid.nz + 1;
  max_squared_ = reach * reach;
  const auto far = static_cast<std::int16_t>(max_squared_);
  Rows rows = mark_corners(grid, is_obstacle, far);
  along_rows(rows, reach);
  Rows across_y(nx_, ny_ * nz_, far);
  for (int iz = 0; iz < nz_; ++iz) across_rows(rows, across_y, reach, 1, ny_, iz * ny_);
  std::fill(rows.values.begin(), rows.values.end(), far);
  for (int iy = 0; iy < ny_; ++iy) across_rows(across_y, rows, reach, ny_, nz_, iy);
  squared_ = std::move(rows.values);
}

float DistanceField::squared_cells(const Eigen::Vector3f& p_W) const {
  const Eigen::Vector3f at = (p_W - origin_) * per_m_;
  const Eigen::Vector3f last(static_cast<float>(nx_ - 1), static_cast<float>(ny_ - 1),
                             static_cast<float>(nz_ - 1));
  const Eigen::Vector3f in = at.cwiseMax(0.0f).cwiseMin(last);
  const int ix = std::min(static_cast<int>(in.x()), nx_ - 2),
            iy = std::min(static_cast<int>(in.y()), ny_ - 2),
            iz = std::min(static_cast<int>(in.z()), nz_ - 2);
  const float tx = in.x() - static_cast<float>(ix), ty = in.y() - static_cast<float>(iy),
              tz = in.z() - static_cast<float>(iz);
  const std::int16_t* v = squared_.data() + (static_cast<std::ptrdiff_t>(iz) * ny_ + iy) * nx_ + ix;
  const auto along_x = [&](std::ptrdiff_t offset) {
    const auto a = static_cast<float>(v[offset]), b = static_cast<float>(v[offset + 1]);
    return a + tx * (b - a);
  };
  const std::ptrdiff_t up = static_cast<std::ptrdiff_t>(ny_) * nx_;
  const float low = along_x(0) + ty * (along_x(nx_) - along_x(0));
  const float high = along_x(up) + ty * (along_x(up + nx_) - along_x(up));
  const float mean = low + tz * (high - low);
  const float inside = mean - tx * (1 - tx) - ty * (1 - ty) - tz * (1 - tz) - kRounding;
  // all obstacles lie on the grid's side of its nearest point
  return std::max(inside, 0.0f) + (at - in).squaredNorm();
}

float DistanceField::distance(const Eigen::Vector3f& p_W) const {
  if (empty()) return max_m_;
  return std::min(max_m_, cell_m_ * std::sqrt(squared_cells(p_W)));
}

bool DistanceField::clear(const Eigen::Vector3f& p_W, float radius_m) const {
  if (empty()) return true;
  const float cells = radius_m * per_m_;
  return squared_cells(p_W) >= cells * cells;
}

void DistanceField::look_up(const float* x, const float* y, const float* z, int count,
                            std::int16_t* squared) const {
  if (empty()) {
    std::fill_n(squared, count, std::int16_t{32767});
    return;
  }
  constexpr int kAtOnce = 16;  // points of one batch; no result depends on it
  const float ox = 0.5f - origin_.x() * per_m_, oy = 0.5f - origin_.y() * per_m_,
              oz = 0.5f - origin_.z() * per_m_;
  const float lx = static_cast<float>(nx_) - 0.5f, ly = static_cast<float>(ny_) - 0.5f,
              lz = static_cast<float>(nz_) - 0.5f;
  for (int first = 0; first < count; first += kAtOnce) {
    const int n = std::min(kAtOnce, count - first);
    int ix[kAtOnce], iy[kAtOnce], iz[kAtOnce];
    for (int i = 0; i < n; ++i) {
      ix[i] = static_cast<int>(std::min(std::max(x[first + i] * per_m_ + ox, 0.0f), lx));
      iy[i] = static_cast<int>(std::min(std::max(y[first + i] * per_m_ + oy, 0.0f), ly));
      iz[i] = static_cast<int>(std::min(std::max(z[first + i] * per_m_ + oz, 0.0f), lz));
    }
    for (int i = 0; i < n; ++i) {
      squared[first + i] = squared_[static_cast<std::size_t>(
          (static_cast<std::ptrdiff_t>(iz[i]) * ny_ + iy[i]) * nx_ + ix[i])];
    }
  }
}

std::int16_t DistanceField::enough(float radius_m) const {
  // no point is farther from its nearest corner than half a cell's diagonal, and the distance changes by no
  // more than the way; the hair on top is for rounding
  const float cells = radius_m * per_m_ + 0.8661f;
  const float squared = std::ceil(cells * cells + 0.01f);
  return static_cast<std::int16_t>(std::min(squared, 32767.0f));
}

}  // namespace colift::planner
