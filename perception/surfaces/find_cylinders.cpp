#include "perception/surfaces/find_cylinders.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "perception/surfaces/cylinder_fit.hpp"
#include "perception/surfaces/object_parts.hpp"

namespace colift::perception {
namespace {

// Angle of (x, y) as a part of a turn, 0 to 1, within 0.0007
double turn(double x, double y) {
  const double ax = std::abs(x), ay = std::abs(y), high = std::max(ax, ay);
  if (!(high > 0)) return 0.0;
  const double r = std::min(ax, ay) / high;
  double eighth = r * (0.125 + 0.0433 * (1.0 - r));  // arc tangent over 2 pi
  if (ay > ax) eighth = 0.25 - eighth;
  if (x < 0) eighth = 0.5 - eighth;
  return y < 0 ? 1.0 - eighth : eighth;
}

class Search {
 public:
  Search(ObjectImage& image, std::vector<Face>& faces, const Ground& ground, const SurfaceConfig& config)
      : image_(image),
        faces_(faces),
        up_(ground.plane.normal),
        config_(config),
        min_part_(static_cast<std::size_t>(config.cylinders.min_part_pixels)),
        max_points_(static_cast<std::size_t>(config.cylinders.max_points)),
        parts_(image, config.cylinders),
        corner_(image.geometry.ray_W(0, 0)),
        right_(image.geometry.ray_W(1, 0) - corner_),
        down_(image.geometry.ray_W(0, 1) - corner_) {}

  std::vector<Cylinder> run(std::size_t first_edge) {
    std::vector<bool> strip(faces_.size());
    for (std::size_t k = 0; k < faces_.size(); ++k)
      strip[k] = k < first_edge && extent_of(faces_[k], image_.geometry).narrow_m <
                                       widest_strip(image_, faces_[k].inverse_depth(), config_);
    std::vector<Cylinder> found;
    std::vector<Part> tried = parts(strip);
    std::stable_sort(tried.begin(), tried.end(),
                     [](const Part& a, const Part& b) { return a.size() > b.size(); });
    const auto max_parts = static_cast<std::size_t>(config_.cylinders.max_parts);
    if (tried.size() > max_parts) tried.resize(max_parts);
    for (const Part& part : tried) {
      if (const auto c = cylinder_of(part))
        found.push_back(*c);
      else
        cylinders_within(part, found);
    }
    if (!found.empty()) drop_remains();
    return found;
  }

 private:
  std::vector<Part> parts(const std::vector<bool>& strip) {
    Part open;
    for (const std::uint32_t k : image_.pixels) {
      const std::int16_t l = image_.label[k];
      if (l == ObjectImage::kFree || (l >= 0 && strip[static_cast<std::size_t>(l)])) open.push_back(k);
    }
    parts_.open(open);
    return parts_.connected(open, min_part_);
  }

  [[nodiscard]] SightedPoint sighted(std::uint32_t k) const {
    const double U = image_.column(k), V = image_.row(k), q = static_cast<double>(image_.q[k]), z = 1.0 / q;
    const Vec3 ray = corner_ + U * right_ + V * down_;
    return {image_.geometry.eye() + z * ray, ray, image_.sigma(q) * z * z};
  }

  std::optional<Cylinder> cylinder_of(const Part& part, const std::optional<Vec3>& known_axis = {}) {
    Part body;
    body.reserve(part.size());
    for (const std::uint32_t k : part)
      if (parts_.inner(k)) body.push_back(k);
    count_faces(part);
    if (body.size() < min_part_ / 2) return std::nullopt;
    const std::vector<Vec3> axes =
        known_axis ? std::vector<Vec3>{*known_axis} : axes_of(sample(body, max_points_ / 3));

    std::optional<CylinderFit> best;
    for (const Vec3& axis : axes) {
      // a flat end lies inside the circle
      Part rest;
      const Part& mantle = without_ends(body, axis, rest);
      if (mantle.size() < 0.4 * static_cast<double>(body.size())) continue;
      const std::vector<SightedPoint> some = sample(mantle, max_points_);
      const auto fit = fit_cylinder(some, std::span(&axis, 1), image_.geometry.eye(), config_);
      if (fit && (!best || fit->misfit < best->misfit)) best = fit;
    }
    if (!best) return std::nullopt;
    Part rest;
    const auto points = sample(without_ends(body, best->cylinder.axis, rest), max_points_);
    if (!rounder_than_corner(*best, points)) return std::nullopt;
    return claim(part, without_bias(points, best->cylinder, config_));
  }

