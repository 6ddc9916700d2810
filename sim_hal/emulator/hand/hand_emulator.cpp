#include "sim_hal/emulator/hand/hand_emulator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace colift::sim_hal {
namespace {

using Kind = HandFault::Kind;
using namespace prop;

constexpr hal::Duration kTick = std::chrono::milliseconds(1);
constexpr double kOwnPause_s = 0.5;  // that a client leaves after a puck should be awake
constexpr int kMostFrames = 1000;    // in one go: a babbling client must not hold the caller up
constexpr std::array<const char*, kHandPucks> kNames{"F1", "F2", "F3", "spread"};

}  // namespace

HandEmulator::HandEmulator(HandEmulatorConfig config, HandPlant& plant, hal::CanBus& bus, OnEvent on_event)
    : config_(std::move(config)),
      plant_(plant),
      bus_(bus),
      on_event_(std::move(on_event)),
      dice_(config_.seed) {}

hal::Result<> HandEmulator::start(hal::Timestamp now) {
  const auto bad = [](const char* where, std::string words) {
    return hal::failure(hal::ErrorCode::BadConfig, where, std::move(words));
  };
  if (config_.latency < config_.jitter || config_.jitter.count() < 0)
    return bad("hand.latency", "the jitter has to be at least 0 and no more than the latency");
  if (!(config_.puck.boot_s > 0.0) || !(config_.puck.hi_silence_s >= 0.0) || config_.pad_scan.count() < 0)
    return bad("hand.times", "a puck needs some time to boot, and no time is negative");
  pucks_.clear();
  for (std::size_t p = 0; p < kHandPucks; ++p) {
    HandPuckConfig c = config_.puck;
    c.group_c = config_.group_c[p].value_or(c.group_c);
    pucks_.emplace_back(p, c);
    pucks_[p].start(plant_.joint(p));
    was_ready_[p] = pucks_[p].ready();
  }
  out_.clear();
  scan_due_ = {};
  last_set_ = {};
  faulted_ = {};
  turned_ = 0.0;
  began_.assign(config_.faults.size(), false);
  ended_ = began_;
  start_ = wire_free_ = now;
  next_tick_ = now + kTick;
  t_s_ = 0.0;
  report_ = {};
  run_faults();
  return {};
}

double HandEmulator::chance() {
  std::uint64_t z = dice_ += 0x9e3779b97f4a7c15ULL;  // splitmix64
  z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ z >> 27) * 0x94d049bb133111ebULL;
  return static_cast<double>((z ^ z >> 31) >> 11) * 0x1.0p-53;
}

void HandEmulator::event(const std::string& text) const {
  if (on_event_) on_event_(t_s_, text);
}

const HandFault* HandEmulator::active(Kind kind, std::size_t puck) const {
  for (const HandFault& f : config_.faults)
    if (f.kind == kind && f.hits(puck) && f.active(t_s_)) return &f;
  return nullptr;
}

bool HandEmulator::connected() const {
  return active(Kind::BusOff, 0) == nullptr && active(Kind::Down, 0) == nullptr;
}

bool HandEmulator::hears(std::size_t puck) const {
  return !pucks_[puck].deaf() && active(Kind::Silent, puck) == nullptr && active(Kind::Off, puck) == nullptr;
}

// A controller acknowledges what its puck does not care for; one that boots or has no power does not.
bool HandEmulator::acknowledged() const {
  for (std::size_t p = 0; p < kHandPucks; ++p)
    if (pucks_[p].life() != HandPuck::Life::Booting && active(Kind::Silent, p) == nullptr &&
        active(Kind::Off, p) == nullptr)
      return true;
  return false;
}

void HandEmulator::reset(std::size_t puck, const char* reason) {
  pucks_[puck].reset();
  scan_due_[puck].reset();
  event(fmt::format("{} resets: {}", kNames[puck], reason));
}

hal::Timestamp HandEmulator::next_out() const {
  hal::Timestamp first = hal::Timestamp::max();
  for (const Letter& l : out_) first = std::min(first, l.due);
  return out_.empty() ? first : std::max(first, wire_free_);
}

hal::Timestamp HandEmulator::next_event() const {
  return std::min(next_tick_, next_out());
}

void HandEmulator::step(hal::Timestamp now) {
  hal::CanFrame frame;
  for (int i = 0; i < kMostFrames; ++i) {
    if (bus_.receive(frame, hal::Duration(0)) != hal::CanBus::Received::Frame) break;
    deliver(frame, now);
  }
  while (next_event() <= now) {
    if (next_out() <= next_tick_)
      flush(next_out());
    else
      tick();
  }
}

