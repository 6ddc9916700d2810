#include "perception/target/regions/fragments.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include "perception/target/regions/fragment_gaps.hpp"

namespace colift::perception {
namespace {

// Resolution of footprints. It only has to be finer than the overlaps that FragmentConfig asks for.
constexpr double kCell_m = 0.04;
constexpr double kCellsPerMeter = 1.0 / kCell_m;
constexpr double kSlender = 1.5;  // height over width of what falls over if nothing holds it
// What is lower than kContact_m touches the ground. Where that is one spot, with the middle of the footprint
// farther beside it than kBeside_m, the thing would fall over alone; and where it is kUpright times as high
// as what it touches is wide, in a direction in which the camera sees how wide that is.
constexpr double kContact_m = 0.08, kSpot_m = 0.15, kBeside_m = 0.05, kUpright = 6.0, kInView = 0.7;
// What touches the ground in a part of its span this small, beside its middle, has another leg.
constexpr double kOneLeg = 0.3;
// Max thickness of a plate, noise included.
constexpr double kPlate_m = 0.12;
// Max pixels of the foot of a plate in the air, as a fraction of the plate's, which hides most of it.
constexpr double kMaxFoot = 0.6;
constexpr std::size_t kFootprintStride = 4;  // every fourth pixel still hits each cell several times

// std::floor is a library call on plain x86-64
std::int64_t floor_of(double x) {
  const auto whole = static_cast<std::int64_t>(x);
  return whole - (x < static_cast<double>(whole) ? 1 : 0);
}

struct GroundAxes {
  explicit GroundAxes(const Ground& ground) : plane(ground.plane) {
    std::tie(s, t) = hal::tangents(plane.normal);
  }
  [[nodiscard]] std::int64_t cell(const Vec3& p) const {
    const std::int64_t i = floor_of(s.dot(p) * kCellsPerMeter), j = floor_of(t.dot(p) * kCellsPerMeter);
    return (i << 32) + (j + (std::int64_t{1} << 31));
  }
  [[nodiscard]] static Eigen::Vector2d center(std::int64_t cell) {
    const auto i = static_cast<double>(cell >> 32);
    const auto j = static_cast<double>((cell & 0xffffffff) - (std::int64_t{1} << 31));
    return {(i + 0.5) * kCell_m, (j + 0.5) * kCell_m};
  }
  [[nodiscard]] Eigen::Vector2d on_ground(const Vec3& p) const { return {s.dot(p), t.dot(p)}; }
  Plane plane;
  Vec3 s, t;
};

// part of the smaller footprint that both share
double footprint_overlap(const Fragment& a, const Fragment& b) {
  std::size_t shared = 0;
  auto i = a.cells.begin();
  auto j = b.cells.begin();
  while (i != a.cells.end() && j != b.cells.end()) {
    shared += *i == *j;
    const bool first = *i <= *j, second = *j <= *i;
    i += first;
    j += second;
  }
  const std::size_t smaller = std::min(a.cells.size(), b.cells.size());
  return smaller ? static_cast<double>(shared) / static_cast<double>(smaller) : 0.0;
}

// the least rectangle around cells: of a fragment's footprint it has the corner that the view hides
FlatRectangle rectangle_around(const std::vector<std::int64_t>& cells) {
  std::vector<Eigen::Vector2d> centers;
  centers.reserve(cells.size());
  for (const std::int64_t c : cells) centers.push_back(GroundAxes::center(c));
  return minimum_area_rectangle(convex_hull(centers));
}

double fraction_under(const Fragment& small, const FlatRectangle& r) {
  if (small.cells.empty()) return 0.0;
  std::size_t inside = 0;
  for (const std::int64_t cell : small.cells) {
    const Eigen::Vector2d d = GroundAxes::center(cell) - r.center;
    // a cell's width of slack: a leg stands flush with the plate's rim
    inside += std::abs(r.u.dot(d)) <= 0.5 * r.size.x() + kCell_m &&
              std::abs(r.v().dot(d)) <= 0.5 * r.size.y() + kCell_m;
  }
  return static_cast<double>(inside) / static_cast<double>(small.cells.size());
}

std::vector<std::int64_t> united(const std::vector<std::int64_t>& a, const std::vector<std::int64_t>& b) {
  std::vector<std::int64_t> all;
  std::set_union(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(all));
  return all;
}

Fragment joined(const Fragment& a, const Fragment& b) {
  Fragment f = a;
  f.labels.insert(f.labels.end(), b.labels.begin(), b.labels.end());
  std::sort(f.labels.begin(), f.labels.end());
  f.mean_depth_m =
      (a.mean_depth_m * static_cast<double>(a.pixels) + b.mean_depth_m * static_cast<double>(b.pixels)) /
      static_cast<double>(a.pixels + b.pixels);
  f.pixels += b.pixels;
  f.area_m2 += b.area_m2;
  f.min_height_m = std::min(a.min_height_m, b.min_height_m);
  f.max_height_m = std::max(a.max_height_m, b.max_height_m);
  f.u_min = std::min(a.u_min, b.u_min);
  f.u_max = std::max(a.u_max, b.u_max);
  f.v_min = std::min(a.v_min, b.v_min);
  f.v_max = std::max(a.v_max, b.v_max);
  f.cut_left += b.cut_left;
  f.cut_right += b.cut_right;
  f.cut_top += b.cut_top;
  f.cut_bottom += b.cut_bottom;
  f.box.extend(b.box);
  f.cells = united(a.cells, b.cells);
  f.contact = united(a.contact, b.contact);
  return f;
}

Eigen::AlignedBox2d contact_box(const Fragment& f) {
  Eigen::AlignedBox2d box;
  for (const std::int64_t cell : f.contact) box.extend(GroundAxes::center(cell));
  return box;
}

// touches the ground in one spot of at most `spot_m`, and that is not under its middle
bool stands_beside_middle(const Fragment& f, double spot_m) {
  const Eigen::AlignedBox2d contact = contact_box(f);
  if (contact.isEmpty() || contact.diagonal().norm() > spot_m) return false;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const std::int64_t cell : f.cells) middle += GroundAxes::center(cell);
  middle /= static_cast<double>(f.cells.size());
  return contact.exteriorDistance(middle) > kBeside_m;
}

// a table top of which no leg is seen
bool is_plate_in_the_air(const Fragment& f, double min_hanging_height_m) {
  return f.contact.empty() && f.min_height_m > min_hanging_height_m &&
         f.max_height_m - f.min_height_m < kPlate_m;
}

// `eye`: the camera, on the ground
bool would_fall(const Fragment& f, const Eigen::Vector2d& eye) {
  if (f.contact.empty()) return false;
  if (stands_beside_middle(f, kSpot_m)) return true;
  const FlatRectangle foot = rectangle_around(f.contact);
  const bool u_narrow = foot.size.x() < foot.size.y();
  const Eigen::Vector2d narrow = u_narrow ? foot.u : foot.v(), away = (foot.center - eye).normalized();
  const double width_m = (u_narrow ? foot.size.x() : foot.size.y()) + kCell_m;
  const bool spot = contact_box(f).diagonal().norm() <= kSpot_m;
  return f.max_height_m - f.min_height_m > kUpright * width_m &&
         (spot || std::abs(narrow.dot(away)) < kInView);
}

// `gap_m`: distance between both along the image; `behind_m`: of the smaller one behind the larger one
bool belong_together(const Fragment& large, const Fragment& small, double gap_m, double behind_m,
                     const Eigen::Vector2d& eye, const NoiseModel& noise, const FragmentConfig& c) {
  // one surface with a hole in its depth
  const double depth = std::min(large.mean_depth_m, small.mean_depth_m);
  if (gap_m <= c.hole_gap_m + noise.step(depth)) return true;

  // a small part that hangs in the air hangs on its neighbour
  const bool minor =
      static_cast<double>(small.pixels) < c.max_small_fraction * static_cast<double>(large.pixels);
  const bool hangs = small.min_height_m > c.min_hanging_height_m;
  if (minor && hangs && gap_m <= c.hanging_gap_m) return true;
  // what would fall over alone leans on its neighbour, if that is twice as large at least
  const bool lesser = 2 * small.pixels < large.pixels && small.area_m2 < c.max_leaning_area_m2;
  if (lesser && gap_m <= c.hanging_gap_m && would_fall(small, eye)) return true;
  // What neither stands nor could. The joint of what hangs in the air may be behind itself; a slender thing
  // that stands goes on behind its neighbour
  const bool little = minor && small.area_m2 < c.max_hidden_area_m2;
  const bool slender = small.max_height_m - small.min_height_m > kSlender * footprint_span(small);
  if (little && ((hangs && gap_m <= c.hidden_gap_m) || (slender && behind_m <= c.hidden_gap_m))) return true;

  // one stands on the other
  const auto& [upper, lower] =
      small.min_height_m > large.min_height_m ? std::tie(small, large) : std::tie(large, small);
  const double step = upper.min_height_m - lower.max_height_m;
  if (step > -c.height_overlap_m && step < c.standing_gap_m &&
      footprint_overlap(large, small) >= c.min_standing_overlap)
    return true;

  // a leg under its plate: thin, no higher, and within its footprint
  const bool thin =
      footprint_span(small) < std::max(c.max_leg_width_m, small.max_height_m - small.min_height_m);
  return minor && thin && small.max_height_m < large.max_height_m &&
         fraction_under(small, rectangle_around(large.cells)) >= c.under_fraction;
}

// Whether a part of any shape stands under an object that would fall over without it, and goes on upwards
// where the object itself hides it: a foot under a round plate, the end of a bench.
// `behind_m` as above.
bool bears(const Fragment& part, const Fragment& object, double behind_m, const FragmentConfig& c) {
  const bool hangs = is_plate_in_the_air(object, c.min_hanging_height_m);
  if (part.contact.empty() || part.max_height_m >= object.max_height_m ||
      !(hangs || stands_beside_middle(object, kOneLeg * footprint_span(object))))
    return false;
  // the rim that hides it may be as far before it as the plate is wide
  const double hidden_m = hangs ? footprint_span(object) : c.hidden_gap_m;
  const double most = hangs ? kMaxFoot : c.max_small_fraction;
  return static_cast<double>(part.pixels) < most * static_cast<double>(object.pixels) &&
         behind_m <= hidden_m && fraction_under(part, rectangle_around(object.cells)) >= c.under_fraction;
}

// sums over the pixels of one region
struct Tally {
  std::size_t pixels = 0;
  double depth = 0.0, depth_squared = 0.0;
  float lowest = std::numeric_limits<float>::infinity(), highest = -std::numeric_limits<float>::infinity();
  Eigen::Array3f least = Eigen::Array3f::Constant(std::numeric_limits<float>::infinity());
  Eigen::Array3f most = -least;

