// What one datagram of FRI costs: the codec, and a whole cycle of the driver without its socket. Decoding is
// checked against the value that was encoded before anything is timed.
#include <benchmark/benchmark.h>

#include <array>
#include <cstdlib>
#include <memory>

#include "hal/drivers/kuka_fri/fri_arm.hpp"
#include "hal/drivers/kuka_fri/wire/fri_codec.hpp"

namespace {

using namespace colift::hal;

FriMeasurement sample() {
  FriMeasurement m;
  m.head.send = 1;
  m.state = FriState::Monitor;
  m.quality = FriQuality::Perfect;
  m.control = FriControl::JointImpedance;
  m.power = kFriAllDrives;
  m.measurement_period_s = m.command_period_s = 0.002f;
  m.safety_limits = 1.0f;
  for (std::size_t i = 0; i < 7; ++i)
    m.q_measured_rad[i] = m.q_commanded_rad[i] = 0.1f * static_cast<float>(i);
  for (std::size_t i = 0; i < 49; ++i) m.mass_matrix[i] = 0.01f * static_cast<float>(i);
  return m;
}

void decode_measurement(benchmark::State& state) {
  std::array<std::byte, kFriMeasurementBytes> bytes{};
  const FriMeasurement m = sample();
  encode(m, bytes);
  FriMeasurement out;
  if (decode(bytes, out) != FriRefusal::None || !(out == m)) std::abort();
  for (auto _ : state) {
    benchmark::DoNotOptimize(bytes.data());
    benchmark::DoNotOptimize(decode(bytes, out));
    benchmark::ClobberMemory();
  }
}
BENCHMARK(decode_measurement);

void encode_measurement(benchmark::State& state) {
  std::array<std::byte, kFriMeasurementBytes> bytes{};
  const FriMeasurement m = sample();
  for (auto _ : state) {
    encode(m, bytes);
    benchmark::ClobberMemory();
  }
}
BENCHMARK(encode_measurement);

void encode_command(benchmark::State& state) {
  std::array<std::byte, kFriCommandBytes> bytes{};
  FriCommand c, out;
  c.flags = fri_flag::kJointImpedance;
  encode(c, bytes);
  if (decode(bytes, out) != FriRefusal::None || !(out == c)) std::abort();
  for (auto _ : state) {
    encode(c, bytes);
    benchmark::ClobberMemory();
  }
}
BENCHMARK(encode_command);

void decode_command(benchmark::State& state) {
  std::array<std::byte, kFriCommandBytes> bytes{};
  FriCommand out;
  encode(FriCommand{}, bytes);
  for (auto _ : state) {
    benchmark::DoNotOptimize(decode(bytes, out));
    benchmark::ClobberMemory();
  }
}
BENCHMARK(decode_command);

/// Gives the same datagram with the next counter, and swallows the answers.
class Source final : public DatagramLink {
 public:
  explicit Source(ManualClock& clock) : clock_(clock) {}
  Result<> open() override { return {}; }
  void close() noexcept override {}
  Datagram receive(std::span<std::byte> into, Duration timeout) noexcept override {
    Datagram got;
    got.arrived_at = clock_.now();
    if (timeout == Duration::zero()) return got;
    clock_.advance(std::chrono::milliseconds(2));
    ++m_.head.send;
    if (++ticks_ > 50) m_.state = FriState::Command;
    encode(m_, into.first<kFriMeasurementBytes>());
    got.kind = Datagram::Kind::Data;
    got.size = kFriMeasurementBytes;
    got.from = {1, 1};
    return got;
  }
  bool send(const Endpoint&, std::span<const std::byte>) noexcept override {
    m_.head.reflected = static_cast<std::uint16_t>(m_.head.reflected + 1);
    return true;
  }

 private:
  ManualClock& clock_;
  FriMeasurement m_ = sample();
  int ticks_ = 0;
};

void cycle_of_the_driver(benchmark::State& state) {
  ManualClock clock;
  FriConfig config;
  config.script = "none";
  FriArm arm(config, std::make_unique<Source>(clock), clock);
  if (!arm.configure() || !arm.activate()) std::abort();
  ImpedanceCommand c;
  for (auto _ : state) {
    const auto s = arm.wait_cycle();
    if (!s) std::abort();
    c.q_rad = s->q_rad;
    benchmark::DoNotOptimize(arm.command(c));
  }
  if (!arm.status().may_command) std::abort();
}
BENCHMARK(cycle_of_the_driver);

}  // namespace

BENCHMARK_MAIN();
