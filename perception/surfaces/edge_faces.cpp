#include "perception/surfaces/edge_faces.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "hal/types/units.hpp"

namespace colift::perception {
namespace {

// A level face that was found, and the side of a wide one that it lies along. Pixels beside it, over all of
// its length but this much at both ends, are its own ragged rim.
constexpr double kEnd_m = 0.03, kRagged_m = 0.02;
struct Rim {
  std::int16_t label;
  Vec3 middle, along, behind;
  double length_m, width_m;
};

struct BandPixel {
  std::uint32_t index;
  float out, along;  // ray . outward and ray . along
  float q, wide;     // seen, and of the wide face
  float below;       // under the wide face's plane on the edge face (m)
};

class EdgeSearch {
 public:
  EdgeSearch(ObjectImage& image, std::vector<Face>& faces, const Ground& ground, const SurfaceConfig& config)
      : image_(image), faces_(faces), up_(ground.plane.normal), config_(config) {}

  /// Looks along one side: `outward` in the rectangle's plane, `middle` on the side, `length` of the side.
  void side(const FaceRectangle& from, Vec3 outward, const Vec3& middle, double length) {
    Vec3 normal = from.rectangle.normal;
    if (normal.dot(up_) > config_.edge_faces.level_cosine) {
      normal = up_;
      outward = (outward - normal * normal.dot(outward)).normalized();
    }
    const Vec3 along = normal.cross(outward);
    const Vec3 to_eye = image_.geometry.eye() - middle;
    if (outward.dot(to_eye) < std::sin(hal::deg_to_rad(config_.min_edge_view_deg)) * to_eye.norm()) return;
    if (wide_face_there(from, outward, middle)) return;

    out_ = image_.geometry.linear(outward), along_ = image_.geometry.linear(along);
    // the plane outward . p = outward . middle, as inverse depth g . ray with g = alpha outward + beta along
    double alpha = -1.0 / outward.dot(to_eye), beta = 0;
    collect(from, normal, along, middle, length, alpha);
    if (band_.size() < static_cast<std::size_t>(config_.min_pixels)) return;
    deepest_ = config_.max_edge_m;
    const bool fitted = refine(alpha, beta, 4, false) && refine(alpha, beta, 5, true);
    if (!fitted) return;
    measure_below(normal, middle, alpha, beta);
    deepest_ = thickness(length);
    if (deepest_ <= 0 || !refine(alpha, beta, 3, true)) return;
    if (accept(from, outward, along, alpha, beta) && outward.dot(up_) > config_.edge_faces.level_cosine)
      rims_.push_back(
          {static_cast<std::int16_t>(faces_.size() - 1), middle, along, -normal, length, deepest_});
  }

  /// The rims of a crate go on around its corners, where no wall may be seen that they would be a side of:
  /// what is connected with a rim and lies in its plane.
  void follow_rims() {
    if (rims_.empty()) return;
    std::vector<std::vector<std::uint32_t>> pixels(faces_.size());
    for (const std::uint32_t k : image_.pixels)
      for (const Rim& rim : rims_)
        if (image_.label[k] == rim.label) pixels[static_cast<std::size_t>(rim.label)].push_back(k);
    for (const Rim& rim : rims_)
      for (const std::uint32_t k : pixels[static_cast<std::size_t>(rim.label)]) follow(rim, k);
  }

 private:
  void follow(const Rim& rim, std::uint32_t from) {
    const InversePlane plane = faces_[static_cast<std::size_t>(rim.label)].plane;
    const auto label = static_cast<std::int16_t>(faces_.size());
    const auto w = static_cast<std::uint32_t>(image_.width);
    std::vector<std::pair<std::uint32_t, std::int16_t>> taken;  // with their label before
    const auto take_around = [&](std::uint32_t k) {
      for (const std::uint32_t n : {k - 1, k + 1, k - w, k + w})
        if (goes_on(rim, plane, n)) {
          taken.emplace_back(n, image_.label[n]);
          image_.label[n] = label;
        }
    };
    take_around(from);
    for (std::size_t next = 0; next < taken.size(); ++next) take_around(taken[next].first);
    if (taken.size() < static_cast<std::size_t>(config_.min_pixels)) {
      for (const auto& [k, before] : taken) image_.label[k] = before;
      return;
    }
    Face face;
    face.plane = plane;
    for (const auto& [k, before] : taken)
      face.moments.add(image_.column(k), image_.row(k), static_cast<double>(image_.q[k]));
    (void)add_face(face);
  }

  // an edge face keeps its pixels, however narrow it is
  std::int16_t add_face(const Face& face) {
    const auto label = static_cast<std::int16_t>(faces_.size());
    if (label > 0) (void)small(static_cast<std::int16_t>(label - 1));
    faces_.push_back(face);
    small_.push_back(false);
    return label;
  }

