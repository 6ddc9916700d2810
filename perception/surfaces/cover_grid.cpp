#include "perception/surfaces/cover_grid.hpp"

#include <algorithm>
#include <cmath>

namespace colift::perception {
namespace {

/// Cost of the box around the covered cells on one side of each cut: how mixed it is, with a little for its
/// area, so that of two cuts the tighter one wins. Entry i: the first i lines.
std::vector<double> costs(const CoverGrid& g, bool along_u, bool backwards) {
  constexpr double kTightness = 0.02;  // a tie-break: small against a cell that is wrongly covered
  const int n = along_u ? g.columns : g.rows, m = along_u ? g.rows : g.columns;
  std::vector<double> result(static_cast<std::size_t>(n + 1), 0.0);
  std::vector<int> empty(static_cast<std::size_t>(m), 0), waiting(static_cast<std::size_t>(m), 0);
  int covered = 0, low = m, high = -1, lines = 0, pending = 0;
  for (int step = 0; step < n; ++step) {
    const int i = backwards ? n - 1 - step : step;
    bool any = false;
    for (int k = 0; k < m; ++k) {
      const CoverCell c = along_u ? g.at(i, k) : g.at(k, i);
      if (c == CoverCell::Covered) {
        ++covered;
        any = true;
        low = std::min(low, k), high = std::max(high, k);
      } else if (c == CoverCell::Empty) {
        ++waiting[static_cast<std::size_t>(k)];
      }
    }
    // lines before the first and after the last covered cell are not in the box
    if (covered == 0) std::fill(waiting.begin(), waiting.end(), 0);
    if (covered > 0) ++pending;
    if (any) {
      lines += pending;
      pending = 0;
      for (std::size_t k = 0; k < empty.size(); ++k) empty[k] += waiting[k], waiting[k] = 0;
    }
    double hollow = 0;
    for (int k = low; k <= high; ++k) hollow += empty[static_cast<std::size_t>(k)];
    if (covered > 0)
      result[static_cast<std::size_t>(step + 1)] =
          covered * hollow / (covered + hollow) + kTightness * lines * (high - low + 1.0);
  }
  return result;
}

// for numbers that are not far below zero
int nearest(double x) {
  constexpr int kShift = 1 << 20;  // makes the number positive, so that the cast rounds down
  return static_cast<int>(x + (kShift + 0.5)) - kShift;
}

}  // namespace

Fill fill_of(const CoverGrid& grid) {
  int count[3] = {};
  for (const CoverCell c : grid.cells) ++count[static_cast<std::size_t>(c)];
  return {static_cast<double>(count[0]), static_cast<double>(count[1]), static_cast<double>(count[2])};
}

Cut best_cut(const CoverGrid& g, const FaceFrame& f) {
  Cut best;
  for (const bool along_u : {true, false}) {
    const int n = along_u ? g.columns : g.rows;
    const std::vector<double> before = costs(g, along_u, false), after = costs(g, along_u, true);
    for (int i = 1; i < n; ++i) {
      const double cost = before[static_cast<std::size_t>(i)] + after[static_cast<std::size_t>(n - i)];
      if (cost < best.cost) {
        const double length = along_u ? f.width() : f.height();
        best = {along_u, (along_u ? f.low_u : f.low_v) + length * i / n, cost};
      }
    }
  }
  return best;
}

FaceLook::FaceLook(const OrganisedCloud& cloud, const ObjectImage& image, int label, double slant,
                   double tolerance_sigma, const hal::Vec3& origin, const hal::Vec3& e1, const hal::Vec3& e2)
    : cloud_(cloud),
      image_(image),
      label_(label),
      slant_(slant),
      tolerance_sigma_(tolerance_sigma),
      origin_(image.geometry.homogeneous(origin - image.geometry.eye())),
      s_(image.geometry.homogeneous(e1)),
      t_(image.geometry.homogeneous(e2)) {}

CoverCell FaceLook::look(const hal::Vec3& pixel) const {
  const double here = 1.0 / pixel.z();
  const double U = pixel.x() * here, V = pixel.y() * here;
  // in the whole image; a place behind the camera or far outside of the view is not in it
  const double u_exact = U + image_.u0, v_exact = V + image_.v0;
  if (!(here > 0 && u_exact > -0.5 && v_exact > -0.5 && u_exact < cloud_.width() - 0.5 &&
        v_exact < cloud_.height() - 0.5))
    return CoverCell::Unknown;
  const int i = nearest(U), j = nearest(V), u = i + image_.u0, v = j + image_.v0;
  const bool inside = i >= 0 && j >= 0 && i < image_.width && j < image_.height;
  const std::int16_t label = inside ? image_.label[image_.at(i, j)] : ObjectImage::kOutside;
  if (label == label_) return CoverCell::Covered;
  const std::size_t k =
      static_cast<std::size_t>(v) * static_cast<std::size_t>(cloud_.width()) + static_cast<std::size_t>(u);
  if (!cloud_.seen(k)) return CoverCell::Unknown;
  const double q = 1.0 / static_cast<double>(cloud_.depth_m[k]);
  const double tolerance = image_.tolerance(here, tolerance_sigma_, slant_);
  if (q > here + tolerance) return CoverCell::Unknown;
  if (q < here - tolerance) return CoverCell::Empty;
  return label == ObjectImage::kOutside ? CoverCell::Unknown : CoverCell::Covered;
}

CoverGrid FaceLook::grid_of(const FaceFrame& f, double pixel_m) const {
  constexpr int kMostCells = 40;  // bounds the time of each look; a ratio needs no more
  const auto count = [&](double length) {
    return std::clamp(static_cast<int>(length / (1.2 * pixel_m)), 3, kMostCells);
  };
  CoverGrid g{count(f.width()), count(f.height()), {}};
  g.cells.reserve(static_cast<std::size_t>(g.columns * g.rows));
  const Eigen::Vector2d v = f.v();
  const hal::Vec3 step_c = (f.u.x() * s_ + f.u.y() * t_) * (f.width() / g.columns);
  const hal::Vec3 step_r = (v.x() * s_ + v.y() * t_) * (f.height() / g.rows);
  const hal::Vec3 corner =
      origin_ + (f.u.x() * s_ + f.u.y() * t_) * f.low_u + (v.x() * s_ + v.y() * t_) * f.low_v;
  for (int r = 0; r < g.rows; ++r) {
    const hal::Vec3 row = corner + (r + 0.5) * step_r;
    for (int c = 0; c < g.columns; ++c) g.cells.push_back(look(row + (c + 0.5) * step_c));
  }
  return g;
}

}  // namespace colift::perception
