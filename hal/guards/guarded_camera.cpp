#include "hal/guards/guarded_camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "hal/types/units.hpp"

namespace colift::hal {

namespace {

using std::chrono::milliseconds;

constexpr float kNearest_m = 0.05f, kFarthest_m = 30.0f;  // of any depth camera; beyond it a unit is wrong
constexpr double kWrongDepths = 0.001;                    // part of the pixels
constexpr double kAgeShare = 0.1;                         // of a new age in the mean

double angle_deg(const Vec3& a, const Vec3& b) {
  return rad_to_deg(std::atan2(a.cross(b).norm(), a.dot(b)));
}

// bit by bit: pixels that see nothing are NaN
bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return !a.empty() && a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

}  // namespace

struct GuardedCamera::Impl {
  std::unique_ptr<DepthCamera> inner;
  CameraGuardConfig config;
  const Clock* clock = nullptr;
  std::optional<Vec3> calibrated_up_C, first_up_C;

  bool active = false, lost = false;
  std::string reason, last_error;  // of the loss; of the last frame that was dropped
  Timestamp newest{Timestamp::min()}, good_at{0}, changed_at{0};
  std::vector<float> picture;
  int bad = 0, good = 0;
  double age_s = 0.0;
  std::uint64_t rejected = 0, accepted = 0;
  std::optional<std::string> moved;

  void forget() {
    newest = Timestamp::min();
    good_at = changed_at = clock->now();
    picture.clear();
    bad = good = 0;
    age_s = 0.0;
    first_up_C.reset();
    moved.reset();
  }

  void note_device(std::string why) {
    good = 0;
    if (lost) return;
    lost = true;
    reason = std::move(why);
  }

  /// Why a frame cannot be used; nothing when it can.
  std::optional<std::string> wrong_with(const DepthFrame& f) {
    const auto& k = f.intrinsics;
    const auto pixels =
        static_cast<std::size_t>(std::max(k.width, 0)) * static_cast<std::size_t>(std::max(k.height, 0));
    if (pixels == 0 || f.depth_m.size() != pixels)
      return fmt::format("a frame of {} pixels, expected {} x {}", f.depth_m.size(), k.width, k.height);
    if (!(k.fx > 0.0 && k.fy > 0.0 && std::isfinite(k.fx) && std::isfinite(k.fy)))
      return fmt::format("a frame with focal lengths {} and {}", k.fx, k.fy);
    if (!f.rgb.empty() && f.rgb.size() != 3 * pixels)
      return fmt::format("a frame with {} bytes of colour, expected {}", f.rgb.size(), 3 * pixels);
    if (f.exposed_at <= newest)
      return fmt::format("a frame {:.1f} ms older than the one before", 1e3 * seconds(newest - f.exposed_at));
    std::size_t seen = 0, wrong = 0;
    for (const float z : f.depth_m) {
      if (std::isnan(z)) continue;
      ++seen;
      wrong += !(z > kNearest_m && z < kFarthest_m);
    }
    const auto all = static_cast<double>(pixels);
    if (static_cast<double>(wrong) > kWrongDepths * all)
      return fmt::format("{} depths that no depth camera measures", wrong);
    if (static_cast<double>(seen - wrong) < config.min_valid_fraction * all)
      return fmt::format("a frame that shows nothing: {:.1f} % of its pixels have a depth",
                         1e2 * static_cast<double>(seen) / all);
    return std::nullopt;
  }

  std::optional<std::string> was_moved(const DepthFrame& f) {
    if (!f.up_C) return std::nullopt;
    if (!first_up_C) first_up_C = f.up_C;
    const double turned = angle_deg(*first_up_C, *f.up_C);
    if (turned > config.moved_deg)
      return fmt::format("the camera was moved: {:.1f} deg against gravity since the start; calibrate it",
                         turned);
    if (!calibrated_up_C) return std::nullopt;
    const double off = angle_deg(*calibrated_up_C, *f.up_C);
    if (off > config.mounted_deg)
      return fmt::format(
          "the camera was moved: {:.1f} deg against gravity since its calibration; calibrate it", off);
    return std::nullopt;
  }

