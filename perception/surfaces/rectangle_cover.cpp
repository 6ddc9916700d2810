#include "perception/surfaces/rectangle_cover.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "hal/types/units.hpp"
#include "perception/surfaces/cover_grid.hpp"
#include "perception/surfaces/face_frame.hpp"

namespace colift::perception {
namespace {

using Eigen::Vector2d;

/// A point inside a face; it becomes one of the rim when the face is cut beside it. Every other pixel is one,
/// as on the dark fields of a chessboard.
struct InnerPoint {
  float s, t;
  std::uint32_t pixel;
};

class FaceCover {
 public:
  FaceCover(const OrganisedCloud& cloud, const ObjectImage& image, const Face& face, int label,
            const SurfaceConfig& config)
      : cloud_(cloud),
        image_(image),
        face_(face),
        label_(label),
        config_(config),
        plane_(image.geometry.to_W(face.plane)),
        axes_(hal::tangents(plane_.normal)),
        mean_u_(face.moments.u / face.moments.n),
        mean_v_(face.moments.v / face.moments.n),
        origin_(plane_.foot(image.geometry.point_W(mean_u_, mean_v_, face.plane.at(mean_u_, mean_v_)))),
        look_(cloud, image, label, slant_of(face, image.geometry), config.tolerance_sigma, origin_,
              axes_.first, axes_.second) {
    const Vec3 from_eye = image.geometry.eye() - origin_;
    s0_ = axes_.first.dot(from_eye), t0_ = axes_.second.dot(from_eye);
    s_ = image.geometry.linear(axes_.first), t_ = image.geometry.linear(axes_.second);
    const FacePoint a = flat(mean_u_, mean_v_), b = flat(mean_u_ + 1, mean_v_),
                    c = flat(mean_u_, mean_v_ + 1);
    step_.along_row = Vector2d(static_cast<double>(b.s - a.s), static_cast<double>(b.t - a.t));
    step_.along_column = Vector2d(static_cast<double>(c.s - a.s), static_cast<double>(c.t - a.t));
    pixel_m_ = step_.longest();
    most_lean_ = hal::deg_to_rad(config.max_normal_sigma_deg);
    min_pixels_ = std::max(config.min_pixels, static_cast<int>(0.5 * config.min_area_m2 / pixel_area_m2()));
  }

  void run(const std::vector<std::uint32_t>& pixels, std::vector<FaceRectangle>& out) {
    // the rim tells how far a face goes; what lies inside it is asked for only where the face has to be cut
    pixels_ = &pixels;
    std::vector<FacePoint> rim;
    for (const std::uint32_t k : pixels) {
      const int n = companions(k);
      if (n == 2 || n == 3) rim.push_back(flat(k));
    }
    cover(rim, {}, static_cast<int>(pixels.size()), 0);
    while (join_two()) continue;
    for (const Part& part : parts_) add(part, out);
  }

 private:
  [[nodiscard]] FacePoint flat(double U, double V) const {
    const double z = 1.0 / face_.plane.at(U, V);
    return {static_cast<float>(s0_ + s_.at(U, V) * z), static_cast<float>(t0_ + t_.at(U, V) * z)};
  }

  [[nodiscard]] FacePoint flat(std::uint32_t k) const {
    FacePoint p = flat(image_.column(k), image_.row(k));
    p.sure = sure(k);
    return p;
  }

