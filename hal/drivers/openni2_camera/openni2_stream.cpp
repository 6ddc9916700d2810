#include "hal/drivers/openni2_camera/openni2_stream.hpp"

#include <utility>

#include "hal/drivers/openni2_camera/depth_image.hpp"

namespace colift::hal::openni2 {

using capture::Stream;

Openni2Stream::Openni2Stream(Openni2CameraConfig config, std::optional<PinholeModel> model,
                             const Clock& clock)
    : CaptureSupervisor("openni2", config, {1, kMaxPixels}, clock),
      config_(std::move(config)),
      model_(model) {}

Result<> Openni2Stream::find() {
  if (source_) return {};
  auto found = find_source(config_);
  if (!found) return tl::unexpected(found.error());
  source_ = std::move(*found);
  call_ = source_->call;
  if (!record_to.empty()) call_.arguments.insert(call_.arguments.end(), {"--record", record_to});
  return {};
}

void Openni2Stream::started() {
  gate_.forget();
  number_ = 0;
  view_.reset();
}

void Openni2Stream::heard() {
  if (view_ || news().constants.size() != 2) return;
  const FieldOfView said{news().constants[0], news().constants[1]};
  if (plausible(said)) view_ = said;
}

std::optional<DepthFrame> Openni2Stream::take() {
  if (!model_ && !view_) listen();
  if (!read(Stream::Depth, raw_)) return std::nullopt;
  if (!model_ && !view_) {
    reject("the device does not report its field of view; expected openni2.intrinsics, its camera.json");
    return std::nullopt;
  }
  const auto& s = raw_.stamp;
  const PinholeModel model =
      model_ ? *model_
             : PinholeModel{intrinsics_of(*view_, static_cast<int>(s.width), static_cast<int>(s.height)), {}};
  auto depth = depth_of(raw_, model, config_.min_depth_m, config_.max_depth_m);
  if (!depth) {
    reject(depth.error().detail);
    return std::nullopt;
  }
  const std::uint64_t unread = number_ > 0 ? s.number - number_ - 1 : 0;
  number_ = s.number;
  const auto times =
      gate_.pass(s.index, s.ticks, arrival(s) - duration_of(1e-3 * config_.latency_ms), unread);
  if (!times) {
    reject(times.error().detail);
    return std::nullopt;
  }
  late_ms_ = 1e3 * seconds(times->late);
  DepthFrame frame;
  frame.exposed_at = times->exposed;
  frame.intrinsics = model.intrinsics;
  frame.depth_m = std::move(*depth);
  return frame;
}

Openni2Report Openni2Stream::report() const {
  Openni2Report r;
  r.pid = pid();
  r.starts = watch().starts();
  r.kills = watch().kills();
  r.missed = missed();
  r.broken = broken();
  r.dropped = gate_.counts();
  r.late_ms = late_ms_;
  r.name = news().name;
  r.serial = news().serial;
  r.error = error();
  r.last_words = news().refused.empty() ? news().last_words : news().refused;
  return r;
}

}  // namespace colift::hal::openni2