  /// Looks at a frame that came. True when it may pass.
  bool judge(const DepthFrame& f) {
    const Timestamp now = clock->now();
    if (auto why = wrong_with(f)) {
      ++rejected;
      last_error = std::move(*why);
      good = 0;
      if (++bad >= config.bad_in_a_row)
        note_device(fmt::format("{} bad frames in a row: {}", bad, last_error));
      return false;
    }
    bad = 0;
    newest = f.exposed_at;
    if (auto why = was_moved(f)) {
      ++rejected;
      moved = last_error = std::move(*why);
      note_device(*moved);
      return false;
    }
    moved.reset();
    if (!same_bits(f.depth_m, picture)) {
      changed_at = now;
      if (config.frozen_s > 0.0) picture = f.depth_m;
    } else if (seconds(now - changed_at) > config.frozen_s) {
      ++rejected;
      last_error = fmt::format("the same picture for {:.1f} s", seconds(now - changed_at));
      note_device(last_error);
      return false;
    }
    const double age = seconds(now - f.exposed_at);
    age_s = age_s == 0.0 ? age : (1.0 - kAgeShare) * age_s + kAgeShare * age;
    if (age_s > config.max_age_s) {
      ++rejected;
      last_error = fmt::format("frames are {:.0f} ms old when they come", 1e3 * age_s);
      note_device(last_error);
      return false;
    }
    good_at = now;  // also while it is still counted: it is silent no more
    if (lost && ++good < config.good_to_return) return false;
    lost = false;
    good = 0;
    return true;
  }
};

GuardedCamera::GuardedCamera(std::unique_ptr<DepthCamera> inner, const CameraGuardConfig& config,
                             const Clock& clock, std::optional<Vec3> up_C)
    : impl_(std::make_unique<Impl>()) {
  impl_->inner = std::move(inner);
  impl_->config = config;
  impl_->clock = &clock;
  impl_->calibrated_up_C = up_C;
}

GuardedCamera::~GuardedCamera() = default;

Result<> GuardedCamera::configure() {
  return impl_->inner->configure();
}

Result<> GuardedCamera::activate() {
  Impl& g = *impl_;
  if (auto done = g.inner->activate(); !done) return done;
  // a camera that comes back in the middle of a job has hung where it hung before
  if (!g.active && !g.lost) g.forget();
  g.active = true;
  return {};
}

void GuardedCamera::deactivate() noexcept {
  impl_->inner->deactivate();
  impl_->active = impl_->lost = false;
}

DeviceHealth GuardedCamera::health() const {
  const Impl& g = *impl_;
  DeviceHealth h = g.inner->health();
  h.accepted = g.accepted;
  h.rejected += g.rejected;
  if (!g.last_error.empty() && h.last_error.empty()) h.last_error = g.last_error;
  if (g.active && g.lost) {
    h.state = DeviceHealth::State::Lost;
    h.last_error = g.reason;
  }
  return h;
}

Result<DepthFrame> GuardedCamera::next_frame(milliseconds timeout) {
  constexpr auto kWhere = "camera.next_frame";
  Impl& g = *impl_;
  const Timestamp deadline = g.clock->now() + std::max(timeout, milliseconds(0));
  for (;;) {
    const auto left = std::chrono::duration_cast<milliseconds>(deadline - g.clock->now());
    auto frame = g.inner->next_frame(std::max(left, milliseconds(0)));
    if (!frame) {
      const bool silent = seconds(g.clock->now() - g.good_at) > g.config.silent_s;
      if (frame.error().code == ErrorCode::LinkLost)
        g.note_device(frame.error().detail);
      else if (frame.error().code == ErrorCode::Timeout && silent && g.active)
        g.note_device(fmt::format("no good frame for {:.1f} s", seconds(g.clock->now() - g.good_at)));
      if (g.moved && frame.error().code == ErrorCode::Timeout)
        return failure(ErrorCode::DeviceFault, kWhere, *g.moved);
      if (frame.error().code == ErrorCode::Timeout && g.lost)
        return failure(ErrorCode::LinkLost, kWhere, g.reason);
      return frame;
    }
    if (g.judge(*frame)) {
      ++g.accepted;
      return frame;
    }
    if (g.moved) return failure(ErrorCode::DeviceFault, kWhere, *g.moved);
    if (g.clock->now() < deadline) continue;
    if (g.lost) return failure(ErrorCode::LinkLost, kWhere, g.reason);
    return failure(ErrorCode::Timeout, kWhere,
                   fmt::format("no good frame within {} ms: {}", timeout.count(), g.last_error));
  }
}

}  // namespace colift::hal
