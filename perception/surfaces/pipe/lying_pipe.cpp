#include "perception/surfaces/pipe/lying_pipe.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "perception/surfaces/cylinder_fit.hpp"

namespace colift::perception {
namespace {

constexpr double kMaxSlope = 0.2;  // sine of the axis' angle to the ground: as of a rod on two uneven things
constexpr double kMinLength_m = 0.7;  // shorter ones are handles and rungs
constexpr double kMinSpan = 0.8;      // of the target's length, as of shapes that are completed as cylinders
constexpr double kMinClear_m = 0.06;  // from the ground to its lower side: less is no stand
constexpr double kMaxBeside = 0.04;   // part of the target's pixels that may lie beside or above it: strays
constexpr double kSlice_m = 0.02;     // along the axis: some pixels at 2 m
constexpr int kMinInSlice = 3;        // pixels: fewer are strays
constexpr int kMaxGap = 3;            // slices in a row that show nothing of it: a stand's rim before it
constexpr double kPart_m = 0.1;  // how much longer than it was found it is at least, if it was found in parts
constexpr double kStandHeight = 0.5;     // of the axis' height: what is lower is a stand, never the pipe
constexpr double kMaxThicker = 1.25;     // a fit in the open corrects a mantle that took part of a stand ...
constexpr double kMinThinner = 0.5;      // ... and 80 % too thick was the worst of 100
constexpr std::size_t kMaxPoints = 500;  // of a fit, as in CylinderSearchConfig

struct Slice {
  int on = 0, under = 0;
};

class Along {
 public:
  Along(const OrganisedCloud& cloud, const Target& target, const Ground& ground, const NoiseModel& noise,
        const SurfaceConfig& config)
      : cloud_(cloud), target_(target), ground_(ground), noise_(noise), config_(config) {}

  /// Which stretch of the target's pixels along its axis the cylinder really has, or nothing where it is no
  /// pipe on stands. Sets its length and middle.
  /// `slack_m`: how far from a rough mantle its pixels may lie.
  [[nodiscard]] bool measure(Cylinder& c, double slack_m = 0.0) {
    const double height = ground_.plane.height(c.center);
    if (height - c.radius < kMinClear_m) return false;
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const auto& p : target_.points) {
      const double at = c.axis.dot(p.cast<double>() - c.center);
      low = std::min(low, at), high = std::max(high, at);
    }
    first_ = low;
    slices_.assign(static_cast<std::size_t>((high - low) / kSlice_m) + 1, {});
    std::size_t beside = 0, grounded = 0;
    for (const std::uint32_t i : target_.pixels) {
      const SightedPoint s = sighted(i);
      Slice& slice = slices_[slice_of(c, s.p)];
      const double up = ground_.plane.height(s.p);
      if (on_mantle(c, s, slack_m))
        ++slice.on;
      else if (up > height && !inside(c, s))
        ++beside;
      if (up < kStandHeight * height) ++slice.under, ++grounded;
    }
    if (static_cast<double>(beside) > kMaxBeside * static_cast<double>(target_.pixels.size()) ||
        grounded < static_cast<std::size_t>(kMinInSlice))
      return false;
    // from its middle outwards
    const auto middle = static_cast<std::ptrdiff_t>(slice_of(c, c.center));
    const std::ptrdiff_t begin = end_of(middle, -1), end = end_of(middle, 1);
    const double from = first_ + static_cast<double>(begin) * kSlice_m,
                 to = first_ + static_cast<double>(end + 1) * kSlice_m;
    const double length = std::max(to - from, c.length);
    if (length < kMinLength_m || length < kMinSpan * (high - low)) return false;
    if (to - from > c.length + kPart_m) {
      c.center += 0.5 * (from + to) * c.axis;
      c.length = to - from;
      first_ -= 0.5 * (from + to);
    }
    return true;
  }

  /// The same cylinder by the pixels under which nothing stands; nothing of what is no rounder than a bar.
  [[nodiscard]] std::optional<Cylinder> fit_in_the_open(const Cylinder& c) const {
    std::vector<SightedPoint> open;
    std::vector<std::uint8_t> own(cloud_.size(), 0);
    for (const std::uint32_t i : target_.pixels) own[i] = 1;
    for (const std::uint32_t i : target_.pixels) {
      if (!is_inner(own, i)) continue;
      const SightedPoint s = sighted(i);
      if (std::abs(c.axis.dot(s.p - c.center)) < 0.5 * c.length && is_open(slice_of(c, s.p)))
        open.push_back(s);
    }
    if (open.size() < static_cast<std::size_t>(config_.cylinders.min_part_pixels)) return std::nullopt;
    std::vector<SightedPoint> some;
    const std::size_t step = open.size() / kMaxPoints + 1;
    for (std::size_t k = 0; k < open.size(); k += step) some.push_back(open[k]);
    const auto fit = fit_cylinder(some, std::span(&c.axis, 1), cloud_.X_WC.translation(), config_);
    if (!fit) return std::nullopt;
    const double corner = corner_misfit(some, fit->cylinder, config_.cylinders);
    if (fit->misfit * fit->misfit > config_.cylinder_advantage * corner * corner) return std::nullopt;
    Cylinder better = without_bias(some, fit->cylinder, config_);
    if (better.axis.dot(c.axis) < 0) better.axis = -better.axis;
    // its middle is that of the same stretch
    better.center += better.axis.dot(c.center - better.center) * better.axis;
    better.length = c.length;
    return better;
  }

