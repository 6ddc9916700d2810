#include "perception/bodies/body_tracker.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace colift::perception {
namespace {

constexpr double kMoves = 3.0;  // of the speed below which a body is at rest

}  // namespace

BodyTracker::BodyTracker(const BodyTrackConfig& config) : config_(config) {
  const auto most = static_cast<std::size_t>(config.max_tracks);
  tracks_.reserve(2 * most);
  now_.reserve(most);
  taken_.reserve(2 * most);
}

std::span<const BodyTrack> BodyTracker::update(hal::Timestamp exposed_at, std::span<const Body> bodies) {
  now_.clear();
  std::erase_if(tracks_, [&](const BodyTrack& t) {
    return hal::seconds(exposed_at - t.seen_at) > config_.max_gap_s || exposed_at < t.seen_at;
  });
  taken_.assign(tracks_.size(), 0);
  const std::size_t known = tracks_.size(), most = static_cast<std::size_t>(config_.max_tracks);
  for (const Body& body : bodies) {
    if (now_.size() >= most) break;
    std::size_t best = known;
    double nearest = config_.max_step_m;
    for (std::size_t i = 0; i < known; ++i) {
      if (taken_[i] != 0) continue;
      const double passed_s = hal::seconds(exposed_at - tracks_[i].seen_at);
      const double off = (body.center - tracks_[i].center - passed_s * tracks_[i].velocity_m_s).norm();
      if (off >= nearest) continue;
      nearest = off;
      best = i;
    }
    if (best < known) {
      taken_[best] = 1;
      follow(tracks_[best], exposed_at, body);
      now_.push_back(tracks_[best]);
      continue;
    }
    BodyTrack track;
    track.id = next_id_++;
    track.center = body.center;
    track.frames = 1;
    track.seen_at = exposed_at;
    track.area_m2 = body.area_m2;
    see_top(track, body);
    now_.push_back(track);
    if (tracks_.size() < 2 * most) tracks_.push_back(track);
  }
  return now_;
}

void BodyTracker::see_top(BodyTrack& track, const Body& body) {
  track.top_m =
      body.top_seen ? std::max(track.top_m, body.box.max().z()) : std::numeric_limits<double>::infinity();
}

void BodyTracker::follow(BodyTrack& track, hal::Timestamp at, const Body& body) const {
  const double dt_s = hal::seconds(at - track.seen_at);
  track.seen_at = at;
  track.area_m2 = body.area_m2;
  see_top(track, body);
  ++track.frames;
  if (dt_s <= 0.0) return;
  const hal::Vec3 measured = (body.center - track.center) / dt_s;
  track.center = body.center;
  // the mean of the first frames, then a low-pass
  const double part = std::max(dt_s / (config_.velocity_filter_s + dt_s), 1.0 / (track.frames - 1));
  const double residual = (measured - track.velocity_m_s).norm();
  track.velocity_m_s += part * (measured - track.velocity_m_s);
  // of the filtered value: the residual's, reduced as the filter reduces noise
  const double seen = residual * std::sqrt(part / (2.0 - std::min(part, 1.0)));
  track.sigma_m_s += part * (seen - track.sigma_m_s);
  // what passes before it shifts the centre of what is seen: that is no motion, unless it is fast
  const double speed = track.velocity_m_s.norm();
  if (speed < config_.still_m_s)
    track.still_s += dt_s;
  else if (speed > kMoves * config_.still_m_s)
    track.still_s = 0.0;
}

}  // namespace colift::perception
