// Any bytes as a datagram of FRI: decoded or refused, what was decoded encodes to the same bytes, and the
// gate and the session live through any order of them.

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>

#include "hal/drivers/kuka_fri/session.hpp"
#include "hal/drivers/kuka_fri/wire/packet_gate.hpp"

using namespace colift::hal;

namespace {

template <class Packet, std::size_t kBytes>
void there_and_back(std::span<const std::byte> bytes) {
  Packet p;
  if (decode(bytes, p, {false, false}) != FriRefusal::None) return;
  std::array<std::byte, kBytes> again{};
  encode(p, again);
  if (!std::equal(again.begin(), again.end(), bytes.begin(), bytes.end())) std::abort();
  Packet checked;
  if (decode(bytes, checked) == FriRefusal::None && implausible(checked) != FriRefusal::None) std::abort();
}

/// The input as a string of datagrams: a byte each for sender and length, then what there is.
void as_traffic(std::span<const std::byte> bytes) {
  PacketGate gate({}, {}, true);
  SessionMachine session({});
  FriMeasurement m;
  Timestamp now{1'000'000'000};
  bool asked = false;
  for (int i = 0; i < 100 && bytes.size() > 3; ++i) {
    const auto head = std::to_integer<unsigned>(bytes[0]);
    const auto wait = std::to_integer<unsigned>(bytes[1]);
    bytes = bytes.subspan(2);
    now += std::chrono::microseconds(200 * wait);
    std::array<std::byte, 2048> buffer{};
    const std::size_t size = head % 5 == 0 ? std::min<std::size_t>(bytes.size(), 900) : kFriMeasurementBytes;
    // a sound datagram with what there is laid over its data
    FriMeasurement base;
    base.state = FriState::Monitor;
    base.head.send = static_cast<std::uint16_t>(m.head.send + 1);
    encode(base, std::span(buffer).first<kFriMeasurementBytes>());
    const std::size_t some = std::min<std::size_t>({bytes.size(), head % 64 + 1, 64});
    const std::size_t at = head % 2 == 0 ? 0 : 140;
    std::copy_n(bytes.begin(), some, buffer.begin() + static_cast<std::ptrdiff_t>(at));
    bytes = bytes.subspan(some);
    const Endpoint from{0x7F000001, static_cast<std::uint16_t>(head % 7 == 0 ? 2 : 1)};
    const auto passed = gate.look({Datagram::Kind::Data, size, from, now}, buffer, 0.002, m);
    if (passed.drop != FriDrop::None) {
      session.silence(wait / 10.0, wait > 250, false);
      continue;
    }
    if (passed.cycles < 1) std::abort();
    session.measured(m, passed.cycles, 0.002, passed.restarted);
    session.sent(JointVector::Zero(), JointVector::Constant(1000.0), head % 3 != 0);
    if (head % 16 == 1) session.activate(), asked = true;
    if (head % 16 == 2) session.stop();
    if (head % 16 == 3) session.leave();
    if (head % 16 == 4) session.forget_requests();
    // nobody may command who did not ask, outside of command mode, or without drives
    if (session.may_command() && (!asked || SessionMachine::mirrors(m))) std::abort();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  there_and_back<FriMeasurement, kFriMeasurementBytes>(bytes);
  there_and_back<FriCommand, kFriCommandBytes>(bytes);
  as_traffic(bytes);
  return 0;
}
