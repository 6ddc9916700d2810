#include "fake_pucks.hpp"

#include <algorithm>
#include <cmath>

namespace colift {
namespace {

constexpr int kP = 48, kE = 52, kTact = 106;

bool is_wide(int p) {
  for (const int wide : {48, 50, 52, 54, 56, 58, 66, 68, 74, 88, 94, 96, 98})
    if (p == wide) return true;
  return false;
}

hal::CanFrame frame(int id, std::initializer_list<int> bytes) {
  hal::CanFrame f;
  f.id = static_cast<std::uint16_t>(id);
  for (const int b : bytes) f.data[f.length++] = static_cast<std::uint8_t>(b);
  return f;
}

// the maker's cubic of a strain gauge, the other way round; 2048 is an open hand
double gauge_counts(double nm) {
  const auto cubic = [](double x) { return ((2.754e-10 * x - 1.708e-6) * x + 0.003764) * x - 2.85; };
  double counts = 2048.0;
  while (counts < 4095.0 && cubic(counts) - cubic(2048.0) < nm) counts += 1.0;
  return counts;
}

}  // namespace

void FakePuck::reset() {
  property = {};
  property[0] = 200;
  property[1] = 0x1e05;
  property[3] = id;
  property[9] = property[20] = 35;
  property[11] = 60;
  property[26] = 0;
  property[27] = 7;
  property[28] = 5;
  property[43] = 2200;
  property[45] = id == 14 ? 50 : 200;
  property[56] = id == 14 ? 35950 : 195000;
  property[68] = 4096;
  property[73] = -75;
  property[77] = id == 14;
  property[78] = 50;
  property[82] = 200;
  stat = 0;
  zero_shift = -position;
  finding_stop = false;
}

void FakePuck::step(double dt_ms) {
  const auto end = [&] { property[8] = property[77] ? 3 : 0; };
  if (finding_stop) {
    position = stuck ? position : std::max(0.0, position + property[73] * dt_ms);
    if (position > 0.0) return;
    zero_shift = clutch_ahead = 0.0;
    property[kE] = 0;
    finding_stop = false;
    end();
    return;
  }
  const double before = position;
  property[42] = 0;
  if (stat == 2 && mode() == 5) {
    const double goal = property[kE] - zero_shift, most = property[45] * dt_ms;
    if (!stuck) position += std::clamp(goal - position, -most, most);
    position = std::max(0.0, std::min(position, std::max(blocked_at, std::min(before, goal))));  // open stop
    property[42] = goal > position ? property[43] : 0;
    still_ms = position == before ? still_ms + dt_ms : 0.0;
    if (std::abs(position - goal) < 1.0)
      end();
    else if (property[78] > 0 && !never_ends && still_ms >= property[78])
      end();
  }
  // a worm keeps the load when the motor rests
  if (position < blocked_at)
    load_nm = 0.0;
  else if (mode() == 5)
    load_nm = property[43] / 2900.0 * std::clamp((property[11] - property[9]) / 16.0, 0.0, 1.0);  // its heat
}

FakeHand::FakeHand(hal::ManualClock& the_clock) : clock(the_clock), bus(the_clock) {
  node_ = bus.node();
  (void)node_->open();
  host = bus.node([this](hal::Timestamp until) { return run_until(until); });
  for (std::size_t i = 0; i < 4; ++i) {
    pucks[i].id = 11 + static_cast<int>(i);
    pucks[i].has_joint = i < 3;
    pucks[i].reset();
  }
  bus.fate = [this](const hal::CanFrame&, const sim_hal::MemoryCan::Node* from) {
    return sim_hal::MemoryCan::Fate{1, from == node_.get() ? latency : hal::Duration{0}};
  };
  bus.tap = [this](const hal::CanFrame& f) {
    if ((f.id & 0x3e0) != 0) return;
    from_host.push_back(f);
    said_at.push_back(clock.now());
  };
}

bool FakeHand::run_until(hal::Timestamp until) {
  listen();
  while (clock.now() < until) {
    const hal::Duration by = std::min<hal::Duration>(until - clock.now(), std::chrono::milliseconds(1));
    clock.advance(by);
    for (FakePuck& puck : pucks) puck.step(1e3 * hal::seconds(by));
    listen();
  }
  return true;
}

void FakeHand::pass(hal::Duration by, const std::function<void()>& each_ms) {
  const hal::Timestamp end = clock.now() + by;
  while (clock.now() < end) {
    (void)run_until(std::min<hal::Timestamp>(end, clock.now() + std::chrono::milliseconds(1)));
    if (each_ms) each_ms();
  }
}

void FakeHand::listen() {
  hal::CanFrame f;
  while (node_->receive(f, hal::Duration{0}) == hal::CanBus::Received::Frame) {
    for (FakePuck& puck : pucks) {
      const int to = f.id & 0x1f;
      const bool group = (f.id & 0x400) != 0;
      const bool mine = group ? to == puck.property[26] || to == puck.property[27] || to == puck.property[28]
                              : to == puck.id;
      if (mine && f.length > 0 && !puck.silent) hear(puck, f);
    }
  }
}

void FakeHand::hear(FakePuck& puck, const hal::CanFrame& f) {
  const hal::Timestamp now = clock.now();
  if (puck.boots_until > hal::Timestamp{0} && now < puck.boots_until) return;
  if (now < puck.quiet_until) return;
  const int p = f.data[0] & 0x7f;
  if ((f.data[0] & 0x80) == 0) {
    const bool monitor = p <= 5;
    if (puck.stat != 0 || monitor) answer(puck, p);
    return;
  }
  std::uint32_t raw = 0;
  for (int i = f.length - 1; i >= 2; --i) raw = raw << 8 | f.data[static_cast<std::size_t>(i)];
  const std::int32_t value =
      f.length == 6 ? static_cast<std::int32_t>(raw) : static_cast<std::int16_t>(raw & 0xffff);
  if (p == 5) {
    if (puck.stat == 0 && value == 2) {
      puck.boots_until = now + std::chrono::milliseconds(900);
      puck.stat = 2;
    }
    return;
  }
  if (puck.stat != 2) return;
  if (p == 29) {
    if (value != 13) return;
    puck.finding_stop = true;
    puck.property[8] = 5;
    puck.quiet_until = now + std::chrono::milliseconds(600);
    return;
  }
  puck.property[static_cast<std::size_t>(p)] = value;
  if (p == 8) {
    puck.modes.push_back(value);
    puck.still_ms = 0.0;
  }
  if (p == kTact && (value == 1 || value == 2)) answer_tactile(puck);
}

void FakeHand::answer(const FakePuck& puck, int p) {
  const int to = 0x400 | puck.id << 5;
  if (p == kP) {
    const auto motor = static_cast<int>(std::lround(puck.position + puck.zero_shift));
    const int joint =
        static_cast<int>(std::lround((puck.position + puck.zero_shift - puck.clutch_ahead) / 2.5));
    hal::CanFrame f = frame(to | 3, {0x80 | (motor >> 16 & 0x3f), motor >> 8 & 255, motor & 255});
    if (puck.has_joint)
      f = frame(to | 3, {0x80 | (motor >> 16 & 0x3f), motor >> 8 & 255, motor & 255,
                         0x80 | (joint >> 16 & 0x3f), joint >> 8 & 255, joint & 255});
    (void)node_->send(f);
    return;
  }
  if (p == kTact) return answer_tactile(puck);
  std::int32_t v = puck.property[static_cast<std::size_t>(p)];
  if (p == 5) v = puck.stat;
  if (p == 63 && puck.powered_at)
    v = static_cast<std::int32_t>(hal::seconds(clock.now() - *puck.powered_at)) & 0x7fff;
  if (p == 25)
    v = static_cast<std::int32_t>(
        gauge_counts(puck.feels ? std::min(puck.load_nm * puck.load_share, 1.3) : 0.0));
  hal::CanFrame f = frame(to | 6, {0x80 | p, 0, v & 255, v >> 8 & 255});
  if (is_wide(p)) f = frame(to | 6, {0x80 | p, 0, v & 255, v >> 8 & 255, v >> 16 & 255, v >> 24 & 255});
  (void)node_->send(f);
}

void FakeHand::answer_tactile(const FakePuck& puck) {
  const int cell = puck.feels ? static_cast<int>(std::min(puck.load_nm * puck.load_share, 1.3) * 512.0) : 0;
  if (puck.property[kTact] == 1) {
    const int v = std::min(cell / 256, 15), two = v << 4 | v;
    (void)node_->send(frame(0x400 | puck.id << 5 | 8, {0, 0x03, 0xff, two, two, two, two, two}));
  }
  if (puck.property[kTact] != 2) return;
  const int high = cell >> 4, low = cell & 15;
  for (int row = 0; row < 5; ++row)  // every cell of a pad under the same pressure
    (void)node_->send(
        frame(0x400 | puck.id << 5 | 9, {row << 4 | cell >> 8, cell & 255, high, low << 4 | cell >> 8,
                                         cell & 255, high, low << 4 | cell >> 8, cell & 255}));
}

int FakeHand::sets(std::size_t puck, int property, std::size_t from) const {
  return static_cast<int>(std::count_if(
      from_host.begin() + static_cast<std::ptrdiff_t>(from), from_host.end(), [&](const hal::CanFrame& f) {
        return f.length > 1 && f.id == 11 + puck && f.data[0] == (0x80 | property);
      }));
}

}  // namespace colift