  [[nodiscard]] bool goes_on(const Rim& rim, const InversePlane& plane, std::uint32_t k) {
    const std::int16_t label = image_.label[k];
    const bool other = label >= 0 && static_cast<std::size_t>(label) < faces_.size() && small(label);
    if (label != ObjectImage::kFree && !other) return false;
    const double U = image_.column(k), V = image_.row(k), q = static_cast<double>(image_.q[k]);
    const double expected = plane.at(U, V);
    if (std::abs(q - expected) > image_.tolerance(q, config_.tolerance_sigma)) return false;
    const Vec3 at = image_.geometry.point_W(U, V, expected) - rim.middle;
    const double behind = rim.behind.dot(at);
    return std::abs(rim.along.dot(at)) > 0.5 * rim.length_m - kEnd_m || behind < -kRagged_m ||
           behind > rim.width_m + kRagged_m;
  }

  [[nodiscard]] bool wide_face_there(const FaceRectangle& from, const Vec3& outward,
                                     const Vec3& middle) const {
    for (std::size_t k = 0; k < faces_.size(); ++k) {
      if (static_cast<int>(k) == from.face || faces_[k].moments.n < config_.min_pixels) continue;
      const hal::Plane plane = image_.geometry.to_W(faces_[k].plane);
      if (plane.normal.dot(outward) < config_.edge_faces.same_face_cosine ||
          std::abs(plane.height(middle)) > config_.edge_faces.same_face_distance_m)
        continue;
      if (extent_of(faces_[k], image_.geometry).narrow_m > config_.max_edge_m) return true;
    }
    return false;
  }

  void collect(const FaceRectangle& from, const Vec3& normal, const Vec3& along, const Vec3& middle,
               double length, double alpha) {
    band_.clear();
    wide_ = faces_[static_cast<std::size_t>(from.face)].plane;
    const Vec3 half = 0.5 * length * along, down = config_.max_edge_m * normal,
               inside = 0.04 * (normal.cross(along));
    double u_min = 1e9, u_max = -1e9, v_min = 1e9, v_max = -1e9;
    for (const double s : {-1.0, 1.0})
      for (const Vec3& p :
           {Vec3(middle + s * half - down), Vec3(middle + s * half + inside), Vec3(middle + s * half)}) {
        const ImageGeometry::Pixel k = image_.geometry.project(p);
        u_min = std::min(u_min, k.U), u_max = std::max(u_max, k.U);
        v_min = std::min(v_min, k.V), v_max = std::max(v_max, k.V);
      }
    const Vec3 from_eye = image_.geometry.eye() - middle;
    const double along0 = along.dot(from_eye), below0 = -normal.dot(from_eye);
    const InversePlane up = image_.geometry.linear(normal);
    for (int j = std::max(static_cast<int>(v_min), 0);
         j <= std::min(static_cast<int>(v_max) + 1, image_.height - 1); ++j)
      for (int i = std::max(static_cast<int>(u_min), 0);
           i <= std::min(static_cast<int>(u_max) + 1, image_.width - 1); ++i) {
        const std::size_t k = image_.at(i, j);
        const std::int16_t label = image_.label[k];
        if (label == ObjectImage::kOutside || (label >= 0 && label != from.face && !small(label))) continue;
        const double s = out_.at(i, j), t = along_.at(i, j), plane = alpha * s;
        if (!(plane > 0)) continue;
        const double l = along0 + t / plane, below = below0 - up.at(i, j) / plane;
        if (std::abs(l) > 0.5 * length || below < -0.04 || below > config_.max_edge_m + 0.02) continue;
        band_.push_back({static_cast<std::uint32_t>(k), static_cast<float>(s), static_cast<float>(t),
                         image_.q[k], static_cast<float>(wide_.at(i, j)), static_cast<float>(below)});
      }
  }

  [[nodiscard]] bool small(std::int16_t label) {
    const auto k = static_cast<std::size_t>(label);
    while (small_.size() <= k) {
      const FaceExtent e = extent_of(faces_[small_.size()], image_.geometry);
      small_.push_back(e.narrow_m < config_.max_edge_m);
    }
    return small_[k];
  }

  // pixels where the edge face lies behind the wide one's plane, and so is what the camera sees of a convex
  // edge
  bool refine(double& alpha, double& beta, int rounds, bool turn) {
    for (int round = 0; round < rounds; ++round) {
      double ss = 0, st = 0, tt = 0, sq = 0, tq = 0, n = 0;
      for (const BandPixel& p : band_) {
        const double s = static_cast<double>(p.out), t = static_cast<double>(p.along),
                     q = static_cast<double>(p.q);
        const double edge = alpha * s + beta * t;
        if (edge >= static_cast<double>(p.wide) || static_cast<double>(p.below) > deepest_) continue;
        if (std::abs(q - edge) > config_.edge_faces.gate_sigma * image_.sigma(q)) continue;
        ss += s * s, st += s * t, tt += t * t, sq += s * q, tq += t * q, n += 1;
      }
      if (n < config_.min_pixels) return false;
      const double det = ss * tt - st * st;
      if (turn && det > 1e-9 * ss * tt) {
        alpha = (sq * tt - tq * st) / det;
        beta = (tq * ss - sq * st) / det;
      } else {
        alpha = (sq - beta * st) / ss;
      }
    }
    return true;
  }

