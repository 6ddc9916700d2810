#include "hal/drivers/openni2_camera/openni2_camera.hpp"

#include <fmt/format.h>

#include <utility>

#include "hal/drivers/openni2_camera/openni2_stream.hpp"

namespace colift::hal {

Openni2Camera::Openni2Camera(Openni2CameraConfig config, std::optional<openni2::PinholeModel> model,
                             const Clock& clock)
    : stream_(std::make_unique<openni2::Openni2Stream>(std::move(config), model, clock)), clock_(clock) {}

Openni2Camera::~Openni2Camera() = default;

Result<> Openni2Camera::configure() {
  if (auto found = stream_->find(); !found) return found;
  return stream_->configure();
}

Result<> Openni2Camera::activate() {
  return stream_->activate();
}

void Openni2Camera::deactivate() noexcept {
  stream_->deactivate();
}

DeviceHealth Openni2Camera::health() const {
  return stream_->health();
}

Result<DepthFrame> Openni2Camera::next_frame(std::chrono::milliseconds timeout) {
  return stream_->next_frame(timeout);
}

void Openni2Camera::record_to(const std::filesystem::path& oni) {
  std::error_code none;
  stream_->record_to = std::filesystem::absolute(oni, none).string();
}

Result<> Openni2Camera::finish_recording(std::chrono::milliseconds timeout) {
  constexpr auto kWhere = "openni2.record";
  if (stream_->record_to.empty() || stream_->pid() < 0)
    return failure(ErrorCode::NotReady, kWhere, "nothing is recorded");
  stream_->send_line("finish");
  const Timestamp end = clock_.now() + timeout;
  while (!stream_->news().finished) {
    stream_->look_after();
    if (!stream_->running()) return failure(ErrorCode::LinkLost, kWhere, stream_->words_of_loss());
    if (clock_.now() >= end)
      return failure(ErrorCode::Timeout, kWhere,
                     fmt::format("{} is not whole after {} ms", stream_->record_to, timeout.count()));
    stream_->wait(end - clock_.now());
  }
  return {};
}

Openni2Report Openni2Camera::report() const {
  return stream_->report();
}

}  // namespace colift::hal
