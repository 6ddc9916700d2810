// What the devices say, and what is done when one of them says nothing.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>

#include "control/task/job.hpp"

namespace colift::control {
namespace {

using namespace std::chrono_literals;

constexpr hal::Duration kHandSilent = 200ms;
constexpr hal::Duration kCameraSilent = 300ms;
constexpr hal::Duration kReopenEvery = 2s;  // a camera that is gone is asked for no more often

bool right_size(const hal::DepthFrame& f) {
  return f.depth_m.size() ==
         static_cast<std::size_t>(f.intrinsics.width) * static_cast<std::size_t>(f.intrinsics.height);
}

// bit by bit: pixels that see nothing are NaN
bool same_pixels(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

// The puck that an error of the hand is of alone; its `where` says so ("hand.f2.state", "hand.spread").
std::optional<std::size_t> puck_named_in(const hal::Error& error) {
  constexpr std::array<std::string_view, 4> kNames{"hand.f1", "hand.f2", "hand.f3", "hand.spread"};
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (error.where.starts_with(kNames[i])) return i;
  return std::nullopt;
}

}  // namespace

hal::Result<> Job::start_devices() {
  // a hand takes seconds to wake and to find its stops, and the arm's controller asks for answers all the
  // time: an arm with a thread of its own comes first, one that is served between the others' work comes last
  const bool arm_first = options_.drive == Drive::Thread;
  const auto start_arm = [this]() -> hal::Result<> {
    if (auto ok = robot_.arm->configure(); !ok) return ok;
    return loop_.start();  // activates it, in the thread that answers its cycles
  };
  if (arm_first)
    if (auto started = start_arm(); !started) return started;
  hal::Device* const others[] = {robot_.camera.get(), robot_.hand.get()};
  for (hal::Device* device : others)
    if (auto ok = device->configure(); !ok) return ok;
  for (hal::Device* device : others)
    if (auto ok = device->activate(); !ok) return ok;
  if (!arm_first)
    if (auto started = start_arm(); !started) return started;
  record_.realtime = loop_.realtime();
  began_ = now_ = since_ = frame_at_ = aged_at_ = hand_at_ = waits_since_ = robot_.clock->now();
  wall_start_ = stopwatch_.now();
  arm_ = loop_.view().state;
  home_rad_ = arm_.q_commanded_rad;
  last_because_ = "starts to look";
  record_.states.push_back({hal::Timestamp(0), state_, last_because_});
  now_ = robot_.clock->now();
  return {};
}

void Job::lose(const std::string& device, const std::string& what) {
  record_.faults.push_back({now_ - began_, device, what});
}

void Job::read_devices() {
  read_arm();

  if (auto state = robot_.hand->state()) {
    hand_ = *state;
    hand_at_ = now_;
    if (hand_silent_) lose("hand", "answers again");
    hand_silent_ = false;
    if (auto warning = hand_.warning.str(); warning != hand_warning_) {
      hand_warning_ = std::move(warning);
      if (!hand_warning_.empty()) lose("hand", hand_warning_);
    }
  } else {
    hand_trouble_ = state.error().text();
    puck_alone_ = puck_named_in(state.error());
    const bool gone = state.error().code != hal::ErrorCode::Timeout || now_ - hand_at_ > kHandSilent;
    if (gone && !hand_silent_) lose("hand", hand_trouble_);
    hand_silent_ = hand_silent_ || gone;
  }
  read_camera();
  set_pace();
}

void Job::read_camera() {
  frame_.reset();
  auto frame = robot_.camera->next_frame(0ms);
  // a picture that shows the moving arm where it was is an old one, whatever its stamp says
  const bool frozen = frame && is_moving(state_) && same_pixels(frame->depth_m, last_depth_m_);
  const bool good = frame && right_size(*frame) && frame->exposed_at > frame_at_ && !frozen;
  if (good) {
    last_depth_m_ = frame->depth_m;
    if (camera_lost_) lose("camera", "is back");
    camera_lost_ = false;
    frame_at_ = frame->exposed_at;
    picture_late_ = std::clamp<hal::Duration>(now_ - frame_at_, hal::Duration(0), kCameraSilent);
    frame_ = std::move(*frame);
    return;
  }
  const bool unplugged = !frame && frame.error().code == hal::ErrorCode::LinkLost;
  if (!camera_lost_ && (unplugged || now_ - frame_at_ > kCameraSilent)) {
    camera_lost_ = true;
    reopen_at_ = now_ + kReopenEvery;
    const bool told = !frame && frame.error().code != hal::ErrorCode::Timeout;  // unplugged, moved
    lose("camera", told ? frame.error().text()
                        : fmt::format("no picture for {:.1f} s", hal::seconds(now_ - frame_at_)));
  }
  if (camera_lost_ && unplugged && now_ >= reopen_at_) {
    reopen_at_ = now_ + kReopenEvery;
    if (robot_.camera->configure()) (void)robot_.camera->activate();
  }
}

std::optional<Happening> Job::emergency(const JobHooks& hooks) {
  if (hooks.interrupted && hooks.interrupted()) return Happening{Event::Interrupted, "asked to end"};
  if (arm_silent_) return Happening{Event::ArmLost, arm_trouble_};
  // with nothing held yet the others are opened; later one finger less is a grip that nobody may trust
  if (hand_silent_ && puck_alone_ && next(state_, Event::FingerLost))
    return Happening{Event::FingerLost, hand_trouble_};
  if (hand_silent_) return Happening{Event::HandLost, hand_trouble_};
  if (camera_lost_) return Happening{Event::CameraLost, "the camera gives no picture"};
  if (hand_.hot && !is_loaded(state_)) return Happening{Event::HandUnfit, hand_.warning.str()};
  return std::nullopt;
}

}  // namespace colift::control
