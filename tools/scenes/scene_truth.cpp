#include "tools/scenes/scene_truth.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <unordered_set>

namespace colift::tools {
namespace {

using hal::DepthFrame;
using hal::Vec3;
using perception::OrganisedCloud;

constexpr double kStep_m = 0.015, kSigmas = 5.0;  // a change is more than both
constexpr int kJoin_px = 3;                       // holes that separate nothing
constexpr float kJump_m = 0.06F, kJumpPart = 0.03F;
constexpr std::size_t kMinObject_px = 400, kMinPerson_px = 300;
constexpr double kSecond = 0.15;  // a second thing of this part of the first: which one is meant?
constexpr double kBelongs_m = 0.3;
constexpr std::size_t kMinPart_px = 10, kMinSkin_px = 25;  // a hand may show alone
constexpr int kBorder_px = 8;
constexpr double kMaxElsewhere = 0.03;  // of the pixels that should have stayed as they were
constexpr double kMinElsewhere = 0.2;   // of the view: less cannot tell whether the camera moved
constexpr double kMaxMedian = 0.15;     // of their changes, against one that counts: noise has none
constexpr double kMaxGap_m = 0.08, kHand_m = 0.04;
constexpr double kMinMoved = 0.08, kMovedPart = 0.5;  // many pixels: each may change by less
constexpr double kVoxel_m = 0.02;

auto again(SceneStep step, std::string why) {
  return hal::failure(hal::ErrorCode::NotFound, fmt::format("step {}", to_string(step)), std::move(why));
}

/// Median depth of each pixel, in the camera's frame; NaN where most images saw nothing.
OrganisedCloud median_of(const std::vector<DepthFrame>& frames) {
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
  return perception::deproject(m, hal::Pose::Identity());
}

double threshold(double z, const perception::NoiseModel& noise) {
  return std::max(kStep_m, kSigmas * noise.sigma(z) + 2.0 * noise.step(z));
}

std::vector<bool> nearer(const OrganisedCloud& before, const OrganisedCloud& after,
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
std::vector<std::vector<std::size_t>> parts(const OrganisedCloud& cloud, std::vector<bool> left) {
  const int width = cloud.width(), height = cloud.height();
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
      const float z = cloud.depth_m[i], jump = std::max(kJump_m, kJumpPart * z);
      for (int y = std::max(0, v - kJoin_px); y <= std::min(height - 1, v + kJoin_px); ++y)
        for (int x = std::max(0, u - kJoin_px); x <= std::min(width - 1, u + kJoin_px); ++x) {
          const auto n = static_cast<std::size_t>(y * width + x);
          if (!left[n] || std::abs(cloud.depth_m[n] - z) > jump) continue;
          left[n] = false;
          open.push_back(n);
        }
    }
    all.push_back(std::move(part));
  }
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return all;
}

/// One point of the object for each cell: enough to measure distances of centimetres.
std::vector<Vec3> thinned(const OrganisedCloud& cloud, const std::vector<bool>& pixels) {
  std::vector<Vec3> points;
  std::unordered_set<std::int64_t> taken;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    if (!pixels[i]) continue;
    const Vec3 p = cloud.point(i);
    std::int64_t key = 0;
    for (int k = 0; k < 3; ++k)
      key = key * 4096 + static_cast<std::int64_t>(std::floor(p[k] / kVoxel_m)) + 2048;
    if (taken.insert(key).second) points.push_back(p);
  }
  return points;
}

double distance(const Vec3& p, const std::vector<Vec3>& points) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Vec3& q : points) nearest = std::min(nearest, (p - q).squaredNorm());
  return std::sqrt(nearest);
}

/// From a part, of which some pixels say enough, to the nearest of the points.
double distance(const OrganisedCloud& cloud, const std::vector<std::size_t>& part,
                const std::vector<Vec3>& points) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < part.size(); k += 8)
    nearest = std::min(nearest, distance(cloud.point(part[k]), points));
  return nearest;
}

hal::Result<> find_object(SceneTruth& t, const OrganisedCloud& empty, const perception::NoiseModel& noise) {
  const auto found = parts(t.object, nearer(empty, t.object, noise));
  if (found.empty() || found.front().size() < kMinObject_px)
    return again(SceneStep::Object,
                 "nothing is there that was not there before: put the object down after the first step");
  t.object_pixels.assign(t.object.size(), false);
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
                               "the view, bring one object, and leave the camera where it is",
                               found[0].size(), found[k].size()));
    if (!near || found[k].size() < kMinPart_px) continue;
    for (const std::size_t i : found[k]) t.object_pixels[i] = true;
    t.object_count += found[k].size();
  }
  return {};
}

