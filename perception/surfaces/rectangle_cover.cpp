#include "perception/surfaces/rectangle_cover.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "perception/footprint.hpp"

namespace colift::perception {
namespace {

using Eigen::Vector2d;

constexpr int kMostCells = 40;         // along one side of the grid in which the covered part is counted
constexpr double kMostOutside = 0.12;  // part of the rim that may lie outside a rectangle
constexpr double kLeastKnown = 0.35;   // part of a rectangle that has to be covered, whatever is unknown

struct FlatPoint {
  float s, t;
  bool sure = true;  // the camera saw what lies beside it, so a side here is known to end
};

/// Rectangle in the face's own coordinates, around a middle and along a direction.
struct Frame {
  Vector2d u;                           // unit
  double low_u, high_u, low_v, high_v;  // along u and v

  [[nodiscard]] Vector2d v() const { return {-u.y(), u.x()}; }
  [[nodiscard]] double width() const { return high_u - low_u; }
  [[nodiscard]] double height() const { return high_v - low_v; }
};

struct Fill {
  double covered = 0, empty = 0, unknown = 0;

  [[nodiscard]] double ratio() const { return covered > 0 ? covered / (covered + empty) : 0.0; }
  [[nodiscard]] double known() const { return covered / (covered + empty + unknown); }
};

double quantile(std::vector<double>& values, double part) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

class FaceCover {
 public:
  FaceCover(const OrganisedCloud& cloud, const ObjectImage& image, const Face& face, int label,
            const SurfaceConfig& config)
      : cloud_(cloud),
        image_(image),
        face_(face),
        label_(label),
        config_(config),
        plane_(image.geometry.to_W(face.plane)) {
    std::tie(e1_, e2_) = hal::tangents(plane_.normal);
    const double U = face.moments.u / face.moments.n, V = face.moments.v / face.moments.n;
    origin_ = plane_.foot(image.geometry.point_W(U, V, face.plane.at(U, V)));
    const Vec3 from_eye = image.geometry.eye() - origin_;
    s0_ = e1_.dot(from_eye), t0_ = e2_.dot(from_eye);
    s_ = image.geometry.linear(e1_), t_ = image.geometry.linear(e2_);
    slant_ = slant_of(face, image.geometry);
    const FlatPoint a = flat(U, V), b = flat(U + 1, V), c = flat(U, V + 1);
    step_u_ = Vector2d(static_cast<double>(b.s - a.s), static_cast<double>(b.t - a.t));
    step_v_ = Vector2d(static_cast<double>(c.s - a.s), static_cast<double>(c.t - a.t));
    pixel_m_ = std::max(step_u_.norm(), step_v_.norm());
  }

  void run(const std::vector<std::uint32_t>& pixels, std::vector<FaceRectangle>& out) {
    // the rim tells how far a face goes; what lies inside it is asked for only where the face has to be cut
    pixels_ = &pixels;
    std::vector<FlatPoint> rim;
    for (const std::uint32_t k : pixels) {
      const int n = companions(k);
      if (n == 2 || n == 3) rim.push_back(flat(k));
    }
    cover(rim, static_cast<int>(pixels.size()), 0, out);
  }

 private:
  [[nodiscard]] FlatPoint flat(double U, double V) const {
    const double z = 1.0 / face_.plane.at(U, V);
    return {static_cast<float>(s0_ + s_.at(U, V) * z), static_cast<float>(t0_ + t_.at(U, V) * z)};
  }

  [[nodiscard]] FlatPoint flat(std::uint32_t k) const {
    const int i = image_.column(k), j = image_.row(k);
    FlatPoint p = flat(i, j);
    for (const auto& [di, dj] : {std::pair{-2, 0}, {2, 0}, {0, -2}, {0, 2}})
      p.sure = p.sure && seen(i + di, j + dj);
    return p;
  }

