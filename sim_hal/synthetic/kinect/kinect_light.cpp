#include "sim_hal/synthetic/kinect/kinect_light.hpp"

#include <algorithm>
#include <limits>

#include "sim_hal/synthetic/float4.hpp"
#include "sim_hal/synthetic/hash_random.hpp"
#include "sim_hal/synthetic/kinect/kinect_rows.hpp"

namespace colift::sim_hal {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kNearest_m = 0.5f, kFarthest_m = 9.0f;
constexpr int kPatch_px = 6;           // size of the patches that are a little better or worse seen
constexpr double kSpeckPart = 0.0015;  // of all pixels
constexpr std::size_t kBlock = 32;     // pixels of a row that are judged at once
constexpr int kSpeckBlock = 64;        // pixels of a row among which there is one speck at most

// Light that comes back falls with the square of the distance and with the angle. The limits are chosen so
// that grey floors are seen to about 4 m at 25 degrees and black plastics only when they face the camera,
// as in recordings. Between the two of each lie the limits of better and worse patches.
constexpr float kDark = 0.006f, kBright = 0.016f;
constexpr float kGrazing = 0.08f, kFacing = 0.2f;  // cosine of incidence

enum Stream : std::uint64_t { kKnot = 32, kSpeck };

std::uint64_t place(int row, int column) {
  return static_cast<std::uint64_t>(row) * 65536 + static_cast<std::uint64_t>(column);
}

}  // namespace

KinectLight::KinectLight(const std::vector<float>& reflectivity, int width, std::uint64_t seed)
    : reflectivity_{std::numeric_limits<float>::infinity()},
      width_(width),
      // the last 8 of 640 columns: the correlation window does not fit there
      seen_columns_(static_cast<std::size_t>(width - width / 80)),
      whole_(static_cast<std::size_t>(width + 3) / 4 * 4),
      seed_(seed) {
  reflectivity_.insert(reflectivity_.end(), reflectivity.begin(), reflectivity.end());
  for (int u = 0; u < width + 3; ++u) {
    knot_.push_back(static_cast<std::uint16_t>(u / kPatch_px));
    part_.push_back(static_cast<float>(u % kPatch_px) / kPatch_px);
  }
  knots_.resize(knot_.back() + std::size_t{2});
}

void KinectLight::punch_holes(int v, const std::int16_t* shape, const float* cosine, float* inverse_depth) {
  kinect_rows::Light light{1.0f / kNearest_m, 1.0f / kFarthest_m, 0.0f, kBright, kFacing};
  for (std::size_t begin = 0; begin < whole_; begin += kBlock) {
    const std::size_t size = std::min(kBlock, whole_ - begin);
    // nearly all of a picture is one surface that is seen well
    const bool one_surface = std::equal(shape + begin + 1, shape + begin + size, shape + begin);
    light.reflectivity = reflectivity_[static_cast<std::size_t>(shape[begin] + 1)];
    if (one_surface && kinect_rows::all_seen(light, inverse_depth + begin, cosine + begin, size)) continue;
    for (std::size_t u = begin; u < begin + size; u += 4)
      judge_four(v, shape + u, cosine + u, u, inverse_depth + u);
  }
  add_specks(v, inverse_depth);
  std::fill(inverse_depth + seen_columns_, inverse_depth + whole_, kNan);
}

void KinectLight::judge_four(int v, const std::int16_t* shape, const float* cosine, std::size_t u,
                             float* inverse_depth) {
  const Float4 nearest(1.0f / kNearest_m), farthest(1.0f / kFarthest_m), nothing(kNan), one(1.0f);
  const Float4 w = Float4::load(inverse_depth), w1 = min(w, one);
  const Float4 in_range = both(greater(nearest, w), greater(w, farthest));
  if (!any(in_range)) {
    nothing.store(inverse_depth);
    return;
  }
  const Float4 reflected = gather(&reflectivity_[1], shape);
  Float4 cos = Float4::load(cosine), light = reflected * cos * w1 * w1;
  if (all(both(in_range, both(greater(light, Float4(kBright)), greater(cos, Float4(kFacing)))))) return;
  // what flies before nothing at all turns no side to the camera
  cos = select(greater(Float4(-0.5f), Float4::load(shape)), one, cos);
  light = reflected * cos * w1 * w1;
  lay_patches(v);
  const Float4 left = gather(knots_.data(), &knot_[u]), right = gather(knots_.data() + 1, &knot_[u]);
  const Float4 patch = left + (right - left) * Float4::load(&part_[u]), patch2 = patch * patch;
  const Float4 seen = both(greater(light, Float4(kDark) + Float4(kBright - kDark) * patch2),
                           greater(cos, Float4(kGrazing) + Float4(kFacing - kGrazing) * patch2));
  select(both(in_range, seen), w, nothing).store(inverse_depth);
}

void KinectLight::lay_patches(int v) {
  if (v == patch_row_) return;
  patch_row_ = v;
  const auto fill = [&](std::vector<float>& knots, int row) {
    knots.resize(knots_.size());
    for (std::size_t k = 0; k < knots.size(); ++k)
      knots[k] = static_cast<float>(unit(hash(seed_, kKnot, place(row, static_cast<int>(k)))));
  };
  const int row = v / kPatch_px;
  if (row != knot_row_) {
    if (row == knot_row_ + 1) {
      above_.swap(below_);
    } else {
      fill(above_, row);
    }
    fill(below_, row + 1);
    knot_row_ = row;
  }
  const float part = static_cast<float>(v % kPatch_px) / kPatch_px;
  for (std::size_t k = 0; k < knots_.size(); ++k) knots_[k] = above_[k] + (below_[k] - above_[k]) * part;
}

// One or two pixels, as often.
void KinectLight::add_specks(int v, float* inverse_depth) const {
  constexpr auto kPart = static_cast<std::uint64_t>(kSpeckPart / 1.5 * kSpeckBlock * 0x1p32);
  for (int begin = 0; begin < width_; begin += kSpeckBlock) {
    const std::uint64_t bits = hash(seed_, kSpeck, place(v, begin));
    if (bits >> 32 >= kPart) continue;
    const auto u = static_cast<std::size_t>(begin) + bits % kSpeckBlock;
    if (u >= seen_columns_) continue;
    inverse_depth[u] = kNan;
    if ((bits & kSpeckBlock) != 0 && u > 0) inverse_depth[u - 1] = kNan;
  }
}

}  // namespace colift::sim_hal
