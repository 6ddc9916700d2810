#include "sim_hal/emulator/hand/hand_emulator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace colift::sim_hal {
namespace {

using Kind = HandFault::Kind;
using namespace prop;

constexpr hal::Duration kTick = std::chrono::milliseconds(1);
constexpr hal::Duration kHurried = std::chrono::microseconds(100);
constexpr int kMostFrames = 1000;       // in one go: a babbling client must not hold the caller up
constexpr std::int32_t kShut = 12'000;  // 0.15 rad: such a finger is in the spread's way
constexpr std::int32_t kTurns = 1'000;  // 5 degrees of spread
constexpr std::int32_t kMostTorque = 5'000;
constexpr int kForeignEvery_ms = 10, kNoiseEvery_ms = 10;
constexpr std::array<const char*, kHandPucks> kNames{"F1", "F2", "F3", "spread"};

bool risky(int property) {
  for (const int p : {6, 7, 12, 13, kId, kSave, kDef, 61})
    if (p == property) return true;
  return false;
}

std::string name_of(int property) {
  const HandProperty* p = hand_property(property);
  return p == nullptr ? fmt::format("property {}", property) : std::string(p->name);
}

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

void HandEmulator::broke(HandRule rule, std::string how) {
  const auto r = static_cast<std::size_t>(rule);
  if (report_.broken[r]++ > 0) return;
  event(fmt::format("{}: {}", kHandRuleNames[r], how));
  report_.first[r] = std::move(how);
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

void HandEmulator::inject(const HandFault& fault) {
  config_.faults.push_back(fault);
  began_.push_back(false);
  ended_.push_back(false);
}

void HandEmulator::act(const HandFault& f, bool begins) {
  if (f.kind == Kind::BusOff || f.kind == Kind::Down || f.kind == Kind::Full || f.kind == Kind::Passive) {
    if (on_bus) on_bus(f.kind, begins);
    return;
  }
  for (std::size_t p = 0; p < kHandPucks; ++p) {
    if (!f.hits(p)) continue;
    if (f.kind == Kind::Freeze) pucks_[p].freeze(begins);
    if (!begins) continue;
    if (f.kind == Kind::Reset) reset(p, "on request");
    if (f.kind == Kind::BrownOut) reset(p, "the supply broke down");
    if (f.kind == Kind::Off) reset(p, "no supply");
    if (f.kind == Kind::Error) pucks_[p].fail(static_cast<int>(f.value));
    if (f.kind == Kind::Jump) pucks_[p].shift(f.value);
  }
}

void HandEmulator::run_faults() {
  for (std::size_t i = 0; i < config_.faults.size(); ++i) {
    const HandFault f = config_.faults[i];
    if (f.active(t_s_) && !began_[i]) {
      began_[i] = true;
      event(fmt::format("fault {}", f.text));
      act(f, true);
    }
    if (began_[i] && !ended_[i] && !f.active(t_s_)) {
      ended_[i] = true;
      act(f, false);
    }
    if (f.kind == Kind::Hot && f.active(t_s_))
      for (std::size_t p = 0; p < kHandPucks; ++p)
        if (f.hits(p)) pucks_[p].heat(f.value);
  }
  if (active(Kind::Noise, 0) != nullptr && ++noise_ms_ >= kNoiseEvery_ms) {
    noise_ms_ = 0;
    if (on_bus) on_bus(Kind::Noise, true);
  }
  if (active(Kind::Foreign, 0) != nullptr && ++foreign_ms_ >= kForeignEvery_ms) {
    foreign_ms_ = 0;
    hal::CanFrame f;  // node 10 to group 0
    f.id = 0x540;
    f.length = 4;
    f.data = {0x85, 0, 0, 0};
    if (bus_.send(f) != hal::CanBus::Sent::Yes) ++report_.not_sent;
  }
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
    plant_.command(p, m);
  }
  plant_.advance(kTick);
  next_tick_ += kTick;
  t_s_ = hal::seconds(at - start_);
  for (std::size_t p = 0; p < kHandPucks; ++p) {
    const HandJoint joint = plant_.joint(p);
    drawn += std::abs(joint.torque);
    if (pucks_[p].look(joint)) {
      if (p < kHandFingers) plant_.tighten(p);
      ++report_.initialised[p];
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
    broke(HandRule::Unacknowledged, fmt::format("frame {:03x} while no puck is awake", frame.id));
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

void HandEmulator::judge_set(std::size_t p, int property, std::int32_t value, hal::Timestamp at) {
  const HandPuck& puck = pucks_[p];
  if (risky(property)) broke(HandRule::Risky, fmt::format("{} of {}", name_of(property), kNames[p]));
  if (config_.judges_pace && last_set_[p] > hal::Timestamp(0) && at - last_set_[p] < kHurried)
    broke(HandRule::Hurried, fmt::format("{} of {} {} us after another setting", name_of(property), kNames[p],
                                         (at - last_set_[p]).count() / 1000));
  last_set_[p] = at;
  if (!puck.ready()) return;
  const auto far = [&](std::int32_t goal) { return std::abs(1.0 * goal - puck.position()) > kTurns; };
  if (property == kE && puck.value(kMode) == 5 && puck.get(kV).value_or(0) != 0 && far(puck.value(kE)) &&
      value != puck.value(kE))
    broke(HandRule::NewEnd,
          fmt::format("{} is moving to {}, commanded {}", kNames[p], puck.value(kE), value));
  if (property == kMt && value > kMostTorque)
    broke(HandRule::TooMuchTorque, fmt::format("MT {} for {}", value, kNames[p]));
  if (property == kMode && value >= 2 && value <= 4 && puck.value(kTstop) > 0)
    broke(HandRule::StreamWithStop,
          fmt::format("MODE {} of {} with TSTOP {}", value, kNames[p], puck.value(kTstop)));
  const bool turns =
      p == kHandSpread && ((property == kMode && value == 5 && far(puck.value(kE))) ||
                           (property == kM && far(value)) || (property == kCmd && value == 13));
  if (!turns) return;
  for (std::size_t f = 0; f < kHandFingers; ++f)
    if (plant_.joint(f).motor > kShut)
      broke(HandRule::FingersInTheWay,
            fmt::format("the spread turns while {} is at {:.0f} counts", kNames[f], plant_.joint(f).motor));
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
      broke(HandRule::UnknownProperty, fmt::format("set {} of {}", name_of(property), kNames[p]));
      break;
    case HandPuck::Taken::ReadOnly:
      broke(HandRule::NotWritable, fmt::format("{} of {}", name_of(property), kNames[p]));
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
          fmt::format("asked {} for {}", kNames[p], name_of(r.property)));
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
