#include "sim_hal/emulator/hand/hand_server.hpp"

#include <algorithm>
#include <utility>

#include "sim_hal/emulator/hand/hand_gateway.hpp"

namespace colift::sim_hal {
namespace {

constexpr hal::Duration kLate = std::chrono::milliseconds(20), kPublish = std::chrono::milliseconds(50);
constexpr hal::Duration kReopen = std::chrono::seconds(1);
constexpr std::size_t kMostEvents = 10000;  // that nobody fetched
// classes of error frames, linux/can/error.h
constexpr std::uint32_t kController = 0x4, kNoAcknowledge = 0x20, kBusOff = 0x40, kRestarted = 0x100,
                        kBusError = 0x88;

}  // namespace

HandServer::HandServer(HandEmulatorConfig config, std::unique_ptr<HandPlant> plant,
                       std::unique_ptr<hal::CanBus> bus)
    : config_(std::move(config)), plant_(std::move(plant)), bus_(std::move(bus)) {}

HandServer::~HandServer() {
  stop();
}

hal::Result<> HandServer::start() {
  if (thread_.joinable())
    return hal::failure(hal::ErrorCode::NotReady, "hand.start", "the emulator runs already");
  if (auto done = bus_->open(); !done) return done;
  auto* gate = dynamic_cast<HandGateway*>(bus_.get());
  if (gate != nullptr) config_.judges_pace = false;
  hand_ =
      std::make_unique<HandEmulator>(config_, *plant_, *bus_, [this](double t_s, const std::string& text) {
        const std::lock_guard lock(mutex_);
        if (events_.size() < kMostEvents) events_.push_back({t_s, text});
      });
  if (gate != nullptr) {
    hand_->on_bus = [gate](HandFault::Kind kind, bool begins) {
      if (kind == HandFault::Kind::Down) gate->set_down(begins);
      if (kind == HandFault::Kind::BusOff) gate->tell_error(begins ? kBusOff : kRestarted);
      if (kind == HandFault::Kind::Noise) gate->tell_error(kBusError);
      if (kind == HandFault::Kind::Passive) gate->tell_error(begins ? kController : kRestarted);
    };
    hand_->on_unacknowledged = [gate] { gate->tell_error(kNoAcknowledge); };
  }
  if (auto done = hand_->start(hal::Timestamp(0)); !done) {
    bus_->close();
    return done;
  }
  stop_ = false;
  timing_ = {};
  thread_ = std::thread([this] { run(); });
  return {};
}

void HandServer::stop() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
  if (bus_) bus_->close();
}

void HandServer::run() {
  const hal::Timestamp began = wall_.now();
  hal::Timestamp zero = began, published = began, opened = began;
  const auto* gate = dynamic_cast<const HandGateway*>(bus_.get());  // goes down and up on request only
  while (!stop_) {
    const hal::Timestamp wall = wall_.now();
    if (const hal::Duration late = wall - zero - hand_->next_event(); late > kLate) {
      // no client pays for this machine: the hand's time stood still
      ++timing_.late;
      timing_.worst_late_ms = std::max(timing_.worst_late_ms, 1e3 * hal::seconds(late));
      zero += late;
      hand_->stood_still();
    }
    hand_->step(wall - zero);
    {
      const std::lock_guard lock(mutex_);
      for (HandFault& f : wished_) {
        f.at_s += hand_->elapsed_s();
        hand_->inject(f);
      }
      wished_.clear();
    }
    if (wall - published > kPublish) {
      published = wall;
      timing_.wall_s = hal::seconds(wall - began);
      publish();
    }
    const hal::Duration wait = std::max(hand_->next_event() - (wall_.now() - zero), hal::Duration(0));
    hal::CanFrame frame;
    switch (bus_->receive(frame, wait)) {
      case hal::CanBus::Received::Frame:
        hand_->deliver(frame, wall_.now() - zero);
        break;
      case hal::CanBus::Received::Nothing:
        break;
      case hal::CanBus::Received::Down:
        std::this_thread::sleep_for(wait);
        if (gate == nullptr && wall - opened > kReopen) {
          opened = wall;
          (void)bus_->open();
        }
        break;
    }
  }
  publish();
}

void HandServer::publish() {
  const std::lock_guard lock(mutex_);
  published_ = hand_->report();
  published_timing_ = timing_;
  published_s_ = hand_->elapsed_s();
}

void HandServer::inject(HandFault fault) {
  const std::lock_guard lock(mutex_);
  wished_.push_back(std::move(fault));
}

HandEmulatorReport HandServer::report() const {
  const std::lock_guard lock(mutex_);
  return published_;
}

HandServerTiming HandServer::timing() const {
  const std::lock_guard lock(mutex_);
  return published_timing_;
}

std::vector<HandServer::Event> HandServer::take_events() {
  const std::lock_guard lock(mutex_);
  return std::exchange(events_, {});
}

double HandServer::elapsed_s() const {
  const std::lock_guard lock(mutex_);
  return published_s_;
}

}  // namespace colift::sim_hal
