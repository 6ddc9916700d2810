#include "tools/scenes/scene_truth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <unordered_set>

namespace colift::tools {
namespace {

using hal::DepthFrame;
using hal::Vec3;

constexpr double kStep_m = 0.015, kSigmas = 5.0;  // a change is more than both
constexpr int kJoin_px = 4;                       // holes that separate nothing: the shadow of the emitter
constexpr std::size_t kMinObject_px = 400, kMinPerson_px = 300;
constexpr double kSecond = 0.3;         // a second thing of this part of the first: which one is meant?
constexpr double kMaxElsewhere = 0.03;  // of the pixels that should have stayed as they were
constexpr double kMaxGap_m = 0.08, kHand_m = 0.04;
constexpr double kMinMoved = 0.3;
constexpr double kVoxel_m = 0.02;

auto again(SceneStep step, std::string why) {
  return hal::failure(hal::ErrorCode::NotFound, fmt::format("step {}", to_string(step)), std::move(why));
}

DepthFrame median_of(const std::vector<DepthFrame>& frames) {
  DepthFrame m = frames.front();
  std::vector<float> seen;
  for (std::size_t i = 0; i < m.depth_m.size(); ++i) {
    seen.clear();
    for (const DepthFrame& f : frames)
      if (f.depth_m[i] > 0.0f) seen.push_back(f.depth_m[i]);
    if (2 * seen.size() < frames.size() || seen.empty()) {
      m.depth_m[i] = std::numeric_limits<float>::quiet_NaN();
      continue;
    }
    const auto middle = seen.begin() + static_cast<std::ptrdiff_t>(seen.size() / 2);
    std::nth_element(seen.begin(), middle, seen.end());
    m.depth_m[i] = *middle;
  }
  return m;
}

double threshold(double z, const perception::NoiseModel& noise) {
  return std::max(kStep_m, kSigmas * noise.sigma(z) + 2.0 * noise.step(z));
}

std::vector<bool> nearer(const DepthFrame& before, const DepthFrame& after,
                         const perception::NoiseModel& noise) {
  std::vector<bool> changed(before.depth_m.size(), false);
  for (std::size_t i = 0; i < changed.size(); ++i) {
    const double a = static_cast<double>(before.depth_m[i]), b = static_cast<double>(after.depth_m[i]);
    changed[i] = a - b > threshold(a, noise);
  }
  return changed;
}

std::vector<bool> grown(const std::vector<bool>& pixels, int width, int by) {
  const int height = static_cast<int>(pixels.size()) / width;
  std::vector<bool> rows = pixels, out(pixels.size(), false);
  const auto spread = [&](const std::vector<bool>& from, std::vector<bool>& to, bool along) {
    for (int v = 0; v < height; ++v)
      for (int u = 0; u < width; ++u) {
        if (!from[static_cast<std::size_t>(v * width + u)]) continue;
        for (int d = -by; d <= by; ++d) {
          const int x = along ? u + d : u, y = along ? v : v + d;
          if (x >= 0 && x < width && y >= 0 && y < height) to[static_cast<std::size_t>(y * width + x)] = true;
        }
      }
  };
  spread(pixels, rows, true);
  spread(rows, out, false);
  return out;
}

/// Connected parts of `pixels`, over gaps of kJoin_px, each as its indices; the largest first.
std::vector<std::vector<std::size_t>> parts(const std::vector<bool>& pixels, int width) {
  std::vector<bool> left = grown(pixels, width, kJoin_px / 2);
  const std::size_t w = static_cast<std::size_t>(width);
  std::vector<std::vector<std::size_t>> all;
  std::vector<std::size_t> open;
  for (std::size_t first = 0; first < left.size(); ++first) {
    if (!left[first]) continue;
    std::vector<std::size_t> part;
    left[first] = false;
    open = {first};
    while (!open.empty()) {
      const std::size_t i = open.back();
      open.pop_back();
      if (pixels[i]) part.push_back(i);
      const std::size_t u = i % w;
      const std::array<std::size_t, 4> around{u > 0 ? i - 1 : i, u + 1 < w ? i + 1 : i, i >= w ? i - w : i,
                                              i + w < left.size() ? i + w : i};
      for (const std::size_t n : around)
        if (left[n]) {
          left[n] = false;
          open.push_back(n);
        }
    }
    if (!part.empty()) all.push_back(std::move(part));
  }
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return all;
}

Vec3 point_of(const DepthFrame& f, std::size_t i) {
  const auto& k = f.intrinsics;
  const double z = static_cast<double>(f.depth_m[i]);
  const auto w = static_cast<std::size_t>(k.width);
  return {(static_cast<double>(i % w) - k.cx) * z / k.fx, (static_cast<double>(i / w) - k.cy) * z / k.fy, z};
}

/// One point of the object for each cell: enough to measure distances of centimetres.
std::vector<Vec3> thinned(const DepthFrame& f, const std::vector<bool>& pixels) {
  std::vector<Vec3> points;
  std::unordered_set<std::int64_t> taken;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (!pixels[i]) continue;
    const Vec3 p = point_of(f, i);
    std::int64_t key = 0;
    for (int k = 0; k < 3; ++k)
      key = key * 4096 + static_cast<std::int64_t>(std::floor(p[k] / kVoxel_m)) + 2048;
    if (taken.insert(key).second) points.push_back(p);
  }
  return points;
}

hal::Result<> find_object(SceneTruth& t, const perception::NoiseModel& noise) {
  const int width = t.empty.intrinsics.width;
  const auto found = parts(nearer(t.empty, t.object, noise), width);
  if (found.empty() || found.front().size() < kMinObject_px)
    return again(SceneStep::Object,
                 "nothing is there that was not there before: put the object down after the first step");
  if (found.size() > 1 &&
      static_cast<double>(found[1].size()) > kSecond * static_cast<double>(found[0].size()))
    return again(SceneStep::Object,
                 fmt::format("two things are there that were not there before ({} and {} pixels): "
                             "leave the view, and bring one object",
                             found[0].size(), found[1].size()));
  t.object_pixels.assign(t.empty.depth_m.size(), false);
  for (const std::size_t i : found.front()) t.object_pixels[i] = true;
  t.object_count = found.front().size();

  const std::vector<bool> near = grown(t.object_pixels, width, 2 * kJoin_px);
  std::size_t both = 0, changed = 0;
  for (std::size_t i = 0; i < near.size(); ++i) {
    const double a = static_cast<double>(t.empty.depth_m[i]), b = static_cast<double>(t.object.depth_m[i]);
    if (near[i] || !(a > 0.0) || !(b > 0.0)) continue;
    ++both;
    changed += std::abs(a - b) > 2.0 * threshold(a, noise) ? 1 : 0;
  }
  if (static_cast<double>(changed) > kMaxElsewhere * static_cast<double>(std::max<std::size_t>(both, 1)))
    return again(
        SceneStep::Object,
        fmt::format(
            "{:.0f} % of the view changed where the object is not: the camera or the room moved; record anew",
            1e2 * static_cast<double>(changed) / static_cast<double>(both)));
  return {};
}

hal::Result<> find_hand(SceneTruth& t, const DepthFrame& with_person, const perception::NoiseModel& noise) {
  const auto found = parts(nearer(t.object, with_person, noise), t.empty.intrinsics.width);
  t.person_pixels.assign(t.empty.depth_m.size(), false);
  for (const auto& part : found) {
    if (part.size() < kMinPerson_px) break;
    t.person_count += part.size();
    for (const std::size_t i : part) t.person_pixels[i] = true;
  }
  if (t.person_count == 0)
    return again(SceneStep::Hand, "nobody came into view: take hold of the object before this step");
  const std::vector<Vec3> object = thinned(t.object, t.object_pixels);
  std::vector<std::pair<double, Vec3>> skin;
  for (std::size_t i = 0; i < t.person_pixels.size(); ++i) {
    if (!t.person_pixels[i]) continue;
    const Vec3 p = point_of(with_person, i);
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vec3& q : object) nearest = std::min(nearest, (p - q).squaredNorm());
    if (nearest < (kMaxGap_m + kHand_m) * (kMaxGap_m + kHand_m)) skin.emplace_back(std::sqrt(nearest), p);
  }
  t.hand_gap_m = std::numeric_limits<double>::infinity();
  for (const auto& [distance, p] : skin) t.hand_gap_m = std::min(t.hand_gap_m, distance);
  if (!(t.hand_gap_m < kMaxGap_m))
    return again(SceneStep::Hand,
                 fmt::format("the person keeps more than {:.0f} cm from the object: take hold of it where "
                             "the camera sees the hand",
                             1e2 * kMaxGap_m));
  std::size_t count = 0;
  for (const auto& [distance, p] : skin) {
    if (distance > t.hand_gap_m + kHand_m) continue;
    t.hand += p;
    ++count;
  }
  t.hand /= static_cast<double>(count);
  return {};
}

}  // namespace

hal::Result<SceneTruth> scene_truth(const RecordedSteps& scene, const perception::NoiseModel& noise) {
  const auto& frames = scene.frames;
  SceneTruth t;
  t.empty = median_of(frames[0]);
  t.object = median_of(frames[1]);
  if (auto found = find_object(t, noise); !found) return tl::unexpected(found.error());
  if (auto found = find_hand(t, median_of(frames[2]), noise); !found) return tl::unexpected(found.error());
  const DepthFrame& last = frames[3].back();
  std::size_t changed = 0;
  for (std::size_t i = 0; i < t.object_pixels.size(); ++i) {
    if (!t.object_pixels[i]) continue;
    const double a = static_cast<double>(t.object.depth_m[i]), b = static_cast<double>(last.depth_m[i]);
    changed += !(std::abs(a - b) <= threshold(a, noise)) ? 1 : 0;
  }
  t.moved = static_cast<double>(changed) / static_cast<double>(t.object_count);
  if (t.moved < kMinMoved)
    return again(SceneStep::Lift,
                 fmt::format("only {:.0f} % of the object's pixels changed: lift it by some centimetres",
                             1e2 * t.moved));
  return t;
}

}  // namespace colift::tools
