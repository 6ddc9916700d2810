// After warm-up a cycle asks the heap for nothing, also when datagrams are lost, doubled, corrupt or refused.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <new>

#include "hal/drivers/kuka_fri/fri_arm.hpp"
#include "hal/drivers/kuka_fri/wire/fri_codec.hpp"

namespace {

thread_local bool armed = false;
std::atomic<int> taken{0};

[[maybe_unused]] void note() {
  if (armed) ++taken;
}

}  // namespace

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
// glibc's own names of what stands behind malloc
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* malloc(std::size_t size) {
  note();
  return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) {
  note();
  return __libc_calloc(n, size);
}
void* realloc(void* p, std::size_t size) {
  note();
  return __libc_realloc(p, size);
}
}
constexpr bool kCounts = true;
#else
constexpr bool kCounts = false;
#endif

namespace colift::hal {
namespace {

/// A controller that takes no memory: one datagram for each wait, some of them bad.
class CannedLink final : public DatagramLink {
 public:
  explicit CannedLink(ManualClock& clock) : clock_(clock) {
    m_.state = FriState::Monitor;
    m_.quality = FriQuality::Perfect;
    m_.control = FriControl::JointImpedance;
    m_.power = kFriAllDrives;
    m_.measurement_period_s = m_.command_period_s = 0.002f;
    m_.safety_limits = 1.0f;
  }
  Result<> open() override { return {}; }
  void close() noexcept override {}

  Datagram receive(std::span<std::byte> into, Duration timeout) noexcept override {
    Datagram got;
    got.arrived_at = clock_.now();
    if (again_ > 0) {
      --again_;
      return put(into, got);
    }
    if (timeout == Duration::zero()) return got;
    clock_.advance(std::chrono::milliseconds(2));
    got.arrived_at = clock_.now();
    ++tick_;
    ++m_.head.send;
    if (tick_ > 100) m_.state = FriState::Command;
    if (bad && (tick_ % 97 == 0 || (tick_ / 8) % 113 == 0)) return got;  // one lost, eight in a row lost
    if (bad && tick_ % 31 == 0) again_ = 1;                              // doubled
    m_.q_measured_rad[2] = bad && tick_ % 4001 == 0 ? 1.0f : m_.q_commanded_fri_rad[2];
    put(into, got);
    if (bad && tick_ % 53 == 0) into[230] = std::byte{0xFF}, into[231] = std::byte{0x7F};  // NaN
    return got;
  }
  bool send(const Endpoint&, std::span<const std::byte> bytes) noexcept override {
    FriCommand c;
    if (decode(bytes, c) == FriRefusal::None && m_.state == FriState::Command)
      m_.q_commanded_fri_rad = c.q_rad;
    m_.head.reflected = c.head.send;
    ++answers;
    return true;
  }

  bool bad = false;
  int answers = 0;

 private:
  Datagram put(std::span<std::byte> into, Datagram& got) {
    encode(m_, into.first<kFriMeasurementBytes>());
    got.kind = Datagram::Kind::Data;
    got.size = kFriMeasurementBytes;
    got.from = {0x7F000001, 1234};
    return got;
  }
  ManualClock& clock_;
  FriMeasurement m_;
  int tick_ = 0, again_ = 0;
};

}  // namespace

TEST_CASE("ten thousand cycles with losses, garbage and refused commands allocate nothing",
          "[fri][realtime]") {
  ManualClock clock;
  clock.advance(std::chrono::seconds(1));
  auto owned = std::make_unique<CannedLink>(clock);
  CannedLink& link = *owned;
  FriConfig config;
  config.script = "none";
  config.silent_s = 5.0;
  FriArm arm(config, std::move(owned), clock);
  REQUIRE(arm.configure());
  REQUIRE(arm.activate());
  ImpedanceCommand c;
  int states = 0, errors = 0, refused = 0, allowed = 0;
  const auto cycles = [&](int n) {
    for (int i = 0; i < n; ++i) {
      const auto s = arm.wait_cycle();
      if (!s) {
        ++errors;
        continue;
      }
      ++states;
      allowed += s->may_command;
      c.q_rad = s->q_commanded_rad;
      if (i % 17 == 0) c.q_rad[0] += 1.0;
      refused += !arm.command(c);
      if (i % 211 == 0) c.stiffness_nm_rad[1] = 5000.0;
      if (i % 211 == 9) c.stiffness_nm_rad[1] = 1000.0;
    }
  };
  cycles(100);
  link.bad = true;
  armed = true;
  const int before = taken;
  cycles(10000);
  const int after = taken;
  armed = false;
  CHECK(after == before);
  CHECK(states > 8000);
  CHECK(errors > 100);
  CHECK(refused > 500);
  CHECK(allowed > 1000);

  // the interposer does see allocations
  if (kCounts) {
    armed = true;
    const std::string text(100, 'x');
    armed = false;
    CHECK(taken > after);
    CHECK(text.size() == 100);
  }
}

}  // namespace colift::hal