/// Where the object is not, nothing may have changed. Errors: NotFound.
hal::Result<> check_elsewhere(const SceneTruth& t, const OrganisedCloud& empty,
                              const perception::NoiseModel& noise) {
  const std::vector<bool> near = grown(t.object_pixels, t.object.width(), kBorder_px);
  std::vector<double> changes;  // elsewhere, as parts of what counts as a change
  std::size_t large = 0, both = 0;
  for (std::size_t i = 0; i < near.size(); ++i) {
    const double a = static_cast<double>(empty.depth_m[i]), b = static_cast<double>(t.object.depth_m[i]);
    if (!(a > 0.0) || !(b > 0.0)) continue;
    ++both;
    if (near[i]) continue;
    changes.push_back((a - b) / threshold(a, noise));
    large += std::abs(changes.back()) > 2.0 ? 1 : 0;
  }
  if (static_cast<double>(changes.size()) <= kMinElsewhere * static_cast<double>(both))
    return again(SceneStep::Object,
                 "nearly all of the view is nearer than before: the camera moved, or the object fills the "
                 "view; record anew");
  const double part = static_cast<double>(large) / static_cast<double>(changes.size());
  const auto middle = changes.begin() + static_cast<std::ptrdiff_t>(changes.size() / 2);
  std::nth_element(changes.begin(), middle, changes.end());
  if (part > kMaxElsewhere || std::abs(*middle) > kMaxMedian)
    return again(SceneStep::Object,
                 fmt::format("{:.0f} % of the view changed where the object is not, its median by {:.2f} of "
                             "what counts as a change: the camera or the room moved; record anew",
                             1e2 * part, *middle));
  return {};
}

hal::Result<> find_hand(SceneTruth& t, const OrganisedCloud& with_person,
                        const perception::NoiseModel& noise) {
  const auto found = parts(with_person, nearer(t.object, with_person, noise));
  t.person_pixels.assign(t.object.size(), false);
  for (const auto& part : found) {
    if (part.size() < kMinSkin_px) break;
    for (const std::size_t i : part) t.person_pixels[i] = true;
  }
  if (found.empty() || found.front().size() < kMinPerson_px)
    return again(SceneStep::Hand, "nobody came into view: take hold of the object before this step");
  const std::vector<Vec3> object = thinned(t.object, t.object_pixels);
  std::vector<std::pair<double, std::size_t>> skin;  // distance from the object, pixel
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < t.person_pixels.size(); ++i) {
    if (!t.person_pixels[i]) continue;
    const double gap = distance(with_person.point(i), object);
    if (gap < kMaxGap_m + kHand_m) skin.emplace_back(gap, i);
    nearest = std::min(nearest, gap);
  }
  if (!(nearest < kMaxGap_m))
    return again(SceneStep::Hand,
                 fmt::format("the person keeps more than {:.0f} cm from the object: take hold of it where "
                             "the camera sees the hand",
                             1e2 * kMaxGap_m));
  std::vector<bool> near(t.person_pixels.size(), false);
  for (const auto& [gap, i] : skin) near[i] = gap <= nearest + kHand_m;
  for (const auto& part : parts(with_person, near)) {
    if (part.size() < kMinPart_px && !t.hands.empty()) break;
    Vec3 middle = Vec3::Zero();
    for (const std::size_t i : part) middle += with_person.point(i);
    t.hands.push_back(middle / static_cast<double>(part.size()));
  }
  return {};
}

/// Of several places the one that somebody pointed at.
void keep_place(SceneTruth& t, const std::array<double, 2>& px) {
  const auto off = [&](const Vec3& p) {
    const auto at = t.object.project(p);
    return std::hypot(at.u - px[0], at.v - px[1]);
  };
  t.hands = {*std::min_element(t.hands.begin(), t.hands.end(),
                               [&](const Vec3& a, const Vec3& b) { return off(a) < off(b); })};
}

}  // namespace

hal::Result<SceneTruth> scene_truth(const RecordedSteps& scene, const perception::NoiseModel& noise) {
  const auto& frames = scene.frames;
  SceneTruth t;
  t.object = median_of(frames[1]);
  const OrganisedCloud empty = median_of(frames[0]);
  if (auto found = find_object(t, empty, noise); !found) return tl::unexpected(found.error());
  if (auto same = check_elsewhere(t, empty, noise); !same) return tl::unexpected(same.error());
  const OrganisedCloud held = median_of(frames[2]);
  if (auto found = find_hand(t, held, noise); !found) return tl::unexpected(found.error());
  if (scene.file.hand_px) keep_place(t, *scene.file.hand_px);
  // what hides behind the person says nothing; what is upright slides in its own plane
  const DepthFrame& last = frames[3].back();
  std::size_t changed = 0, open = 0;
  for (std::size_t i = 0; i < t.object_pixels.size(); ++i) {
    const double a = static_cast<double>(held.depth_m[i]), b = static_cast<double>(last.depth_m[i]);
    if (!t.object_pixels[i] || t.person_pixels[i] || !(a > 0.0) || !(b > 0.0)) continue;
    ++open;
    changed += std::abs(a - b) > kMovedPart * threshold(a, noise) ? 1 : 0;
  }
  t.moved = static_cast<double>(changed) / static_cast<double>(std::max<std::size_t>(open, 1));
  if (t.moved < kMinMoved)
    return again(SceneStep::Lift,
                 fmt::format("only {:.0f} % of the object's pixels changed: lift it by some centimetres",
                             1e2 * t.moved));
  return t;
}

}  // namespace colift::tools