void HandEmulator::tick() {
  const hal::Timestamp at = next_tick_;
  double drawn = 0.0;
  for (std::size_t p = 0; p < kHandPucks; ++p) {
    HandMotor m = pucks_[p].decide();
    if (active(Kind::Off, p) != nullptr) m = {};
    if (active(Kind::Stuck, p) != nullptr) m.speed = 0.0;
    if (p == kHandSpread) turn_from_outside(m);
    if (p == kHandSpread && turned_ != 0.0) m.speed = 0.0;
    plant_.command(p, m);
  }
  plant_.advance(kTick);
  next_tick_ += kTick;
  t_s_ = hal::seconds(at - start_);
  for (std::size_t p = 0; p < kHandPucks; ++p) {
    HandJoint joint = plant_.joint(p);
    if (p == kHandSpread) joint.motor += turned_;
    drawn += std::abs(joint.torque);
    if (pucks_[p].look(joint)) {
      if (p < kHandFingers) plant_.tighten(p);
      ++report_.initialised[p];
      faulted_[p] = false;
      event(fmt::format("{} has found its stop", kNames[p]));
    }
    if (pucks_[p].ready() && !was_ready_[p]) event(fmt::format("{} is awake", kNames[p]));
    was_ready_[p] = pucks_[p].ready();
  }
  if (config_.brown_out_units > 0.0 && drawn > config_.brown_out_units)
    for (std::size_t p = 0; p < kHandPucks; ++p) reset(p, "the motors drew too much");
  run_faults();
  for (std::size_t p = 0; p < kHandPucks; ++p)
    if (scan_due_[p] && *scan_due_[p] <= at) send_scan(p);
}

void HandEmulator::flush(hal::Timestamp now) {
  // who is ready when the bus is free: the lowest identifier wins; one puck's frames keep their order
  auto best = out_.end();
  for (auto l = out_.begin(); l != out_.end(); ++l)
    if (l->due <= now && (best == out_.end() || l->frame.id < best->frame.id)) best = l;
  if (best == out_.end()) return;
  const hal::CanFrame frame = best->frame;
  out_.erase(best);
  wire_free_ = now + hand_frame_time(frame);
  if (!connected()) return;
  if (bus_.send(frame) == hal::CanBus::Sent::Yes)
    ++report_.answers;
  else
    ++report_.not_sent;
}

void HandEmulator::deliver(const hal::CanFrame& frame, hal::Timestamp at) {
  if (!connected() || pucks_.empty()) return;
  if (!acknowledged()) {
    bool excused = t_s_ - stood_still_s_ < config_.puck.boot_s + kOwnPause_s;
    for (std::size_t p = 0; p < kHandPucks; ++p)
      excused = excused || active(Kind::Off, p) != nullptr || active(Kind::Silent, p) != nullptr;
    broke(HandRule::Unacknowledged, fmt::format("frame {:03x} while no puck is awake", frame.id), excused);
    if (on_unacknowledged) on_unacknowledged();
    return;
  }
  const auto request = read_hand_request(frame);
  bool mine = false;
  for (std::size_t p = 0; p < kHandPucks; ++p) {
    const int from = frame.id >> 5 & 0x1f, to = frame.id & 0x1f;
    const bool for_it = (frame.id & 0x400) != 0 ? pucks_[p].listens_to(to) : to == pucks_[p].node();
    if (!for_it || from == pucks_[p].node()) continue;
    mine = true;
    if (request && hears(p)) hear(p, *request, at);
  }
  ++(mine ? report_.heard : report_.foreign);
  if (!mine) return;
  if (!request && frame.length > 0)
    broke(HandRule::Malformed, fmt::format("{} bytes, the first {:#04x}", frame.length, frame.data[0]));
  if (request) ++(request->kind == HandRequest::Kind::Get ? report_.questions : report_.settings);
}

void HandEmulator::hear(std::size_t p, const HandRequest& r, hal::Timestamp at) {
  switch (r.kind) {
    case HandRequest::Kind::Get:
      answer(p, r, at);
      return;
    case HandRequest::Kind::Set:
      set(p, r.property, r.value, at);
      return;
    case HandRequest::Kind::PackedTorque:
      if (const auto k = pucks_[p].value(kPidx); k >= 1 && k <= 4)
        set(p, kT, r.torque[static_cast<std::size_t>(k - 1)], at);
      return;
  }
}