  [[nodiscard]] bool seen(int i, int j) const {
    const int u = i + image_.u0, v = j + image_.v0;
    if (u < 0 || v < 0 || u >= cloud_.width() || v >= cloud_.height()) return false;
    return cloud_.seen(static_cast<std::size_t>(v) * static_cast<std::size_t>(cloud_.width()) +
                       static_cast<std::size_t>(u));
  }

  [[nodiscard]] int companions(std::uint32_t k) const {
    const auto w = static_cast<std::uint32_t>(image_.width);
    return (image_.label[k - 1] == label_) + (image_.label[k + 1] == label_) +
           (image_.label[k - w] == label_) + (image_.label[k + w] == label_);
  }

  void cover(const std::vector<FlatPoint>& points, int pixels, int depth, std::vector<FaceRectangle>& out) {
    if (pixels < config_.min_pixels || points.size() < 8) return;
    const Frame outer = bounding_frame(points);
    if (!(outer.width() > 0 && outer.height() > 0)) return;
    const Frame inner = trimmed(outer, points);
    const Fill fill = fill_of(inner);
    const bool whole = fill.ratio() >= config_.fill_threshold && outside(inner, points) <= kMostOutside;
    if (whole || depth >= config_.max_splits) {
      if (fill.ratio() >= (whole ? config_.fill_threshold : config_.least_fill) &&
          fill.known() >= kLeastKnown)
        add(inner, fill.ratio(), pixels, out);
      return;
    }
    if (depth > 0) return split(outer, points, depth, out);
    std::vector<FlatPoint> all;
    all.reserve(pixels_->size());
    for (const std::uint32_t k : *pixels_)
      if (companions(k) >= 2) all.push_back(flat(k));
    split(outer, all, depth, out);
  }

  [[nodiscard]] Frame bounding_frame(const std::vector<FlatPoint>& points) const {
    // of every row across, only the outermost points can be corners of the hull
    std::vector<Vector2d> ends;
    float low = std::numeric_limits<float>::max(), high = -low;
    for (const FlatPoint& p : points) low = std::min(low, p.t), high = std::max(high, p.t);
    constexpr int kRows = 256;
    const float scale = static_cast<float>(kRows - 1) / std::max(high - low, 1e-6f);
    std::vector<const FlatPoint*> left(kRows, nullptr), right(kRows, nullptr);
    for (const FlatPoint& p : points) {
      const auto r = static_cast<std::size_t>((p.t - low) * scale);
      if (!left[r] || p.s < left[r]->s) left[r] = &p;
      if (!right[r] || p.s > right[r]->s) right[r] = &p;
    }
    for (const auto* list : {&left, &right})
      for (const FlatPoint* p : *list)
        if (p) ends.emplace_back(static_cast<double>(p->s), static_cast<double>(p->t));
    const FlatRectangle r = minimum_area_rectangle(convex_hull(ends));
    Frame f{r.u, r.u.dot(r.center) - 0.5 * r.size.x(), r.u.dot(r.center) + 0.5 * r.size.x(),
            r.v().dot(r.center) - 0.5 * r.size.y(), r.v().dot(r.center) + 0.5 * r.size.y()};
    return f;
  }