  [[nodiscard]] bool rounder_than_corner(const CylinderFit& fit,
                                         const std::vector<SightedPoint>& points) const {
    const double corner = corner_misfit(points, fit.cylinder, config_.cylinders);
    return fit.misfit * fit.misfit <= config_.cylinder_advantage * corner * corner;
  }

  /// A part may be more than a cylinder: narrow faces of what it lies on or is joined to pass for strips too.
  /// So each large strip suggests cylinders, and what lies around such a one is tried as a part of its own.
  /// A strip alone shows too little of a mantle, but the rest may be of one face with the side of what the
  /// cylinder lies on: it is tried with all that is seen beside it.
  void cylinders_within(const Part& part, std::vector<Cylinder>& found) {
    const std::vector<std::size_t> strips = largest_faces(part);
    if (strips.empty()) return;
    const bool alone = strips.size() == 1;
    if (alone && !is_long(faces_[strips.front()])) return;
    Part wider;
    if (alone) {
      const double q = faces_[strips.front()].inverse_depth();
      wider = parts_.around(part, static_cast<int>(widest_strip(image_, q, config_) / image_.pixel_m(q)));
    }
    const Part& area = alone ? wider : part;
    const std::vector<SightedPoint> points = sample(area, max_points_);
    for (const std::size_t f : strips) {
      Part strip;
      for (const std::uint32_t k : part)
        if (image_.label[k] == static_cast<std::int16_t>(f)) strip.push_back(k);
      if (strip.size() < min_part_) continue;  // an earlier cylinder has it
      count_faces(part);
      const std::vector<SightedPoint> seed = sample(strip, max_points_ / 3);
      for (const Vec3& axis : axes_of(seed)) {
        const auto rough = suggested_by(seed, points, axis);
        const auto c = rough ? cylinder_around(*rough, area, !alone) : std::nullopt;
        if (!c) continue;
        found.push_back(*c);
        break;
      }
    }
  }

  [[nodiscard]] bool is_long(const Face& face) const {
    const FaceExtent extent = extent_of(face, image_.geometry);
    return extent.wide_m > config_.cylinders.min_strip_ratio * extent.narrow_m;
  }

  [[nodiscard]] std::vector<std::size_t> largest_faces(const Part& part) {
    count_faces(part);
    std::vector<std::size_t> faces;
    for (std::size_t k = 0; k < faces_.size(); ++k)
      if (count_[k] >= config_.cylinders.min_part_pixels) faces.push_back(k);
    std::stable_sort(faces.begin(), faces.end(),
                     [&](std::size_t a, std::size_t b) { return count_[a] > count_[b]; });
    const auto max_strips = static_cast<std::size_t>(config_.cylinders.max_strips);
    if (faces.size() > max_strips) faces.resize(max_strips);
    return faces;
  }

  /// The cylinder that a strip suggests, drawn to those of the part's points that lie near it.
  [[nodiscard]] std::optional<Cylinder> suggested_by(const std::vector<SightedPoint>& strip,
                                                     const std::vector<SightedPoint>& part, Vec3 axis) const {
    SurfaceConfig loose = config_;
    loose.cylinder_min_arc_deg = 0;  // of one strip
    auto fit = fit_cylinder(strip, std::span(&axis, 1), image_.geometry.eye(), loose);
    std::vector<SightedPoint> near;
    for (const double band_radii : {0.3, config_.cylinders.tube_radii}) {
      if (!fit) return std::nullopt;
      near.clear();
      for (const SightedPoint& s : part)
        if (std::abs(distance_to(fit->cylinder, s).value_m) < band(fit->cylinder, s, band_radii))
          near.push_back(s);
      axis = fit->cylinder.axis;
      fit = fit_cylinder(near, std::span(&axis, 1), image_.geometry.eye(), config_);
    }
    if (!fit || !rounder_than_corner(*fit, near)) return std::nullopt;
    return fit->cylinder;
  }