void HandEmulator::set(std::size_t p, int property, std::int32_t value, hal::Timestamp at) {
  judge_set(p, property, value, at);
  const bool was_asleep = pucks_[p].life() == HandPuck::Life::Monitor;
  switch (pucks_[p].set(property, value)) {
    case HandPuck::Taken::Yes:
      if (property == kTact && (value == 1 || value == 2) && pucks_[p].has_pad()) begin_scan(p, at);
      if (property == kTact && value == 0) scan_due_[p].reset();
      break;
    case HandPuck::Taken::Unknown:
      broke(HandRule::UnknownProperty, fmt::format("set {} of {}", hand_property_name(property), kNames[p]));
      break;
    case HandPuck::Taken::ReadOnly:
      broke(HandRule::NotWritable, fmt::format("{} of {}", hand_property_name(property), kNames[p]));
      break;
    case HandPuck::Taken::Asleep:
      break;
  }
  if (!was_asleep && pucks_[p].life() == HandPuck::Life::Monitor) {
    scan_due_[p].reset();
    event(fmt::format("{} resets: commanded", kNames[p]));
  }
}

void HandEmulator::begin_scan(std::size_t p, hal::Timestamp at) {
  if (!scan_due_[p]) scan_due_[p] = at + config_.pad_scan;  // one at a time
}

void HandEmulator::send_scan(std::size_t p) {
  const hal::Timestamp due = *scan_due_[p];
  scan_due_[p].reset();
  const HandCells cells = pucks_[p].cells();
  ++report_.scans;
  if (pucks_[p].value(kTact) == 1) post(p, hand_pad_top(pucks_[p].node(), cells), due);
  if (pucks_[p].value(kTact) == 2)
    for (int row = 0; row < 5; ++row) post(p, hand_pad_row(pucks_[p].node(), row, cells), due);
}

void HandEmulator::answer(std::size_t p, const HandRequest& r, hal::Timestamp at) {
  const HandPuck& puck = pucks_[p];
  const auto value = puck.get(r.property);
  if (!value) {
    broke(puck.knows(r.property) ? HandRule::NotReadable : HandRule::UnknownProperty,
          fmt::format("asked {} for {}", kNames[p], hand_property_name(r.property)),
          asleep_by_fault(p) && puck.knows(r.property) && hand_property(r.property)->readable());
    return;
  }
  const double swing = 2.0 * chance() - 1.0;
  const hal::Timestamp due =
      at + config_.latency +
      hal::Duration(static_cast<std::int64_t>(swing * static_cast<double>(config_.jitter.count())));
  const bool known = puck.knows(r.property);
  if (known && r.property == kTact) {
    if (*value == 1 || *value == 2)
      begin_scan(p, at);
    else
      post(p, hand_value(puck.node(), r.from, kTact, false, *value), due);
  } else if (known && r.property == kP && r.from == 0) {
    post(p, hand_position(puck.node(), *value, puck.has_joint() ? std::optional(puck.joint()) : std::nullopt),
         due);
  } else if (known && r.property == kJp && r.from == 0) {
    post(p, hand_joint(puck.node(), *value), due);
  } else {
    post(p, hand_value(puck.node(), r.from, r.property, known && hand_property(r.property)->wide, *value),
         due);
  }
}

void HandEmulator::post(std::size_t p, hal::CanFrame frame, hal::Timestamp due) {
  if (active(Kind::Silent, p) != nullptr || active(Kind::Off, p) != nullptr) return;
  if (const HandFault* f = active(Kind::Loss, p); f != nullptr && 100.0 * chance() < f->value) return;
  if (const HandFault* f = active(Kind::Late, p))
    due += hal::Duration(static_cast<std::int64_t>(1e6 * f->value));
  if (active(Kind::Wrong, p) != nullptr) {
    const int other = kFirstHandNode + static_cast<int>((p + 1) % kHandPucks);
    frame.id = static_cast<std::uint16_t>((frame.id & ~0x3e0) | other << 5);
  }
  if (const HandFault* f = active(Kind::Corrupt, p);
      f != nullptr && frame.length > 0 && 100.0 * chance() < f->value) {
    const auto byte = static_cast<std::size_t>(chance() * frame.length);
    frame.data[byte] = static_cast<std::uint8_t>(frame.data[byte] ^ 1U << static_cast<int>(8.0 * chance()));
  }
  out_.push_back({due, frame});
  if (active(Kind::Duplicate, p) != nullptr) out_.push_back({due, frame});
}

}  // namespace colift::sim_hal