  // false if the cell was met lately; most are met many times, and sorting them all would cost more than the
  // rest
  bool is_new(std::int64_t cell) {
    const auto c = static_cast<std::uint64_t>(cell);
    std::int64_t& met = recent[((c >> 32) * 8 + (c & 7)) % recent.size()];
    if (met == cell) return false;
    met = cell;
    return true;
  }
  std::array<std::int64_t, 128> recent{};

  // `count` pixels from `first` on; `height` is room for as many numbers
  void add(const OrganisedCloud& cloud, std::size_t first, Eigen::Index count, const Eigen::Vector3f& up,
           float offset, Eigen::ArrayXf& height) {
    using Values = Eigen::Map<const Eigen::ArrayXf>;
    const Values d(cloud.depth_m.data() + first, count), x(cloud.x.data() + first, count),
        y(cloud.y.data() + first, count), z(cloud.z.data() + first, count);
    pixels += static_cast<std::size_t>(count);
    depth += static_cast<double>(d.sum());
    depth_squared += static_cast<double>(d.square().sum());
    auto h = height.head(count);
    h = up.x() * x + up.y() * y + up.z() * z + offset;
    lowest = std::min(lowest, h.minCoeff());
    highest = std::max(highest, h.maxCoeff());
    least = least.min(Eigen::Array3f(x.minCoeff(), y.minCoeff(), z.minCoeff()));
    most = most.max(Eigen::Array3f(x.maxCoeff(), y.maxCoeff(), z.maxCoeff()));
  }
};

// how many of first..last are at most, at least
int up_to(int first, int last, int limit) {
  return std::max(0, std::min(last, limit) - first + 1);
}
int from_on(int first, int last, int limit) {
  return std::max(0, last - std::max(first, limit) + 1);
}

// where each region of the image stands among the fragments; -1 for speckle
std::vector<std::int32_t> slots_of(const std::vector<Fragment>& fragments, std::size_t regions) {
  std::vector<std::int32_t> slot(regions, -1);
  for (std::size_t f = 0; f < fragments.size(); ++f)
    for (const std::int32_t l : fragments[f].labels)
      slot[static_cast<std::size_t>(l)] = static_cast<std::int32_t>(f);
  return slot;
}

}  // namespace

