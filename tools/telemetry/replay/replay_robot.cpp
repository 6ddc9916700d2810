#include "tools/telemetry/replay/replay_robot.hpp"

#include <fmt/format.h>

#include "tools/telemetry/channels/channels.hpp"

namespace colift::telemetry {
namespace {

tl::unexpected<hal::Error> over(const char* device) {
  return hal::failure(hal::ErrorCode::LinkLost, device, "the recording ends here");
}

class ReplayedArm final : public hal::Arm {
 public:
  explicit ReplayedArm(Tape& tape) : tape_(tape) {}
  hal::Result<> configure() override { return tape_.next_answer(); }
  hal::Result<> activate() override { return tape_.next_answer(); }
  void deactivate() noexcept override {}
  [[nodiscard]] hal::DeviceHealth health() const override { return tape_.next_health(); }
  hal::Result<hal::ArmState> wait_cycle() override {
    if (auto state = tape_.next_arm()) return *state;
    return over("arm");
  }
  hal::Result<> command(const hal::ImpedanceCommand&) override { return tape_.next_answer(); }
  void stop() noexcept override {}

 private:
  Tape& tape_;
};

class ReplayedHand final : public hal::Hand {
 public:
  explicit ReplayedHand(Tape& tape) : tape_(tape) {}
  hal::Result<> configure() override { return tape_.next_answer(); }
  hal::Result<> activate() override { return tape_.next_answer(); }
  void deactivate() noexcept override {}
  [[nodiscard]] hal::DeviceHealth health() const override { return {}; }
  hal::Result<hal::HandState> state() override {
    if (auto state = tape_.next_hand()) return *state;
    return over("hand");
  }
  hal::Result<> preshape(double) override { return tape_.next_answer(); }
  hal::Result<> close(double) override { return tape_.next_answer(); }
  hal::Result<> release() override { return tape_.next_answer(); }
  void stop() noexcept override {}

 private:
  Tape& tape_;
};

class ReplayedCamera final : public hal::DepthCamera {
 public:
  explicit ReplayedCamera(Tape& tape) : tape_(tape) {}
  hal::Result<> configure() override { return tape_.next_answer(); }
  hal::Result<> activate() override { return tape_.next_answer(); }
  void deactivate() noexcept override {}
  [[nodiscard]] hal::DeviceHealth health() const override { return {}; }
  hal::Result<hal::DepthFrame> next_frame(std::chrono::milliseconds) override { return tape_.next_camera(); }

 private:
  Tape& tape_;
};

class ReplayedClock final : public hal::Clock {
 public:
  explicit ReplayedClock(Tape& tape) : tape_(tape) {}
  [[nodiscard]] hal::Timestamp now() const override { return tape_.next_clock(); }

 private:
  Tape& tape_;
};

}  // namespace

Tape::Tape(const McapReader& file)
    : channels_(file.info().channels),
      cursor_(file.messages({channel_of(Topic::Inputs).topic, channel_of(Topic::Frame).topic,
                             channel_of(Topic::Colour).topic, channel_of(Topic::Depth).topic,
                             channel_of(Topic::MoreFrame).topic, channel_of(Topic::MoreDepth).topic})) {}

void Tape::note(std::string text) {
  if (notes_.size() < 20) notes_.push_back(std::move(text));
}

bool Tape::advance() {
  if (ended_) return false;
  while (const auto message = cursor_.next()) {
    const auto channel = channels_.find(message->channel_id);
    if (channel == channels_.end()) continue;
    if (channel->second.topic != channel_of(Topic::Inputs).topic) {
      if (auto frame = joiner_.add(channel->second.topic, message->data))
        frames_[frame->number] = std::move(*frame);
      continue;
    }
    auto next = parse_inputs(message->data);
    if (!next) {
      note(next.error().text());
      continue;
    }
    if (next->cycle != cycles_)
      note(fmt::format("cycles {} to {} are missing in the recording", cycles_, next->cycle));
    cycles_ = next->cycle + 1;
    now_ = std::move(*next);
    clock_ = arm_ = hand_ = camera_ = answer_ = health_ = 0;
    return true;
  }
  ended_ = true;
  return false;
}

hal::Timestamp Tape::next_clock() {
  if (clock_ < now_.clock_ns.size()) last_clock_ = hal::Timestamp(now_.clock_ns[clock_++]);
  return last_clock_;
}

std::optional<hal::Result<hal::ArmState>> Tape::next_arm() {
  if (arm_ < now_.arm.size()) return now_.arm[arm_++];
  return std::nullopt;
}

std::optional<hal::Result<hal::HandState>> Tape::next_hand() {
  if (hand_ < now_.hand.size()) return now_.hand[hand_++];
  return std::nullopt;
}

hal::Result<hal::DepthFrame> Tape::next_camera() {
  if (camera_ >= now_.camera.size()) return over("camera");
  const CameraReading& reading = now_.camera[camera_++];
  if (!reading.frame) return tl::unexpected(reading.error);
  const auto found = frames_.find(*reading.frame);
  if (found == frames_.end()) {
    note(fmt::format("frame {} is missing in the recording", *reading.frame));
    return hal::failure(hal::ErrorCode::Timeout, "camera", "the frame is missing in the recording");
  }
  auto frame = decode_frame(found->second);
  frames_.erase(frames_.begin(), std::next(found));
  if (!frame) {
    note(fmt::format("frame {}: {}", *reading.frame, frame.error().text()));
    return hal::failure(hal::ErrorCode::Timeout, "camera", "the frame is damaged in the recording");
  }
  return std::move(frame->frame);
}

hal::Result<> Tape::next_answer() {
  if (answer_ < now_.answers.size()) return now_.answers[answer_++];
  return {};
}

hal::DeviceHealth Tape::next_health() {
  if (health_ < now_.arm_health.size()) last_health_ = now_.arm_health[health_++];
  return last_health_;
}

hal::Robot replayed_robot(Tape& tape, std::size_t more_cameras) {
  hal::Robot robot;
  robot.arm = std::make_unique<ReplayedArm>(tape);
  robot.hand = std::make_unique<ReplayedHand>(tape);
  robot.camera = std::make_unique<ReplayedCamera>(tape);
  // all of them read from the one tape, in the order in which the job asks
  for (std::size_t n = 0; n < more_cameras; ++n)
    robot.more_cameras.push_back(std::make_unique<ReplayedCamera>(tape));
  robot.clock = std::make_unique<ReplayedClock>(tape);
  return robot;
}

}  // namespace colift::telemetry