  [[nodiscard]] std::vector<std::uint32_t> pixels_of(const Cylinder& c) const {
    std::vector<std::uint32_t> own;
    for (const std::uint32_t i : target_.pixels) {
      const SightedPoint s = sighted(i);
      if (std::abs(c.axis.dot(s.p - c.center)) <= 0.5 * c.length + config_.tolerance_m + s.sigma_m &&
          (on_mantle(c, s) || inside(c, s)))
        own.push_back(i);
    }
    return own;
  }

 private:
  [[nodiscard]] SightedPoint sighted(std::uint32_t i) const {
    const auto depth = static_cast<double>(cloud_.depth_m[i]);
    const Vec3 p = cloud_.point(i);
    return {p, (p - cloud_.X_WC.translation()) / depth, noise_.sigma(depth)};
  }
  [[nodiscard]] std::size_t slice_of(const Cylinder& c, const Vec3& p) const {
    const double at = (c.axis.dot(p - c.center) - first_) / kSlice_m;
    return static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(slices_.size()) - 1.0));
  }
  [[nodiscard]] bool on_mantle(const Cylinder& c, const SightedPoint& s, double slack_m = 0.0) const {
    const MantleDistance d = distance_to(c, s);
    return std::abs(d.value_m) <= config_.cylinders.inlier_sigma * d.sigma_m + config_.tolerance_m + slack_m;
  }
  // A pixel at a rim is a mean of the pipe and what is behind it.
  [[nodiscard]] bool is_inner(const std::vector<std::uint8_t>& own, std::size_t i) const {
    const auto w = static_cast<std::size_t>(cloud_.width());
    return i >= w && i + w < own.size() && own[i - 1] && own[i + 1] && own[i - w] && own[i + w];
  }
  // its flat ends
  [[nodiscard]] static bool inside(const Cylinder& c, const SightedPoint& s) {
    return distance_to(c, s).value_m < 0.0;
  }
  [[nodiscard]] std::ptrdiff_t end_of(std::ptrdiff_t from, std::ptrdiff_t step) const {
    std::ptrdiff_t last = from;
    for (std::ptrdiff_t k = from; k >= 0 && k < std::ssize(slices_); k += step) {
      if (slices_[static_cast<std::size_t>(k)].on >= kMinInSlice) last = k;
      if (std::abs(k - last) > kMaxGap) break;
    }
    return last;
  }
  // nothing stands under it nor beside that
  [[nodiscard]] bool is_open(std::size_t k) const {
    for (std::size_t near = k > 0 ? k - 1 : 0; near <= std::min(k + 1, slices_.size() - 1); ++near)
      if (slices_[near].under >= kMinInSlice) return false;
    return true;
  }

  const OrganisedCloud& cloud_;
  const Target& target_;
  const Ground& ground_;
  const NoiseModel& noise_;
  const SurfaceConfig& config_;
  double first_ = 0.0;  // where the first slice begins along the axis, from the cylinder's middle
  std::vector<Slice> slices_;
};

std::optional<Cylinder> longest_cylinder(const std::vector<Surface>& surfaces, const Ground& ground) {
  std::optional<Cylinder> longest;
  for (const Surface& s : surfaces) {
    const auto* c = std::get_if<Cylinder>(&s);
    if (c && std::abs(c->axis.dot(ground.plane.normal)) < kMaxSlope &&
        (!longest || c->length > longest->length))
      longest = *c;
  }
  return longest;
}

// A thin or far pipe passes for a narrow face: a rough cylinder behind it, of which it is the visible half.
std::optional<Cylinder> longest_strip(const std::vector<Surface>& surfaces, const Ground& ground,
                                      const SurfaceConfig& config) {
  std::optional<Cylinder> longest;
  for (const Surface& s : surfaces) {
    const auto* r = std::get_if<Rectangle>(&s);
    if (!r || r->size.minCoeff() > config.max_edge_m) continue;
    const bool along_u = r->size.x() > r->size.y();
    const Vec3 axis = along_u ? r->u : r->v;
    if (std::abs(axis.dot(ground.plane.normal)) > kMaxSlope ||
        (longest && longest->length >= r->size.maxCoeff()))
      continue;
    const double radius = 0.5 * r->size.minCoeff();
    longest = Cylinder{r->center - radius * r->normal, axis, radius, r->size.maxCoeff()};
  }
  return longest;
}

}  // namespace

std::optional<LyingPipe> find_lying_pipe(const OrganisedCloud& cloud, const Target& target,
                                         const std::vector<Surface>& surfaces, const Ground& ground,
                                         const NoiseModel& noise, const SurfaceConfig& config) {
  Along along(cloud, target, ground, noise, config);
  LyingPipe pipe;
  if (const auto found = longest_cylinder(surfaces, ground)) {
    pipe.cylinder = *found;
    if (!along.measure(pipe.cylinder)) return std::nullopt;
    const auto better = along.fit_in_the_open(pipe.cylinder);
    const double ratio = better ? better->radius / found->radius : 0.0;
    if (ratio > kMinThinner && ratio < kMaxThicker) pipe.cylinder = *better;
  } else if (const auto strip = longest_strip(surfaces, ground, config)) {
    Cylinder rough = *strip;
    if (!along.measure(rough, rough.radius)) return std::nullopt;
    const auto fitted = along.fit_in_the_open(rough);
    if (!fitted) return std::nullopt;
    pipe.cylinder = *fitted;
    if (!along.measure(pipe.cylinder)) return std::nullopt;
  } else {
    return std::nullopt;
  }
  pipe.pixels = along.pixels_of(pipe.cylinder);
  if (pipe.pixels.size() < static_cast<std::size_t>(config.cylinders.min_part_pixels)) return std::nullopt;
  return pipe;
}

}  // namespace colift::perception