FlatRectangle footprint_rectangle(const Fragment& f) {
  FlatRectangle r = rectangle_around(f.cells);
  r.size.array() += kCell_m;
  return r;
}

double footprint_span(const Fragment& f) {
  if (f.cells.empty()) return 0.0;
  Eigen::AlignedBox2d box;
  for (const std::int64_t c : f.cells) box.extend(GroundAxes::center(c));
  return box.diagonal().norm() + kCell_m;
}

double footprint_gap(const Fragment& a, const Fragment& b) {
  double best = std::numeric_limits<double>::infinity();
  for (const std::int64_t i : a.cells)
    for (const std::int64_t k : b.cells)
      best = std::min(best, (GroundAxes::center(i) - GroundAxes::center(k)).squaredNorm());
  return std::sqrt(best);
}

std::vector<Fragment> describe_fragments(const OrganisedCloud& cloud, const Components& components,
                                         const Ground& ground, const ImageBorder& border,
                                         const FragmentConfig& config) {
  std::vector<Fragment> fragments;
  for (std::size_t l = 0; l < components.pixels.size(); ++l) {
    if (components.pixels[l] < static_cast<std::uint32_t>(config.min_pixels)) continue;
    fragments.emplace_back();
    fragments.back().labels = {static_cast<std::int32_t>(l)};
  }
  if (fragments.empty()) return fragments;
  const std::vector<std::int32_t> slot = slots_of(fragments, components.pixels.size());

  const GroundAxes axes(ground);
  const double pixel_area = 1.0 / (cloud.intrinsics.fx * cloud.intrinsics.fy);
  const Eigen::Vector3f up = ground.plane.normal.cast<float>();
  const float offset = static_cast<float>(ground.plane.offset);
  std::vector<Tally> tallies(fragments.size());
  const int lowest_top = *std::max_element(border.top.begin(), border.top.end());
  const int highest_bottom = *std::min_element(border.bottom.begin(), border.bottom.end());
  Eigen::ArrayXf heights(cloud.width());
  for (const Components::Run& run : components.runs) {
    const std::int32_t k = slot[static_cast<std::size_t>(run.label)];
    if (k < 0) continue;
    Fragment& f = fragments[static_cast<std::size_t>(k)];
    Tally& t = tallies[static_cast<std::size_t>(k)];
    const int v = run.row;
    const std::size_t row = static_cast<std::size_t>(v) * static_cast<std::size_t>(cloud.width());
    const std::size_t before = t.pixels;
    t.add(cloud, row + static_cast<std::size_t>(run.first), run.last - run.first + 1, up, offset, heights);
    f.u_min = std::min(f.u_min, run.first);
    f.u_max = std::max(f.u_max, run.last);
    f.v_min = std::min(f.v_min, v);
    f.v_max = v;
    f.cut_left += up_to(run.first, run.last, border.left[static_cast<std::size_t>(v)] + 1);
    f.cut_right += from_on(run.first, run.last, border.right[static_cast<std::size_t>(v)] - 1);
    for (int u = run.first; u <= run.last && v <= lowest_top + 1; ++u)
      f.cut_top += v <= border.top[static_cast<std::size_t>(u)] + 1;
    for (int u = run.first; u <= run.last && v >= highest_bottom - 1; ++u)
      f.cut_bottom += v >= border.bottom[static_cast<std::size_t>(u)] - 1;
    const std::size_t skip = (kFootprintStride - before % kFootprintStride) % kFootprintStride;
    for (std::size_t u = static_cast<std::size_t>(run.first) + skip; u <= static_cast<std::size_t>(run.last);
         u += kFootprintStride) {
      const std::int64_t cell = axes.cell(cloud.point(row + u));
      const bool low = heights[static_cast<Eigen::Index>(u) - run.first] < static_cast<float>(kContact_m);
      if (low && (f.contact.empty() || f.contact.back() != cell)) f.contact.push_back(cell);
      if (t.is_new(cell)) f.cells.push_back(cell);
    }
  }
  for (std::size_t k = 0; k < fragments.size(); ++k) {
    Fragment& f = fragments[k];
    const Tally& t = tallies[k];
    f.pixels = t.pixels;
    f.mean_depth_m = t.depth / static_cast<double>(t.pixels);
    f.area_m2 = t.depth_squared * pixel_area;
    f.min_height_m = t.lowest;
    f.max_height_m = t.highest;
    f.box = Aabb(t.least.cast<double>(), t.most.cast<double>());
    for (std::vector<std::int64_t>* cells : {&f.cells, &f.contact}) {
      std::sort(cells->begin(), cells->end());
      cells->erase(std::unique(cells->begin(), cells->end()), cells->end());
    }
  }
  return fragments;
}