  /// What lies outermost on both sides, in lines across one axis.
  struct Side {
    std::vector<double> along, across;  // across grows outwards
    std::size_t sure = 0;               // the first so many are known ends
  };
  [[nodiscard]] std::array<Side, 2> outermost(const Frame& f, const std::vector<FlatPoint>& points,
                                              bool along_u) const {
    const Vector2d a = along_u ? f.u : f.v(), c = along_u ? f.v() : f.u;
    const double first = along_u ? f.low_u : f.low_v, length = along_u ? f.width() : f.height();
    const int bins = std::clamp(static_cast<int>(length / (1.5 * pixel_m_)), 4, 400);
    const double scale = bins / length;
    constexpr double kNone = -std::numeric_limits<double>::infinity();
    struct End {
      double across = kNone;
      bool sure = false;
    };
    std::array<std::vector<End>, 2> ends;
    for (auto& e : ends) e.resize(static_cast<std::size_t>(bins));
    for (const FlatPoint& p : points) {
      const double s = static_cast<double>(p.s), t = static_cast<double>(p.t);
      const auto k = static_cast<std::size_t>(
          std::clamp(static_cast<int>((a.x() * s + a.y() * t - first) * scale), 0, bins - 1));
      const double across = c.x() * s + c.y() * t;
      if (-across > ends[0][k].across) ends[0][k] = {-across, p.sure};
      if (across > ends[1][k].across) ends[1][k] = {across, p.sure};
    }
    std::array<Side, 2> sides;
    // the ends of a side are rounded by its neighbours
    const int margin = bins / 12;
    for (std::size_t end = 0; end < 2; ++end)
      for (const bool sure : {true, false}) {
        for (int k = margin; k < bins - margin; ++k) {
          const End& e = ends[end][static_cast<std::size_t>(k)];
          if (e.across == kNone || e.sure != sure) continue;
          sides[end].along.push_back(first + (k + 0.5) / scale);
          sides[end].across.push_back(e.across);
        }
        if (sure) sides[end].sure = sides[end].along.size();
      }
    return sides;
  }

  /// Where a side is. Lines that run out into nothing do not tell; without better ones, most of them fall
  /// short.
  static double place(Side& side) {
    if (5 * side.sure >= side.across.size() && side.sure >= 4) {
      side.across.resize(side.sure);
      return quantile(side.across, 0.5);
    }
    return quantile(side.across, 0.75);
  }

  /// Slope of a side as the median over pairs of lines half of its length apart; robust against corners and
  /// notches.
  static double slope(const Side& side) {
    const std::size_t n = 5 * side.sure >= side.across.size() ? side.sure : side.across.size(), half = n / 2;
    if (half < 4) return 0.0;
    std::vector<double> slopes(half);
    for (std::size_t i = 0; i < half; ++i)
      slopes[i] = (side.across[i + half] - side.across[i]) / (side.along[i + half] - side.along[i]);
    return quantile(slopes, 0.5);
  }

  [[nodiscard]] Frame trimmed(const Frame& outer, const std::vector<FlatPoint>& points) const {
    constexpr double kMostTurn = 0.12;
    Frame f = outer;
    // sides turn the rectangle by how long they are: a corner that sticks out decides where the hull's edge
    // lies
    double turn = 0, weight = 0;
    for (const bool along_u : {true, false}) {
      const double length = along_u ? outer.width() : outer.height();
      const double other = along_u ? outer.height() : outer.width();
      if (length < 0.3 * other) continue;
      const auto sides = outermost(outer, points, along_u);
      for (std::size_t end = 0; end < 2; ++end) {
        // v grows to the left of u, u to the right of v
        const double m = slope(sides[end]) * (end == 0 ? -1 : 1) * (along_u ? 1 : -1);
        if (std::abs(m) > kMostTurn) continue;
        turn += m * length * length;
        weight += length * length;
      }
    }
    if (weight > 0) turn /= weight;
    f.u = Vector2d(outer.u.x() - turn * outer.u.y(), outer.u.y() + turn * outer.u.x()).normalized();
    f.low_u = f.low_v = std::numeric_limits<double>::infinity();
    f.high_u = f.high_v = -f.low_u;
    const Vector2d v = f.v();
    for (const FlatPoint& p : points) {
      const double s = static_cast<double>(p.s), t = static_cast<double>(p.t);
      const double a = f.u.x() * s + f.u.y() * t, b = v.x() * s + v.y() * t;
      f.low_u = std::min(f.low_u, a), f.high_u = std::max(f.high_u, a);
      f.low_v = std::min(f.low_v, b), f.high_v = std::max(f.high_v, b);
    }
    auto across_u = outermost(f, points, true), across_v = outermost(f, points, false);
    if (across_u[0].across.empty() || across_v[0].across.empty()) return f;
    // a pixel's value stands for its middle
    const double half_u = 0.5 * std::max(std::abs(f.u.dot(step_u_)), std::abs(f.u.dot(step_v_)));
    const double half_v = 0.5 * std::max(std::abs(v.dot(step_u_)), std::abs(v.dot(step_v_)));
    f.low_v = -place(across_u[0]) - half_v, f.high_v = place(across_u[1]) + half_v;
    f.low_u = -place(across_v[0]) - half_u, f.high_u = place(across_v[1]) + half_u;
    return f;
  }

