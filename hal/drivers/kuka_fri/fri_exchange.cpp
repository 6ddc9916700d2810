#include "hal/drivers/kuka_fri/fri_exchange.hpp"

#include <algorithm>

namespace colift::hal {
namespace {

constexpr int kMostDatagrams = 512;  // looked at in one cycle: a flood must not hold the cycle up
constexpr int kMostUnheard = 5;

}  // namespace

void FriExchange::reset() noexcept {
  gate_.reset();
  times_.reset();
  last_refusal_ = FriRefusal::None;
  received = answered = late = unsent = lost = 0;
}

FriExchange::Got FriExchange::receive(Timestamp until, double period_s, FriMeasurement& m,
                                      Packet& packet) noexcept {
  bool have = false;
  packet = Packet{0, false, false, Timestamp{0}};
  for (int i = 0; i < kMostDatagrams; ++i) {
    const Duration left = have ? Duration::zero() : std::max(until - clock_.now(), Duration::zero());
    const Datagram got = link_->receive(in_, left);
    if (got.kind == Datagram::Kind::Broken) return have ? Got::Packet : Got::Broken;
    if (got.kind == Datagram::Kind::None) break;
    const PacketGate::Passed passed = gate_.look(got, in_, period_s, m);
    if (passed.refusal != FriRefusal::None) last_refusal_ = passed.refusal;
    if (passed.drop != FriDrop::None) continue;
    if (have) gate_.count(FriDrop::Superseded);
    have = true;
    ++received;
    lost += static_cast<std::uint64_t>(passed.cycles - 1);
    packet.cycles += passed.cycles;
    packet.first |= passed.first;
    packet.restarted |= passed.restarted;
    packet.arrived_at = got.arrived_at;
    reflect_ = m.head.send;
    to_ = got.from;
  }
  if (!have) return Got::Nothing;
  arrived_at_ = packet.arrived_at;
  period_s_ = period_s;
  return Got::Packet;
}

bool FriExchange::answer(FriCommand& command) noexcept {
  command.head = {static_cast<std::uint16_t>(send_ + 1), reflect_, kFriCommandBytes, kFriCommandId};
  encode(command, out_);
  if (!link_->send(to_, out_)) {
    ++unsent;
    return false;
  }
  ++send_;
  ++answered;
  const Timestamp now = clock_.now();
  const Duration took = now - arrived_at_;
  times_.add(took);
  if (seconds(took) > period_s_) {
    ++late;
    times_.note_slow(arrived_at_, now);
  }
  return true;
}

int FriExchange::unheard(const FriMeasurement& m) const noexcept {
  const auto behind = static_cast<std::uint16_t>(send_ - m.head.reflected);
  return behind <= kMostUnheard ? behind : 0;
}

}  // namespace colift::hal
