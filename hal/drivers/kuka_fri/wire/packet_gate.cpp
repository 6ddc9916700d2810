#include "hal/drivers/kuka_fri/wire/packet_gate.hpp"

#include <algorithm>

namespace colift::hal {
namespace {

constexpr double kAnew_s = 0.1;   // without a datagram in order: then another count is believed
constexpr int kAnewInLine = 5;    // of that count, one after the other
constexpr double kAhead_s = 0.1;  // what a counter may be ahead of the time that passed
constexpr int kNear = 50;         // and as far as this it may in any case: simulated time runs faster

}  // namespace

std::string_view to_string(FriDrop drop) noexcept {
  switch (drop) {
    case FriDrop::None:
      return "none";
    case FriDrop::Sender:
      return "foreign sender";
    case FriDrop::Size:
      return "wrong size";
    case FriDrop::Header:
      return "wrong header";
    case FriDrop::Content:
      return "corrupt content";
    case FriDrop::Doubled:
      return "doubled";
    case FriDrop::Old:
      return "out of order";
    case FriDrop::Ahead:
      return "counter ahead of time";
    case FriDrop::Superseded:
      return "superseded by a newer one";
  }
  return "unknown";
}

bool PacketGate::allowed(const Endpoint& from) const {
  return (krc_.address == 0 || from.address == krc_.address) && (krc_.port == 0 || from.port == krc_.port);
}

bool PacketGate::foreign(const Endpoint& from) const {
  if (!allowed(from)) return true;
  if (!sender_) return false;
  return from.address != sender_->address || (sender_->port != 0 && from.port != sender_->port);
}

void PacketGate::note_rival(const Datagram& got) {
  if (got.size != kFriMeasurementBytes || !allowed(got.from)) return;
  if (!rival_ || rival_->who != got.from) rival_ = Rival{got.from, Timestamp{0}, 0};
  rival_->at = got.arrived_at;
  ++rival_->datagrams;
}

void PacketGate::unlock() noexcept {
  if (sender_) sender_->port = 0;
  last_.reset();
  in_line_ = 0;
}

int PacketGate::counter_set_by() const noexcept {
  if (!last_ || in_line_ < kAnewInLine) return 0;
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(out_of_line_ - in_line_ - *last_));
}

FriDrop PacketGate::order(std::uint16_t send, Timestamp at, double period_s, Passed& passed) {
  passed.first = !last_;
  if (!check_sequence_) return FriDrop::None;
  if (last_) {
    const int ahead = static_cast<std::int16_t>(static_cast<std::uint16_t>(send - *last_));
    // whoever was not listening for a while finds old datagrams first: what counts is the time of all of them
    const double since_s = seconds(at - first_at_);
    const bool too_far = ahead > kNear && counted_s_ + ahead * period_s > since_s + kAhead_s;
    if (ahead > 0 && !too_far) {
      passed.cycles = ahead;
      counted_s_ = std::min(counted_s_ + ahead * period_s, since_s);
    } else {
      in_line_ = in_line_ > 0 && send == static_cast<std::uint16_t>(out_of_line_ + 1) ? in_line_ + 1 : 1;
      out_of_line_ = send;
      if (in_line_ < kAnewInLine || seconds(at - last_at_) < kAnew_s)
        return ahead == 0 ? FriDrop::Doubled : ahead < 0 ? FriDrop::Old : FriDrop::Ahead;
      passed.restarted = true;
    }
  }
  if (passed.first || passed.restarted) {
    first_at_ = at;
    counted_s_ = 0.0;
  }
  in_line_ = 0;
  return FriDrop::None;
}

PacketGate::Passed PacketGate::look(const Datagram& got, std::span<const std::byte> bytes, double period_s,
                                    FriMeasurement& out) noexcept {
  Passed passed;
  if (foreign(got.from)) {
    passed.drop = FriDrop::Sender;
    note_rival(got);
  } else if (got.size != kFriMeasurementBytes) {
    passed.drop = FriDrop::Size;
    passed.refusal = FriRefusal::Size;
  } else {
    FriMeasurement m;
    passed.refusal = decode(bytes.first(std::min(bytes.size(), got.size)), m, checks_);
    if (passed.refusal == FriRefusal::HeaderId || passed.refusal == FriRefusal::HeaderSize)
      passed.drop = FriDrop::Header;
    else if (passed.refusal != FriRefusal::None)
      passed.drop = FriDrop::Content;
    else
      passed.drop = order(m.head.send, got.arrived_at, period_s, passed);
    if (passed.drop == FriDrop::None) {
      sender_ = got.from;
      if (rival_ && rival_->who == got.from) rival_.reset();
      last_ = m.head.send;
      last_at_ = got.arrived_at;
      out = m;
      return passed;
    }
  }
  count(passed.drop);
  return passed;
}

}  // namespace colift::hal
