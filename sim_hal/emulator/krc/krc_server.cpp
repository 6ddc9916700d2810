#include "sim_hal/emulator/krc/krc_server.hpp"

#include <pthread.h>
#include <sched.h>

#include <algorithm>
#include <utility>

#include "hal/os/realtime.hpp"
#include "hal/os/udp_link.hpp"

namespace colift::sim_hal {
namespace {

constexpr int kPriority = 35;  // below the client's: the judge must not starve the judged
constexpr hal::Duration kTimeout = std::chrono::milliseconds(100);  // with speed 0
constexpr double kLate = 0.25, kMostWaiting = 0.5;                  // of a cycle
constexpr double kPublish_s = 0.1;
constexpr std::size_t kMostEvents = 10000;  // that nobody fetched
constexpr std::size_t kMostMissed = 1000;   // that are told one by one

bool ask_realtime() {
  sched_param parameter{};
  parameter.sched_priority = kPriority;
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter) == 0;
}

}  // namespace

KrcServer::KrcServer(KrcServerConfig config, const hal::ArmDynamics& dynamics,
                     std::unique_ptr<KrcPlant> plant)
    : config_(std::move(config)), dynamics_(dynamics), plant_(std::move(plant)) {}

KrcServer::~KrcServer() {
  stop();
}

hal::Result<> KrcServer::start() {
  if (thread_.joinable())
    return hal::failure(hal::ErrorCode::NotReady, "krc.start", "the emulator runs already");
  if (!(config_.speed >= 0.0 && config_.speed <= 1000.0))
    return hal::failure(hal::ErrorCode::BadConfig, "krc.speed",
                        "the speed has to be a number from 0 to 1000");
  // a client on this machine: nobody else reaches the emulator
  constexpr std::uint32_t kLoopback = 0x7F000001;
  const bool here = config_.krc.to.address >> 24 == kLoopback >> 24;
  link_ = hal::make_udp_link({here ? kLoopback : 0, config_.from_port});
  if (auto done = link_->open(); !done) return done;
  krc_ = std::make_unique<KrcEmulator>(config_.krc, dynamics_, *plant_, *link_,
                                       [this](double t_s, const std::string& text) {
                                         const std::lock_guard lock(mutex_);
                                         if (events_.size() < kMostEvents) events_.push_back({t_s, text});
                                       });
  if (auto done = krc_->start(hal::Timestamp(0)); !done) {
    link_->close();
    return done;
  }
  stop_ = ended_ = false;
  timing_ = {};
  thread_ = std::thread([this] { run(); });
  return {};
}

void KrcServer::stop() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
  if (link_) link_->close();
}

void KrcServer::run() {
  // as fast as it can it would leave nothing to others
  timing_.realtime = config_.realtime && config_.speed > 0.0 && ask_realtime();
  (void)hal::stay_on_cpu(config_.cpu);
  const hal::Timestamp began = wall_.now();
  hal::Timestamp due = began;
  double published_s = 0.0;
  std::uint64_t missed = 0;
  timing_.missed.reserve(kMostMissed);
  while (!stop_ && !krc_->ended()) {
    if (requests_.exchange(false)) take_requests();
    cycle_at_ = krc_->next_cycle();
    const hal::Timestamp sent = std::exchange(cycle_wall_, wall_.now());
    krc_->cycle();
    note_missed(sent, missed);
    const hal::Duration cycle = krc_->next_cycle() - cycle_at_;
    const hal::Duration in_wall =
        config_.speed > 0.0 ? std::chrono::duration_cast<hal::Duration>(cycle / config_.speed) : kTimeout;

    ++timing_.cycles;
    const hal::Duration late = cycle_wall_ - due;
    if (config_.speed > 0.0) {
      timing_.worst_late_ms = std::max(timing_.worst_late_ms, 1e3 * hal::seconds(late));
      // a cycle that began late is as long as any other: no client pays for this machine
      const bool slipped = hal::seconds(late) > kLate * hal::seconds(in_wall);
      if (slipped) ++timing_.late;
      due = (slipped ? cycle_wall_ : due) + in_wall;
    } else {
      due = cycle_wall_ + in_wall;
    }
    wait_for_answers(cycle_wall_, due);
    timing_.wall_s = hal::seconds(wall_.now() - began);
    if (timing_.wall_s - published_s > kPublish_s) {
      published_s = timing_.wall_s;
      publish();
    }
  }
  publish();
  ended_ = true;
}

