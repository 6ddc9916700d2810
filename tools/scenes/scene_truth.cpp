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
constexpr int kJoin_px = 3;                       // holes that separate nothing
constexpr float kJump_m = 0.06F, kJumpPart = 0.03F;
constexpr std::size_t kMinObject_px = 400, kMinPerson_px = 300;
constexpr double kSecond = 0.15;  // a second thing of this part of the first: which one is meant?
constexpr double kBelongs_m = 0.3;
constexpr std::size_t kMinPart_px = 10;
constexpr int kBorder_px = 8;
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

/// Parts of `pixels` that hang together without a jump in depth, over gaps of kJoin_px, each as its indices;
/// the largest first.
std::vector<std::vector<std::size_t>> parts(const DepthFrame& frame, std::vector<bool> left) {
  const int width = frame.intrinsics.width, height = frame.intrinsics.height;
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
      part.push_back(i);
      const int u = static_cast<int>(i) % width, v = static_cast<int>(i) / width;
      const float z = frame.depth_m[i], jump = std::max(kJump_m, kJumpPart * z);
      for (int y = std::max(0, v - kJoin_px); y <= std::min(height - 1, v + kJoin_px); ++y)
        for (int x = std::max(0, u - kJoin_px); x <= std::min(width - 1, u + kJoin_px); ++x) {
          const auto n = static_cast<std::size_t>(y * width + x);
          if (!left[n] || std::abs(frame.depth_m[n] - z) > jump) continue;
          left[n] = false;
          open.push_back(n);
        }
    }
    all.push_back(std::move(part));
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

/// From a part to the nearest of the points.
double distance(const DepthFrame& f, const std::vector<std::size_t>& part, const std::vector<Vec3>& points) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < part.size(); k += 8) {
    const Vec3 p = point_of(f, part[k]);
    for (const Vec3& q : points) nearest = std::min(nearest, (p - q).squaredNorm());
  }
  return std::sqrt(nearest);
}

hal::Result<> find_object(SceneTruth& t, const perception::NoiseModel& noise) {
  const auto found = parts(t.object, nearer(t.empty, t.object, noise));
  if (found.empty() || found.front().size() < kMinObject_px)
    return again(SceneStep::Object,
                 "nothing is there that was not there before: put the object down after the first step");
  t.object_pixels.assign(t.empty.depth_m.size(), false);
  for (const std::size_t i : found.front()) t.object_pixels[i] = true;
  const std::vector<Vec3> main = thinned(t.object, t.object_pixels);
  t.object_count = found.front().size();
  // legs and whatever else the object hides from itself belong to it
  for (std::size_t k = 1; k < found.size(); ++k) {
    const bool large = static_cast<double>(found[k].size()) > kSecond * static_cast<double>(found[0].size());
    const bool near = distance(t.object, found[k], main) < kBelongs_m;
    if (large || (!near && found[k].size() >= kMinPerson_px))
      return again(SceneStep::Object,
                   fmt::format("two things are there that were not there before ({} and {} pixels): leave "
                               "the view, and bring one object",
                               found[0].size(), found[k].size()));
    if (!near || found[k].size() < kMinPart_px) continue;
    for (const std::size_t i : found[k]) t.object_pixels[i] = true;
    t.object_count += found[k].size();
  }

  const std::vector<bool> near = grown(t.object_pixels, t.empty.intrinsics.width, kBorder_px);
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
  const auto found = parts(with_person, nearer(t.object, with_person, noise));
  t.person_pixels.assign(t.empty.depth_m.size(), false);
  for (const auto& part : found) {
    if (part.size() < kMinPerson_px) break;
    t.person_count += part.size();
    for (const std::size_t i : part) t.person_pixels[i] = true;
  }
  if (t.person_count == 0)
    return again(SceneStep::Hand, "nobody came into view: take hold of the object before this step");
  const std::vector<Vec3> object = thinned(t.object, t.object_pixels);
  std::vector<std::pair<double, std::size_t>> skin;  // distance from the object, pixel
  t.hand_gap_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < t.person_pixels.size(); ++i) {
    if (!t.person_pixels[i]) continue;
    const double gap = distance(with_person, {i}, object);
    if (gap < kMaxGap_m + kHand_m) skin.emplace_back(gap, i);
    t.hand_gap_m = std::min(t.hand_gap_m, gap);
  }
  if (!(t.hand_gap_m < kMaxGap_m))
    return again(SceneStep::Hand,
                 fmt::format("the person keeps more than {:.0f} cm from the object: take hold of it where "
                             "the camera sees the hand",
                             1e2 * kMaxGap_m));
  std::vector<bool> near(t.person_pixels.size(), false);
  for (const auto& [gap, i] : skin) near[i] = gap <= t.hand_gap_m + kHand_m;
  for (const auto& part : parts(with_person, near)) {
    if (part.size() < kMinPart_px && !t.hands.empty()) break;
    Vec3 middle = Vec3::Zero();
    for (const std::size_t i : part) middle += point_of(with_person, i);
    t.hands.push_back(middle / static_cast<double>(part.size()));
  }
  return {};
}

/// Of several places the one that somebody pointed at.
void keep_place(SceneTruth& t, const std::array<double, 2>& px) {
  const auto& k = t.object.intrinsics;
  const auto off = [&](const Vec3& p) {
    return std::hypot(k.fx * p.x() / p.z() + k.cx - px[0], k.fy * p.y() / p.z() + k.cy - px[1]);
  };
  t.hands = {*std::min_element(t.hands.begin(), t.hands.end(),
                               [&](const Vec3& a, const Vec3& b) { return off(a) < off(b); })};
}

}  // namespace

hal::Result<SceneTruth> scene_truth(const RecordedSteps& scene, const perception::NoiseModel& noise) {
  const auto& frames = scene.frames;
  SceneTruth t;
  t.empty = median_of(frames[0]);
  t.object = median_of(frames[1]);
  if (auto found = find_object(t, noise); !found) return tl::unexpected(found.error());
  if (auto found = find_hand(t, median_of(frames[2]), noise); !found) return tl::unexpected(found.error());
  if (scene.file.hand_px) keep_place(t, *scene.file.hand_px);
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