  [[nodiscard]] double band(const Cylinder& c, const SightedPoint& s, double radii) const {
    return config_.cylinders.inlier_sigma * distance_to(c, s).sigma_m + config_.tolerance_m +
           radii * c.radius;
  }

  /// Tries what of a part lies in or close around a rough cylinder. The edge of a box looks round too when it
  /// is cut out so, but the box goes on beside it: most of the rim of a cylinder has to be free.
  /// Of `strips_only`, faces of which most lies elsewhere are of something else.
  std::optional<Cylinder> cylinder_around(const Cylinder& rough, const Part& part, bool strips_only) {
    Part tube;
    for (const std::uint32_t k : part) {
      if (image_.label[k] == ObjectImage::kCylinder) continue;
      const SightedPoint s = sighted(k);
      if (distance_to(rough, s).value_m < band(rough, s, config_.cylinders.tube_radii)) tube.push_back(k);
    }
    count_faces(tube);
    if (strips_only)
      std::erase_if(tube, [&](std::uint32_t k) {
        const std::int16_t f = image_.label[k];
        if (f < 0) return false;
        const auto face = static_cast<std::size_t>(f);
        return count_[face] < config_.cylinders.min_face_fraction * faces_[face].moments.n;
      });
    std::vector<std::int32_t> before;
    for (const std::uint32_t k : tube) before.push_back(parts_.number(k));
    parts_.open(tube);
    const std::vector<Part> bodies = parts_.connected(tube, min_part_);
    const auto body = std::max_element(bodies.begin(), bodies.end(),
                                       [](const Part& a, const Part& b) { return a.size() < b.size(); });
    std::optional<Cylinder> c;
    if (body != bodies.end() && parts_.open_rim(*body) < config_.cylinders.max_open_rim)
      c = cylinder_of(*body, rough.axis);
    for (std::size_t i = 0; i < tube.size(); ++i)
      if (image_.label[tube[i]] != ObjectImage::kCylinder) parts_.set_number(tube[i], before[i]);
    return c;
  }

  [[nodiscard]] std::vector<SightedPoint> sample(const std::vector<std::uint32_t>& pixels,
                                                 std::size_t most) const {
    std::vector<SightedPoint> points;
    const std::size_t step = pixels.size() / most + 1;
    for (std::size_t i = 0; i < pixels.size(); i += step) points.push_back(sighted(pixels[i]));
    return points;
  }

  /// Counts the pixels that each face has of a part.
  void count_faces(const Part& part) {
    count_.assign(faces_.size(), 0);
    for (const std::uint32_t k : part)
      if (image_.label[k] >= 0) ++count_[static_cast<std::size_t>(image_.label[k])];
  }

  /// The pixels that lie on no flat end, in `rest` or `body` itself.
  [[nodiscard]] const Part& without_ends(const Part& body, const Vec3& axis, Part& rest) const {
    std::vector<bool> end(faces_.size());
    bool any = false;
    for (std::size_t k = 0; k < faces_.size(); ++k) {
      end[k] = count_[k] > 0 && std::abs(image_.geometry.to_W(faces_[k].plane).normal.dot(axis)) >
                                    config_.cylinders.end_cosine;
      any = any || end[k];
    }
    if (!any) return body;
    rest.clear();
    for (const std::uint32_t k : body)
      if (image_.label[k] < 0 || !end[static_cast<std::size_t>(image_.label[k])]) rest.push_back(k);
    return rest;
  }