  [[nodiscard]] double outside(const Frame& f, const std::vector<FlatPoint>& points) const {
    const double margin = 2.0 * pixel_m_;
    const Vector2d v = f.v();
    std::size_t count = 0;
    for (const FlatPoint& p : points) {
      const double s = static_cast<double>(p.s), t = static_cast<double>(p.t);
      const double a = f.u.x() * s + f.u.y() * t, b = v.x() * s + v.y() * t;
      count += a < f.low_u - margin || a > f.high_u + margin || b < f.low_v - margin || b > f.high_v + margin;
    }
    return static_cast<double>(count) / static_cast<double>(points.size());
  }

  enum class Cell : std::uint8_t { Covered, Empty, Unknown };

  [[nodiscard]] Cell look(const Vector2d& p) const {
    const ImageGeometry::Pixel pixel = image_.geometry.project(origin_ + p.x() * e1_ + p.y() * e2_);
    const int i = static_cast<int>(std::lround(pixel.U)), j = static_cast<int>(std::lround(pixel.V));
    const int u = i + image_.u0, v = j + image_.v0;
    if (u < 0 || v < 0 || u >= cloud_.width() || v >= cloud_.height()) return Cell::Unknown;
    const bool inside = i >= 0 && j >= 0 && i < image_.width && j < image_.height;
    const std::int16_t label = inside ? image_.label[image_.at(i, j)] : ObjectImage::kOutside;
    if (label == label_) return Cell::Covered;
    const std::size_t k =
        static_cast<std::size_t>(v) * static_cast<std::size_t>(cloud_.width()) + static_cast<std::size_t>(u);
    if (!cloud_.seen(k)) return Cell::Unknown;
    const double q = 1.0 / static_cast<double>(cloud_.depth_m[k]), here = 1.0 / pixel.depth_m;
    const double tolerance = image_.tolerance(here, config_.tolerance_sigma, slant_);
    if (q > here + tolerance) return Cell::Unknown;
    if (q < here - tolerance) return Cell::Empty;
    return label == ObjectImage::kOutside ? Cell::Unknown : Cell::Covered;
  }

  struct Grid {
    int columns, rows;
    std::vector<Cell> cells;
    [[nodiscard]] Cell at(int c, int r) const { return cells[static_cast<std::size_t>(r * columns + c)]; }
  };
  [[nodiscard]] Grid grid_of(const Frame& f) const {
    const auto count = [&](double length) {
      return std::clamp(static_cast<int>(length / (1.2 * pixel_m_)), 3, kMostCells);
    };
    Grid g{count(f.width()), count(f.height()), {}};
    g.cells.reserve(static_cast<std::size_t>(g.columns * g.rows));
    const Vector2d v = f.v();
    for (int r = 0; r < g.rows; ++r)
      for (int c = 0; c < g.columns; ++c)
        g.cells.push_back(look((f.low_u + f.width() * (c + 0.5) / g.columns) * f.u +
                               (f.low_v + f.height() * (r + 0.5) / g.rows) * v));
    return g;
  }

  [[nodiscard]] Fill fill_of(const Frame& f) const {
    Fill fill;
    if (!(f.width() > 0 && f.height() > 0)) return fill;
    for (const Cell c : grid_of(f).cells)
      (c == Cell::Covered ? fill.covered : c == Cell::Empty ? fill.empty : fill.unknown) += 1;
    return fill;
  }

  struct Cut {
    bool along_u = true;
    double at = 0;
    double cost = std::numeric_limits<double>::infinity();
  };