std::vector<std::uint8_t> own_regions(const Fragment& object, const Components& components) {
  std::vector<std::uint8_t> own(components.pixels.size(), 0);
  for (const std::int32_t region : object.labels) own[static_cast<std::size_t>(region)] = 1;
  return own;
}

std::vector<std::uint8_t> own_pixels(const OrganisedCloud& cloud, const Components& components,
                                     const Fragment& object) {
  const std::vector<std::uint8_t> region = own_regions(object, components);
  std::vector<std::uint8_t> own(cloud.size(), 0);
  for (const Components::Run& run : components.runs) {
    if (!region[static_cast<std::size_t>(run.label)]) continue;
    const auto row = own.begin() + static_cast<std::ptrdiff_t>(run.row) * cloud.width();
    std::fill(row + run.first, row + run.last + 1, std::uint8_t{1});
  }
  return own;
}

std::vector<Fragment> join_fragments(std::vector<Fragment> fragments, const OrganisedCloud& cloud,
                                     const Components& components, const Ground& ground,
                                     const NoiseModel& noise, const FragmentConfig& config) {
  const Eigen::Vector2d eye = GroundAxes(ground).on_ground(cloud.X_WC.translation());
  // large ones first: parts join the object that they belong to, and an object only grows
  const auto larger = [](const Fragment& a, const Fragment& b) { return a.pixels > b.pixels; };
  std::stable_sort(fragments.begin(), fragments.end(), larger);
  const std::size_t n = fragments.size();
  FragmentGaps gaps(cloud, components, slots_of(fragments, components.pixels.size()), n);
  std::vector<bool> gone(n, false);
  // joins each pair for which belong(larger, smaller, gap, how far the smaller one is behind the larger one)
  const auto join_where = [&](const auto& belong) {
    bool changed = false;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = i + 1; k < n; ++k) {
        if (gone[i] || gone[k]) continue;
        const auto [l, s] = fragments[i].pixels >= fragments[k].pixels ? std::pair(i, k) : std::pair(k, i);
        if (!belong(fragments[l], fragments[s], gaps.between(i, k), gaps.behind(s, l))) continue;
        fragments[i] = joined(fragments[i], fragments[k]);
        gaps.join(i, k);
        gone[k] = changed = true;
      }
    }
    return changed;
  };
  const auto together = [&](const Fragment& large, const Fragment& small, double gap_m, double behind_m) {
    return belong_together(large, small, gap_m, behind_m, eye, noise, config);
  };
  // once its legs are known: what stands under an object that has them is a thing of its own
  const auto under = [&](const Fragment& large, const Fragment& small, double, double behind_m) {
    return bears(small, large, behind_m, config);
  };
  do {
    while (join_where(together)) {
    }
  } while (join_where(under));
  std::vector<Fragment> objects;
  for (std::size_t i = 0; i < n; ++i)
    if (!gone[i]) objects.push_back(std::move(fragments[i]));
  std::stable_sort(objects.begin(), objects.end(), larger);
  return objects;
}

}  // namespace colift::perception