  [[nodiscard]] bool sure(std::uint32_t k) const {
    const int i = image_.column(k), j = image_.row(k);
    return seen(i - 2, j) && seen(i + 2, j) && seen(i, j - 2) && seen(i, j + 2);
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

  [[nodiscard]] double pixel_area_m2() const {
    return std::abs(step_.along_row.x() * step_.along_column.y() -
                    step_.along_row.y() * step_.along_column.x());
  }

  /// `inner` is not needed for the whole face.
  void cover(const std::vector<FacePoint>& rim, const std::vector<InnerPoint>& inner, int pixels, int depth) {
    if (pixels < min_pixels_ || rim.size() < 8) return;
    const FaceFrame outer = bounding_frame(rim, pixel_m_);
    if (!(outer.width() > 0 && outer.height() > 0)) return;
    const FaceFrame frame = trimmed(outer, rim, step_);
    const bool sides = frame.width() > 0 && frame.height() > 0;
    const Fill fill = sides ? fill_of(look_.grid_of(frame, pixel_m_)) : Fill{};
    const bool whole = fill.ratio() >= config_.fill_threshold &&
                       outside(frame, rim, inner) <= config_.cover.max_outside_fraction;
    if (whole || depth >= config_.max_splits) {
      if (fill.ratio() >= (whole ? config_.fill_threshold : config_.min_fill) &&
          fill.known() >= config_.cover.min_known_fraction)
        parts_.push_back({frame, fill.ratio(), pixels});
      return;
    }
    split(outer, rim, depth > 0 ? inner : all_inner(), depth);
  }

  [[nodiscard]] std::vector<InnerPoint> all_inner() const {
    std::vector<InnerPoint> all;
    all.reserve(pixels_->size());
    for (const std::uint32_t k : *pixels_) {
      if ((image_.column(k) + image_.row(k)) % 2 != 0 || companions(k) != 4) continue;
      const FacePoint p = flat(image_.column(k), image_.row(k));
      all.push_back({p.s, p.t, k});
    }
    return all;
  }

  [[nodiscard]] double outside(const FaceFrame& f, const std::vector<FacePoint>& rim,
                               const std::vector<InnerPoint>& inner) const {
    const auto margin = static_cast<float>(2.0 * pixel_m_);
    const auto ux = static_cast<float>(f.u.x()), uy = static_cast<float>(f.u.y());
    const auto middle_a = static_cast<float>(0.5 * (f.low_u + f.high_u)),
               middle_b = static_cast<float>(0.5 * (f.low_v + f.high_v));
    const float half_a = static_cast<float>(0.5 * f.width()) + margin,
                half_b = static_cast<float>(0.5 * f.height()) + margin;
    const auto beyond = [&](float s, float t) {
      return (std::abs(ux * s + uy * t - middle_a) > half_a) |
             (std::abs(ux * t - uy * s - middle_b) > half_b);
    };
    std::size_t count = 0;
    for (const FacePoint& p : rim) count += beyond(p.s, p.t);
    for (const InnerPoint& p : inner) count += 2u * beyond(p.s, p.t);
    return static_cast<double>(count) / static_cast<double>(rim.size() + 2 * inner.size());
  }

  void split(const FaceFrame& f, const std::vector<FacePoint>& rim, const std::vector<InnerPoint>& inner,
             int depth) {
    const Cut cut = best_cut(look_.grid_of(f, pixel_m_), f);
    const Vector2d axis = cut.along_u ? f.u : f.v();
    const auto x = static_cast<float>(axis.x()), y = static_cast<float>(axis.y()),
               at = static_cast<float>(cut.at), beside = static_cast<float>(2.0 * pixel_m_);
    struct Piece {
      std::vector<FacePoint> rim;
      std::vector<InnerPoint> inner;
    };
    Piece low, high;
    for (const FacePoint& p : rim) (x * p.s + y * p.t < at ? low : high).rim.push_back(p);
    for (const InnerPoint& p : inner) {
      const float over = x * p.s + y * p.t - at;
      Piece& piece = over < 0 ? low : high;
      if (std::abs(over) < beside)
        piece.rim.push_back({p.s, p.t, sure(p.pixel)});
      else
        piece.inner.push_back(p);
    }
    for (const Piece* piece : {&low, &high})
      cover(piece->rim, piece->inner, static_cast<int>(piece->rim.size() + 2 * piece->inner.size()),
            depth + 1);
  }

  /// Joins two parts between which no cut was needed after all: a ragged rim leads to a cut, and what lies on
  /// both sides of it is one rectangle. False where there are none.
  bool join_two() {
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      for (std::size_t k = i + 1; k < parts_.size(); ++k) {
        const std::optional<FaceFrame> both = around(parts_[i].frame, parts_[k].frame);
        if (!both) continue;
        const Fill fill = fill_of(look_.grid_of(*both, pixel_m_));
        if (fill.ratio() < config_.fill_threshold || fill.known() < config_.cover.min_known_fraction)
          continue;
        parts_[i] = {*both, fill.ratio(), parts_[i].pixels + parts_[k].pixels};
        parts_.erase(parts_.begin() + static_cast<std::ptrdiff_t>(k));
        return true;
      }
    }
    return false;
  }

  /// The frame around two that lie side by side and are equally long there; none where they do not.
  [[nodiscard]] std::optional<FaceFrame> around(const FaceFrame& a, const FaceFrame& b) const {
    const Vector2d v = a.v();
    FaceFrame turned = b;  // with its u along a's
    if (std::abs(a.u.dot(b.u)) < config_.cover.same_direction_cosine) {
      if (std::abs(v.dot(b.u)) < config_.cover.same_direction_cosine) return std::nullopt;
      turned = {b.v(), b.low_v, b.high_v, -b.high_u, -b.low_u};
    }
    if (a.u.dot(turned.u) < 0)
      turned = {-turned.u, -turned.high_u, -turned.low_u, -turned.high_v, -turned.low_v};
    const double slack = 3.0 * pixel_m_;
    const auto same = [&](double la, double ha, double lb, double hb) {
      return std::abs(la - lb) < slack && std::abs(ha - hb) < slack;
    };
    const auto meet = [&](double la, double ha, double lb, double hb) {
      return lb < ha + slack && la < hb + slack;
    };
    const bool beside_v = same(a.low_u, a.high_u, turned.low_u, turned.high_u) &&
                          meet(a.low_v, a.high_v, turned.low_v, turned.high_v);
    const bool beside_u = same(a.low_v, a.high_v, turned.low_v, turned.high_v) &&
                          meet(a.low_u, a.high_u, turned.low_u, turned.high_u);
    if (!beside_u && !beside_v) return std::nullopt;
    return FaceFrame{a.u, std::min(a.low_u, turned.low_u), std::max(a.high_u, turned.high_u),
                     std::min(a.low_v, turned.low_v), std::max(a.high_v, turned.high_v)};
  }

