#include "hal/drivers/capture_link/capture_supervisor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <utility>

namespace colift::hal::capture {
namespace {

using namespace std::chrono_literals;
using Health = DeviceHealth::State;

constexpr auto kLongestWait = 20ms;  // between two looks at the process
constexpr double kStalled_s = 0.1;

void sleep_for(Duration d) {
  const timespec t{0, std::clamp<long>(d.count(), 0, 999'999'999)};
  (void)::nanosleep(&t, nullptr);
}

}  // namespace

CaptureSupervisor::CaptureSupervisor(std::string name, const CaptureTimes& times, const RingShape& shape,
                                     const Clock& clock)
    : clock_(clock), name_(std::move(name)), times_(times), shape_(shape), watch_(times) {}

Error CaptureSupervisor::wrong(ErrorCode code, const char* where, std::string what) const {
  return {code, name_ + where, std::move(what)};
}

// ---- the process

void CaptureSupervisor::start() {
  process_.reset();
  news_ = {};
  auto made = FrameRing::make(shape_);
  if (!made) {
    error_ = made.error().text();
    return;
  }
  ring_.emplace(std::move(*made));
  auto begun = CaptureProcess::start(call_, ring_->fd());
  if (!begun) {
    error_ = begun.error().text();
    return;
  }
  process_.emplace(std::move(*begun));
  started();
}

void CaptureSupervisor::look_after() {
  const bool exists = process_ && process_->exists();
  listen();
  if (is_recording() && watch_.running() && news_.end == CaptureEnd::DeviceLost) {
    watch_.rest();  // a recording does not come back by itself
    note_loss("the recording is over");
    return;
  }
  CaptureMonitor::Sight sight;
  sight.exists = exists;
  if (ring_) sight.heartbeat = ring_->heartbeat(), sight.frames = ring_->newest(Stream::Depth);
  if (!exists) {
    sight.ended = words_of_end();
    sight.no_device = news_.end == CaptureEnd::NoDevice;
  }
  const bool ran = watch_.running();
  switch (watch_.look(sight, clock_.now())) {
    case CaptureMonitor::Do::Nothing:
      break;
    case CaptureMonitor::Do::Start:
      start();
      break;
    case CaptureMonitor::Do::Kill:
      if (process_) process_->kill();
      break;
    case CaptureMonitor::Do::Abandon:
      if (process_) process_->abandon();
      break;
  }
  if (ran && !watch_.running()) note_loss(watch_.why());
}

void CaptureSupervisor::listen() {
  if (process_) process_->listen(news_);
  heard();
}

void CaptureSupervisor::wait(Duration timeout) const {
  if (process_)
    process_->wait(std::min<Duration>(timeout, kLongestWait));
  else
    sleep_for(std::min<Duration>(timeout, kLongestWait));
}

void CaptureSupervisor::send_line(const std::string& line) const {
  if (process_) process_->send_line(line);
}

std::string CaptureSupervisor::words_of_end() const {
  if (news_.end) return news_.reason;
  if (!process_) return error_.empty() ? "the capture process is not there" : error_;
  const std::string& how = process_->ended();
  const std::string last =
      news_.last_words.empty() ? "" : fmt::format("; its last words: {}", news_.last_words);
  return fmt::format("the capture process ended with {}{}", how.empty() ? "no word" : how, last);
}

void CaptureSupervisor::note_loss(const std::string& why) {
  error_ = why;
  last_error_ = why;
}

bool CaptureSupervisor::lost() const {
  return !watch_.running() || news_.end || seconds(clock_.now() - frame_at_) > times_.silent_s;
}

std::string CaptureSupervisor::words_of_loss() const {
  if (!watch_.running()) return error_.empty() ? "the capture process is not there" : error_;
  if (news_.end) return news_.reason;  // it closes its device meanwhile, which may take its time
  return fmt::format("no frame for {:.1f} s{}", seconds(clock_.now() - frame_at_),
                     error_.empty() ? "" : fmt::format(" (before: {})", error_));
}

// ---- raw frames

Timestamp CaptureSupervisor::arrival(const FrameStamp& s) const {
  const Duration age = std::clamp<Duration>(machine_.now() - Timestamp(s.arrived_ns), 0ns, 10s);
  return clock_.now() - age;
}

void CaptureSupervisor::reject(std::string why) {
  ++rejected_;
  last_error_ = std::move(why);
}

bool CaptureSupervisor::read(Stream stream, RawFrame& into) {
  if (!ring_) return false;
  const auto got = ring_->read(stream, into);
  if (got) return *got;
  ++broken_;
  reject(got.error().detail);
  return false;
}

DepthFrame CaptureSupervisor::hand_out(DepthFrame frame) {
  error_.clear();
  ++accepted_;
  frame_at_ = clock_.now();
  return frame;
}

// ---- the life of a device

Result<> CaptureSupervisor::configure() {
  if (opened_ && !watch_.resting()) {
    // it is being looked after already; nobody waits for it in the middle of a job
    look_after();
    if (!lost()) return {};
    const bool fresh = watch_.running() && !news_.end && ring_ && ring_->newest(Stream::Depth) > 0 &&
                       seconds(clock_.now() - watch_.frame_seen_at()) < times_.silent_s;
    if (fresh) return {};
    return tl::unexpected(wrong(ErrorCode::LinkLost, ".configure", words_of_loss()));
  }
  if (auto first = first_frame(); !first) return first;
  opened_ = true;
  return {};
}

Result<> CaptureSupervisor::first_frame() {
  const Timestamp deadline = clock_.now() + duration_of(times_.open_s);
  watch_.want();
  for (;;) {
    look_after();
    if (ring_ && watch_.running() && ring_->newest(Stream::Depth) > 0) break;
    const bool ended = !watch_.running();
    if (ended || clock_.now() >= deadline) {
      const std::string why = ended ? error_ : fmt::format("no frame within {:.1f} s", times_.open_s);
      const bool gone = news_.end == CaptureEnd::NoDevice || news_.end == CaptureEnd::DeviceLost;
      last_error_ = why;
      watch_.rest();
      process_.reset();
      return tl::unexpected(wrong(gone ? ErrorCode::LinkLost : ErrorCode::DeviceFault, ".configure", why));
    }
    wait(kLongestWait);
  }
  frame_at_ = clock_.now();
  error_.clear();
  return {};
}

Result<> CaptureSupervisor::activate() {
  if (!opened_)
    return tl::unexpected(
        wrong(ErrorCode::NotReady, ".activate", "the camera is not open, call configure() first"));
  active_ = true;
  return {};
}

Result<DepthFrame> CaptureSupervisor::next_frame(std::chrono::milliseconds timeout) {
  constexpr auto kWhere = ".next_frame";
  if (!active_)
    return tl::unexpected(
        wrong(ErrorCode::NotReady, kWhere, "the camera does not stream, call activate() first"));
  const Timestamp deadline = clock_.now() + std::max(timeout, 0ms);
  for (;;) {
    // before the process is judged: its last frames count, even when it is gone
    if (auto frame = take()) return hand_out(std::move(*frame));
    look_after();
    if (auto frame = take()) return hand_out(std::move(*frame));
    if (lost()) return tl::unexpected(wrong(ErrorCode::LinkLost, kWhere, words_of_loss()));
    const Timestamp now = clock_.now();
    if (now >= deadline)
      return tl::unexpected(
          wrong(ErrorCode::Timeout, kWhere, fmt::format("no frame within {} ms", timeout.count())));
    wait(deadline - now);
  }
}

DeviceHealth CaptureSupervisor::health() const {
  DeviceHealth h;
  h.accepted = accepted_;
  h.rejected = rejected_;
  h.last_error = last_error_;
  if (!opened_)
    h.state = last_error_.empty() ? Health::Absent : Health::Failed;
  else if (lost() && active_)
    h.state = Health::Lost;
  else if (!active_)
    h.state = Health::Opening;
  else
    h.state = seconds(clock_.now() - frame_at_) > kStalled_s ? Health::Stalled : Health::Streaming;
  return h;
}

}  // namespace colift::hal::capture
