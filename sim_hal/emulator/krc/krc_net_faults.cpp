#include "sim_hal/emulator/krc/krc_net_faults.hpp"

#include <algorithm>
#include <cmath>

#include "sim_hal/synthetic/hash_random.hpp"

namespace colift::sim_hal {
namespace {

using Kind = KrcFault::Kind;

}  // namespace

KrcBadWire::KrcBadWire(const std::vector<KrcFault>& faults, KrcFault::Direction way, std::uint64_t seed,
                       Out out)
    : path_(way), seed_(hash(seed, static_cast<std::uint64_t>(way), 0)), out_(std::move(out)) {
  for (const KrcFault& f : faults) add(f);
}

void KrcBadWire::add(const KrcFault& fault) {
  if (fault.on_wire() && (fault.way == path_ || fault.way == KrcFault::Direction::Both))
    faults_.push_back({fault, 0, {}});
}

bool KrcBadWire::suffers(const Active& a, double t_s) const {
  if (a.fault.counted) return t_s >= a.fault.at_s && a.count < static_cast<std::uint64_t>(a.fault.value);
  return a.fault.active(t_s);
}

void KrcBadWire::spoil(std::vector<std::byte>& bytes, std::uint64_t stream) const {
  if (bytes.empty()) return;
  const auto draw = [&](std::uint64_t n) { return hash(seed_ + 1, stream, n); };
  if (unit(draw(0)) < 0.25) {
    bytes.resize(draw(1) % bytes.size());
    return;
  }
  std::byte& b = bytes[draw(2) % bytes.size()];
  b ^= static_cast<std::byte>(1U << (draw(3) % 8));
}

void KrcBadWire::release(Active& a, hal::Timestamp now) {
  for (const Letter& letter : a.held) out_(letter.bytes, letter.peer, now);
  a.held.clear();
}

void KrcBadWire::pass(std::span<const std::byte> bytes, const hal::Endpoint& peer, double t_s,
                      hal::Timestamp now) {
  flush(t_s, now);
  const std::uint64_t n = passed_++;
  std::vector<std::byte> copy;
  const auto now_bytes = [&] { return copy.empty() ? bytes : std::span<const std::byte>(copy); };
  bool twice = false;
  for (std::size_t i = 0; i < faults_.size(); ++i) {
    Active& a = faults_[i];
    if (!suffers(a, t_s)) continue;
    ++a.count;
    const bool hit = !a.fault.percent || 100.0 * unit(hash(seed_, i, n)) < a.fault.value;
    switch (a.fault.kind) {
      case Kind::Loss:
        if (hit) return;
        break;
      case Kind::Corrupt:
        if (!hit) break;
        copy.assign(bytes.begin(), bytes.end());
        spoil(copy, n);
        // a datagram without a byte is one, too
        if (copy.empty()) return out_({}, peer, now);
        break;
      case Kind::Duplicate:
        twice = true;
        break;
      case Kind::Delay: {
        const auto later = std::chrono::nanoseconds(std::llround(1e6 * a.fault.value));
        const auto all = now_bytes();
        delayed_.push_back({{all.begin(), all.end()}, peer, now + later});
        return;
      }
      case Kind::Reorder:
      case Kind::Burst: {
        const std::size_t hold = a.fault.kind == Kind::Reorder ? 2 : static_cast<std::size_t>(a.fault.value);
        const auto all = now_bytes();
        a.held.push_back({{all.begin(), all.end()}, peer, now});
        if (a.held.size() < hold) return;
        if (a.fault.kind == Kind::Reorder) std::reverse(a.held.begin(), a.held.end());
        release(a, now);
        return;
      }
      default:
        break;
    }
  }
  out_(now_bytes(), peer, now);
  if (twice) out_(now_bytes(), peer, now);
}

void KrcBadWire::flush(double t_s, hal::Timestamp now) {
  for (Active& a : faults_)
    if (!a.held.empty() && !suffers(a, t_s)) release(a, now);
  std::vector<Letter> due;
  for (std::size_t i = 0; i < delayed_.size();) {
    if (delayed_[i].due <= now) {
      due.push_back(std::move(delayed_[i]));
      delayed_.erase(delayed_.begin() + static_cast<std::ptrdiff_t>(i));
    } else {
      ++i;
    }
  }
  for (const Letter& letter : due) out_(letter.bytes, letter.peer, letter.due);
}

std::optional<hal::Timestamp> KrcBadWire::next_due() const {
  std::optional<hal::Timestamp> next;
  for (const Letter& letter : delayed_)
    if (!next || letter.due < *next) next = letter.due;
  return next;
}

void KrcBadWire::clear() {
  delayed_.clear();
  for (Active& a : faults_) a.held.clear();
}

void KrcBadWire::mend() {
  clear();
  faults_.clear();
}

}  // namespace colift::sim_hal