  /// A rectangle in the face's own coordinates, with the covered part of it and its pixels.
  struct Part {
    FaceFrame frame;
    double fill;
    int pixels;
  };

  void add(const Part& part, std::vector<FaceRectangle>& out) const {
    const FaceFrame& f = part.frame;
    const double fill = part.fill;
    const int pixels = part.pixels;
    const double narrow = std::min(f.width(), f.height());
    if (narrow < config_.min_width_m || narrow < config_.cover.min_width_px * across_m(f)) return;
    const bool small =
        f.width() * f.height() < config_.min_area_m2 || normal_sigma(narrow, pixels) > most_lean_;
    if (small && !face_.strip) return;
    const Vector2d v = f.v(), middle = 0.5 * (f.low_u + f.high_u) * f.u + 0.5 * (f.low_v + f.high_v) * v;
    const auto in_W = [&](const Vector2d& p) { return Vec3(p.x() * axes_.first + p.y() * axes_.second); };
    FaceRectangle r;
    r.rectangle.center = origin_ + in_W(middle);
    r.rectangle.normal = plane_.normal;
    const bool wide = f.width() >= f.height();
    r.rectangle.u = in_W(wide ? f.u : v);
    r.rectangle.v = plane_.normal.cross(r.rectangle.u);
    r.rectangle.size = wide ? Vector2d(f.width(), f.height()) : Vector2d(f.height(), f.width());
    r.rectangle.fill = fill;
    r.face = label_;
    r.pixels = pixels;
    out.push_back(r);
  }

  /// Standard deviation (rad) of a normal that the pixels of a strip give, about the strip's long side.
  [[nodiscard]] double normal_sigma(double narrow_m, int pixels) const {
    const Vec3 ray = image_.geometry.ray_W(mean_u_, mean_v_);
    const double depth_m = 1.0 / face_.plane.at(mean_u_, mean_v_);
    const double noise_m = image_.noise.sigma(depth_m) * std::abs(plane_.normal.dot(ray));
    return noise_m * std::sqrt(12.0 / pixels) / narrow_m;
  }

  /// Side (m) of a pixel along a frame's short side.
  [[nodiscard]] double across_m(const FaceFrame& f) const {
    const Vector2d e = f.width() < f.height() ? f.u : f.v();
    return std::max(std::abs(e.dot(step_.along_row)), std::abs(e.dot(step_.along_column)));
  }

  const OrganisedCloud& cloud_;
  const ObjectImage& image_;
  const Face& face_;
  int label_;
  const SurfaceConfig& config_;
  hal::Plane plane_;
  std::pair<Vec3, Vec3> axes_;
  double mean_u_, mean_v_;
  Vec3 origin_;
  FaceLook look_;
  double s0_, t0_;
  InversePlane s_, t_;
  const std::vector<std::uint32_t>* pixels_ = nullptr;
  std::vector<Part> parts_;
  PixelStep step_;
  double pixel_m_;
  double most_lean_;  // rad
  int min_pixels_;    // half of what the smallest rectangle has
};

}  // namespace

void cover_face(const OrganisedCloud& cloud, const ObjectImage& image, const Face& face, int label,
                const std::vector<std::uint32_t>& pixels, const SurfaceConfig& config,
                std::vector<FaceRectangle>& rectangles) {
  if (face.moments.n < config.min_pixels) return;
  FaceCover(cloud, image, face, label, config).run(pixels, rectangles);
}

std::vector<std::vector<std::uint32_t>> pixels_by_face(const ObjectImage& image,
                                                       const std::vector<Face>& faces,
                                                       const std::vector<char>& wanted) {
  std::vector<std::vector<std::uint32_t>> lists(faces.size());
  for (std::size_t k = 0; k < faces.size(); ++k)
    if (wanted[k]) lists[k].reserve(static_cast<std::size_t>(faces[k].moments.n));
  for (const std::uint32_t k : image.pixels) {
    if (image.label[k] < 0) continue;
    const auto face = static_cast<std::size_t>(image.label[k]);
    if (wanted[face]) lists[face].push_back(k);
  }
  return lists;
}

}  // namespace colift::perception