  // the long way of the part, upright, and what is perpendicular to its two largest strips
  [[nodiscard]] std::vector<Vec3> axes_of(const std::vector<SightedPoint>& points) const {
    std::vector<Vec3> axes;
    Vec3 mean = Vec3::Zero();
    for (const SightedPoint& s : points) mean += s.p;
    mean /= static_cast<double>(points.size());
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const SightedPoint& s : points) spread += (s.p - mean) * (s.p - mean).transpose();
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    solver.computeDirect(spread);
    if (solver.eigenvalues()[2] > 2.5 * solver.eigenvalues()[1])
      axes.push_back(solver.eigenvectors().col(2).normalized());
    axes.push_back(up_);

    const std::vector<int>& count = count_;
    std::size_t first = 0, second = 0;
    for (std::size_t k = 0; k < count.size(); ++k) {
      if (count[k] > count[first])
        second = first, first = k;
      else if (k != first && (second == first || count[k] > count[second]))
        second = k;
    }
    if (first != second && count[second] > 30) {
      const Vec3 cross = image_.geometry.to_W(faces_[first].plane)
                             .normal.cross(image_.geometry.to_W(faces_[second].plane).normal);
      if (cross.norm() > 0.2) axes.push_back(cross.normalized());
    }
    // what is nearly the same ends up the same
    for (std::size_t k = axes.size(); k-- > 1;)
      if (std::any_of(axes.begin(), axes.begin() + static_cast<std::ptrdiff_t>(k), [&](const Vec3& a) {
            return std::abs(a.dot(axes[k])) > config_.cylinders.same_axis_cosine;
          }))
        axes.erase(axes.begin() + static_cast<std::ptrdiff_t>(k));
    return axes;
  }

  std::optional<Cylinder> claim(const Part& part, Cylinder c) {
    Part rest;
    const std::size_t mantle = without_ends(part, c.axis, rest).size();
    Part mine;
    const auto [e1, e2] = hal::tangents(c.axis);
    constexpr int kBins = 48;  // lines along the mantle, 7.5 degrees apart
    double low[kBins], high[kBins];
    int count[kBins] = {};
    std::fill(low, low + kBins, std::numeric_limits<double>::infinity());
    std::fill(high, high + kBins, -std::numeric_limits<double>::infinity());
    for (const std::uint32_t k : part) {
      const SightedPoint s = sighted(k);
      if (!on_mantle(c, s, config_.cylinders.inlier_sigma)) continue;
      mine.push_back(k);
      const Vec3 p = s.p - c.center;
      const int bin = std::clamp(static_cast<int>(turn(e1.dot(p), e2.dot(p)) * kBins), 0, kBins - 1);
      const double along = c.axis.dot(p);
      ++count[bin];
      low[bin] = std::min(low[bin], along), high[bin] = std::max(high[bin], along);
    }
    if (static_cast<double>(mine.size()) <
        config_.cylinders.min_inlier_fraction * static_cast<double>(mantle))
      return std::nullopt;
    // only lines along the cylinder that are well seen tell where it ends
    const int most = *std::max_element(count, count + kBins);
    std::vector<double> lows, highs;
    for (int b = 0; b < kBins; ++b)
      if (3 * count[b] > most && low[b] < high[b]) lows.push_back(low[b]), highs.push_back(high[b]);
    if (lows.empty()) return std::nullopt;
    const auto median = [](std::vector<double>& v) {
      const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
      std::nth_element(v.begin(), middle, v.end());
      return *middle;
    };
    const double half_pixel = 0.5 * image_.pixel_m(static_cast<double>(image_.q[part[part.size() / 2]]));
    const double first = median(lows) - half_pixel, last = median(highs) + half_pixel;
    if (last - first < config_.cylinders.min_length_radii * c.radius) return std::nullopt;
    c.center += 0.5 * (first + last) * c.axis;
    c.length = last - first;
    // the axis points up, or along the world's axes where it lies
    Vec3::Index largest;
    c.axis.cwiseAbs().maxCoeff(&largest);
    const double sign = std::abs(c.axis.dot(up_)) > 0.1 ? c.axis.dot(up_) : c.axis[largest];
    if (sign < 0) c.axis = -c.axis;
    for (const std::uint32_t k : mine) image_.label[k] = ObjectImage::kCylinder;
    free_faces_on(c);
    return c;
  }