  /// Cost of the box around the covered cells on one side of each cut: how mixed it is, with a little for its
  /// area, so that of two cuts the tighter one wins. Entry i: the first i lines.
  [[nodiscard]] static std::vector<double> costs(const Grid& g, bool along_u, bool backwards) {
    constexpr double kTightness = 0.02;
    const int n = along_u ? g.columns : g.rows, m = along_u ? g.rows : g.columns;
    std::vector<double> result(static_cast<std::size_t>(n + 1), 0.0);
    std::vector<int> empty(static_cast<std::size_t>(m), 0), waiting(static_cast<std::size_t>(m), 0);
    int covered = 0, low = m, high = -1, lines = 0, pending = 0;
    for (int step = 0; step < n; ++step) {
      const int i = backwards ? n - 1 - step : step;
      bool any = false;
      for (int k = 0; k < m; ++k) {
        const Cell c = along_u ? g.at(i, k) : g.at(k, i);
        if (c == Cell::Covered) {
          ++covered;
          any = true;
          low = std::min(low, k), high = std::max(high, k);
        } else if (c == Cell::Empty) {
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

  [[nodiscard]] static Cut best_cut(const Grid& g, const Frame& f) {
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

  void split(const Frame& f, const std::vector<FlatPoint>& points, int depth,
             std::vector<FaceRectangle>& out) {
    const Cut cut = best_cut(grid_of(f), f);
    const Vector2d axis = cut.along_u ? f.u : f.v();
    std::vector<FlatPoint> low, high;
    for (const FlatPoint& p : points)
      (axis.x() * static_cast<double>(p.s) + axis.y() * static_cast<double>(p.t) < cut.at ? low : high)
          .push_back(p);
    if (low.empty() || high.empty()) return;
    cover(low, static_cast<int>(low.size()), depth + 1, out);
    cover(high, static_cast<int>(high.size()), depth + 1, out);
  }

  void add(const Frame& f, double fill, int pixels, std::vector<FaceRectangle>& out) const {
    if (std::min(f.width(), f.height()) < config_.min_width_m) return;
    const Vector2d v = f.v(), middle = 0.5 * (f.low_u + f.high_u) * f.u + 0.5 * (f.low_v + f.high_v) * v;
    FaceRectangle r;
    r.rectangle.center = origin_ + middle.x() * e1_ + middle.y() * e2_;
    r.rectangle.normal = plane_.normal;
    const bool wide = f.width() >= f.height();
    const Vector2d along = wide ? f.u : v;
    r.rectangle.u = along.x() * e1_ + along.y() * e2_;
    r.rectangle.v = plane_.normal.cross(r.rectangle.u);
    r.rectangle.size = wide ? Vector2d(f.width(), f.height()) : Vector2d(f.height(), f.width());
    r.rectangle.fill = fill;
    r.face = label_;
    r.pixels = pixels;
    out.push_back(r);
  }

  const OrganisedCloud& cloud_;
  const ObjectImage& image_;
  const Face& face_;
  int label_;
  const SurfaceConfig& config_;
  hal::Plane plane_;
  Vec3 e1_, e2_, origin_;
  double s0_, t0_;
  InversePlane s_, t_;
  const std::vector<std::uint32_t>* pixels_ = nullptr;
  Vector2d step_u_, step_v_;  // by how much a pixel's step in the image moves on the face
  double pixel_m_, slant_;
};

}  // namespace

void cover_face(const OrganisedCloud& cloud, const ObjectImage& image, const Face& face, int label,
                const std::vector<std::uint32_t>& pixels, const SurfaceConfig& config,
                std::vector<FaceRectangle>& rectangles) {
  if (face.moments.n < config.min_pixels) return;
  FaceCover(cloud, image, face, label, config).run(pixels, rectangles);
}

std::vector<std::vector<std::uint32_t>> pixels_by_face(const ObjectImage& image, std::size_t faces) {
  std::vector<std::vector<std::uint32_t>> lists(faces);
  for (const std::uint32_t k : image.pixels)
    if (image.label[k] >= 0 && static_cast<std::size_t>(image.label[k]) < faces)
      lists[static_cast<std::size_t>(image.label[k])].push_back(k);
  return lists;
}

}  // namespace colift::perception