  void measure_below(const Vec3& normal, const Vec3& middle, double alpha, double beta) {
    const double below0 = normal.dot(middle - image_.geometry.eye());
    const InversePlane up = image_.geometry.linear(normal);
    for (BandPixel& p : band_) {
      const double edge = alpha * static_cast<double>(p.out) + beta * static_cast<double>(p.along);
      p.below = static_cast<float>(below0 - up.at(image_.column(p.index), image_.row(p.index)) / edge);
    }
  }

  /// How far down at least half of the side is covered (m); 0 where nothing is.
  [[nodiscard]] double thickness(double length) const {
    if (band_.empty()) return 0;
    const double pixel = image_.pixel_m(static_cast<double>(band_[band_.size() / 2].q));
    // one pixel's height on a face that is seen from above
    const double bin = 1.5 * pixel;
    std::vector<double> rows(static_cast<std::size_t>(config_.max_edge_m / bin) + 1, 0.0);
    for (const BandPixel& p : band_) {
      const double below = static_cast<double>(p.below);
      if (below < 0 || below >= static_cast<double>(rows.size()) * bin) continue;
      rows[static_cast<std::size_t>(below / bin)] += 1;
    }
    // pixels that a full row of the face would hold is not known exactly because of its slope; compare with
    // the best row
    double full = 0;
    for (std::size_t i = 0; i < std::min<std::size_t>(rows.size(), 3); ++i) full = std::max(full, rows[i]);
    if (full < 0.4 * length / pixel) return 0;
    std::size_t last = 0;
    while (last < rows.size() && rows[last] > 0.5 * full) ++last;
    return static_cast<double>(last) * bin;
  }

  // false where too little speaks for the face
  bool accept(const FaceRectangle& from, const Vec3& outward, const Vec3& along, double alpha, double beta) {
    std::vector<std::uint32_t> mine, lost;
    double gain = 0, behind = 0;
    Face face;
    face.plane = image_.geometry.linear(alpha * outward + beta * along);
    for (const BandPixel& p : band_) {
      const double edge = alpha * static_cast<double>(p.out) + beta * static_cast<double>(p.along);
      const double q = static_cast<double>(p.q), wide = static_cast<double>(p.wide);
      if (edge >= wide || static_cast<double>(p.below) > deepest_) continue;
      if (std::abs(q - edge) > image_.tolerance(q, config_.tolerance_sigma)) {
        if (image_.label[p.index] == from.face) lost.push_back(p.index);
        continue;
      }
      const double s = image_.sigma(q);
      gain += ((q - wide) * (q - wide) - (q - edge) * (q - edge)) / (s * s);
      behind += (wide - q) / s;
      mine.push_back(p.index);
    }
    const double n = static_cast<double>(mine.size());
    if (n < config_.min_pixels || gain < config_.edge_faces.min_gain ||
        behind < config_.edge_faces.min_depth_sigma * n)
      return false;
    const std::int16_t label = add_face(face);
    for (const std::uint32_t k : mine) {
      image_.label[k] = label;
      faces_.back().moments.add(image_.column(k), image_.row(k), static_cast<double>(image_.q[k]));
    }
    for (const std::uint32_t k : lost) image_.label[k] = ObjectImage::kFree;
    return true;
  }

  ObjectImage& image_;
  std::vector<Face>& faces_;
  Vec3 up_;
  const SurfaceConfig& config_;
  InversePlane out_, along_, wide_;
  std::vector<BandPixel> band_;
  std::vector<bool> small_;
  std::vector<Rim> rims_;
  double deepest_ = 0;
};

}  // namespace

void find_edge_faces(ObjectImage& image, std::vector<Face>& faces,
                     const std::vector<FaceRectangle>& rectangles, const Ground& ground,
                     const SurfaceConfig& config) {
  const std::size_t grown = faces.size();
  EdgeSearch search(image, faces, ground, config);
  for (const FaceRectangle& r : rectangles) {
    if (r.rectangle.size.y() < 1.5 * config.max_edge_m) continue;
    const Vec3 u = r.rectangle.u, v = r.rectangle.v, c = r.rectangle.center;
    const double w = r.rectangle.size.x(), h = r.rectangle.size.y();
    search.side(r, u, c + 0.5 * w * u, h);
    search.side(r, -u, c - 0.5 * w * u, h);
    search.side(r, v, c + 0.5 * h * v, w);
    search.side(r, -v, c - 0.5 * h * v, w);
  }
  search.follow_rims();
  if (faces.size() == grown) return;
  // edge faces keep the planes that were forced to be perpendicular
  std::vector<InversePlane> forced;
  for (std::size_t k = grown; k < faces.size(); ++k) forced.push_back(faces[k].plane);
  refit_faces(image, faces);
  for (std::size_t k = grown; k < faces.size(); ++k) faces[k].plane = forced[k - grown];
}

}  // namespace colift::perception