void KrcServer::note_missed(hal::Timestamp sent, std::uint64_t& before) {
  const std::uint64_t missed = krc_->missed_in_command();
  if (missed > before && timing_.missed.size() < kMostMissed)
    timing_.missed.push_back({hal::seconds(sent), hal::seconds(cycle_wall_)});
  before = missed;
}

void KrcServer::wait_for_answers(hal::Timestamp sent, hal::Timestamp until) {
  std::array<std::byte, 2048> buffer;  // more than a datagram of Ethernet, so that the true size is told
  const double speed = config_.speed > 0.0 ? config_.speed : 1.0;
  const auto emulated = [&](hal::Timestamp wall) {
    const auto since = std::chrono::duration_cast<hal::Duration>((wall - sent) * speed);
    return std::min(cycle_at_ + since, krc_->next_cycle());
  };
  const hal::Timestamp plant_at =
      sent + std::chrono::duration_cast<hal::Duration>((until - sent) * kMostWaiting);
  bool moved = false;
  const auto move = [&] {
    if (moved) return;
    moved = true;
    const hal::Timestamp begins = wall_.now();
    krc_->move_plant();
    const double took_ms = 1e3 * hal::seconds(wall_.now() - begins);
    timing_.worst_plant_ms = std::max(timing_.worst_plant_ms, took_ms);
    timing_.plant_ms += (took_ms - timing_.plant_ms) / static_cast<double>(timing_.cycles);
  };
  for (;;) {
    // the plant's turn is when the answer is there, so that its arrival is seen in time
    if (krc_->answered() || krc_->silent() || wall_.now() >= plant_at) move();
    if (config_.speed <= 0.0 && (krc_->answered() || krc_->silent())) return;
    hal::Timestamp wake = moved ? until : std::min(until, plant_at);
    // what a fault holds back
    if (const hal::Timestamp event = krc_->next_event(); event < krc_->next_cycle())
      wake = std::min(wake, sent + std::chrono::duration_cast<hal::Duration>((event - cycle_at_) / speed));
    const hal::Timestamp now = wall_.now();
    if (now >= until || stop_) break;
    const hal::Datagram got = link_->receive(buffer, std::max(wake - now, hal::Duration(0)));
    if (got.kind == hal::Datagram::Kind::Broken) {
      stop_ = true;
      break;
    }
    if (got.kind == hal::Datagram::Kind::Data)
      krc_->deliver({buffer.data(), std::min(got.size, buffer.size())}, got.from, emulated(got.arrived_at));
    else
      krc_->flush(emulated(wall_.now()));
  }
  move();
}

void KrcServer::inject(KrcFault fault) {
  const std::lock_guard lock(mutex_);
  wished_.push_back(std::move(fault));
  requests_ = true;
}

void KrcServer::take_requests() {
  std::vector<KrcFault> wished;
  {
    const std::lock_guard lock(mutex_);
    wished.swap(wished_);
  }
  for (KrcFault& fault : wished) {
    fault.at_s += hal::seconds(krc_->next_cycle());
    krc_->inject(fault);
  }
}

void KrcServer::publish() {
  KrcReport report = krc_->report();
  const std::lock_guard lock(mutex_);
  published_ = std::move(report);
  published_timing_ = timing_;
}

KrcReport KrcServer::report() const {
  const std::lock_guard lock(mutex_);
  return published_;
}

KrcServerTiming KrcServer::timing() const {
  const std::lock_guard lock(mutex_);
  return published_timing_;
}

std::vector<KrcServer::Event> KrcServer::take_events() {
  const std::lock_guard lock(mutex_);
  return std::exchange(events_, {});
}

}  // namespace colift::sim_hal