  // Strips of the mantle that seemed too wide for one, or that ragged rims and shadows have bent away, are
  // free. The side of a block that a pipe lies on may go on, in one plane, on the pipe: what of such a face
  // lies on the mantle is the cylinder's.
  void free_faces_on(const Cylinder& c) {
    constexpr std::size_t kStep = 5;  // a fraction is as well known from every fifth pixel
    std::vector<int> near(faces_.size(), 0), all(faces_.size(), 0);
    for (std::size_t i = 0; i < image_.pixels.size(); i += kStep) {
      const std::uint32_t k = image_.pixels[i];
      if (image_.label[k] < 0) continue;
      const auto f = static_cast<std::size_t>(image_.label[k]);
      ++all[f];
      near[f] += lies_on(c, sighted(k), config_.cylinders.near_sigma);
    }
    std::vector<bool> gone(faces_.size()), shared(faces_.size());
    for (std::size_t f = 0; f < gone.size(); ++f) {
      if (std::abs(image_.geometry.to_W(faces_[f].plane).normal.dot(c.axis)) >= config_.cylinders.end_cosine)
        continue;
      gone[f] = near[f] > config_.cylinders.min_near_fraction * all[f];
      shared[f] = near[f] > config_.cylinders.min_shared_fraction * all[f];
    }
    if (std::find(shared.begin(), shared.end(), true) == shared.end()) return;
    for (const std::uint32_t k : image_.pixels) {
      if (image_.label[k] < 0) continue;
      const auto f = static_cast<std::size_t>(image_.label[k]);
      if (gone[f])
        image_.label[k] = ObjectImage::kFree;
      else if (shared[f] && lies_on(c, sighted(k), config_.cylinders.inlier_sigma))
        image_.label[k] = ObjectImage::kCylinder;
    }
  }

  /// On a cylinder of any length.
  [[nodiscard]] bool on_mantle(const Cylinder& c, const SightedPoint& s, double sigmas) const {
    const MantleDistance d = distance_to(c, s);
    return std::abs(d.value_m) <= sigmas * d.sigma_m + config_.tolerance_m;
  }

  [[nodiscard]] bool lies_on(const Cylinder& c, const SightedPoint& s, double sigmas) const {
    return std::abs(c.axis.dot(s.p - c.center)) <= 0.5 * c.length + config_.tolerance_m &&
           on_mantle(c, s, sigmas);
  }

  void drop_remains() {
    std::vector<double> before(faces_.size());
    for (std::size_t k = 0; k < faces_.size(); ++k) before[k] = faces_[k].moments.n;
    refit_faces(image_, faces_);
    std::vector<bool> dropped(faces_.size());
    for (std::size_t k = 0; k < faces_.size(); ++k) {
      dropped[k] = faces_[k].moments.n < config_.cylinders.min_rest_fraction * before[k];
      if (dropped[k]) faces_[k].moments = {};
    }
    for (const std::uint32_t k : image_.pixels)
      if (image_.label[k] >= 0 && dropped[static_cast<std::size_t>(image_.label[k])])
        image_.label[k] = ObjectImage::kFree;
  }

  ObjectImage& image_;
  std::vector<Face>& faces_;
  Vec3 up_;
  const SurfaceConfig& config_;
  std::size_t min_part_, max_points_;
  ObjectParts parts_;
  Vec3 corner_, right_, down_;  // ray of the first pixel, and what a step in the image adds to it
  std::vector<int> count_;      // pixels of each face in the present part
};

}  // namespace

std::vector<Cylinder> find_cylinders(ObjectImage& image, std::vector<Face>& faces, std::size_t first_edge,
                                     const Ground& ground, const SurfaceConfig& config) {
  return Search(image, faces, ground, config).run(first_edge);
}

double widest_strip(const ObjectImage& image, double inverse_depth, const SurfaceConfig& config) {
  const double sag = config.cylinders.strip_sag_sigma * image.noise.sigma(1.0 / inverse_depth);
  return 2.0 * std::sqrt(2.0 * config.cylinder_max_radius_m * sag) + 2.0 * image.pixel_m(inverse_depth);
}

}  // namespace colift::perception
