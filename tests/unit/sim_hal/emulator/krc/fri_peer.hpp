#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim_hal/emulator/krc/krc_lock_step.hpp"
#include "sim_hal/emulator/krc/plant/krc_light_plant.hpp"

namespace colift::test {

using std::chrono::microseconds;
using std::chrono::milliseconds;

// A client that knows nothing but offsets: what the emulator sends is read from the bytes.

template <class T>
T at(std::span<const std::byte> bytes, std::size_t offset) {
  static_assert(std::endian::native == std::endian::little);
  T v;
  std::memcpy(&v, bytes.data() + offset, sizeof v);
  return v;
}

template <class T>
void set(std::span<std::byte> bytes, std::size_t offset, T v) {
  std::memcpy(bytes.data() + offset, &v, sizeof v);
}

struct Seen {
  std::vector<std::byte> bytes;
  template <class T>
  [[nodiscard]] T get(std::size_t offset) const {
    return at<T>(bytes, offset);
  }
  [[nodiscard]] std::uint16_t send() const { return get<std::uint16_t>(0); }
  [[nodiscard]] std::uint16_t reflected() const { return get<std::uint16_t>(2); }
  [[nodiscard]] int state() const { return get<std::uint16_t>(144); }
  [[nodiscard]] int quality() const { return get<std::uint16_t>(146); }
  [[nodiscard]] int power() const { return get<std::uint16_t>(180); }
  [[nodiscard]] int control() const { return get<std::uint16_t>(182); }
  [[nodiscard]] std::int32_t to_int(int c) const { return get<std::int32_t>(72 + 4 * std::size_t(c)); }
  [[nodiscard]] hal::JointVector joints(std::size_t offset) const {
    hal::JointVector q;
    for (int i = 0; i < 7; ++i) q[i] = static_cast<double>(get<float>(offset + 4 * std::size_t(i)));
    return q;
  }
  [[nodiscard]] hal::JointVector q() const { return joints(216); }
  [[nodiscard]] hal::JointVector q_total() const { return joints(292) + joints(320); }
};

/// A client on a wire in memory, with the emulator on its other end and a clock for both.
struct Bench {
  static constexpr hal::Endpoint kClient{0x7F000001, 49938}, kKrc{0x7F000001, 50000};

  explicit Bench(sim_hal::KrcConfig config = stanford(), sim_hal::LightPlantConfig plant_config = bent())
      : dynamics(hal::built_in_robot(), hal::ArmDynamics::Load::Hand), plant(dynamics, plant_config) {
    krc_end = wire.end(kKrc);
    krc = std::make_unique<sim_hal::KrcEmulator>(
        std::move(config), dynamics, plant, *krc_end,
        [this](double, const std::string& text) { told.push_back(text); });
    client = wire.end(kClient, sim_hal::lock_step(*krc, clock));
    (void)krc_end->open();
    (void)client->open();
  }

  static sim_hal::KrcConfig stanford() {
    sim_hal::KrcConfig c;
    c.script = "stanford";
    return c;
  }
  static sim_hal::LightPlantConfig bent() {
    sim_hal::LightPlantConfig p;
    p.start_rad << 0.1, 0.35, -0.2, 1.4, 0.1, -0.9, 0.3;
    return p;
  }

  /// The next measurement; none within `timeout`: unset.
  std::optional<Seen> receive(hal::Duration timeout = milliseconds(250)) {
    std::array<std::byte, 2000> buffer;
    const hal::Datagram got = client->receive(buffer, timeout);
    if (got.kind != hal::Datagram::Kind::Data) return std::nullopt;
    return Seen{{buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(got.size)}};
  }

  /// An answer that mirrors, as `change` changes it.
  std::vector<std::byte> answer(const Seen& m) {
    std::vector<std::byte> c(376);
    set<std::uint16_t>(c, 0, ++send);
    set<std::uint16_t>(c, 2, m.send());
    set<std::uint16_t>(c, 4, 376);
    set<std::uint16_t>(c, 6, 0x1005);
    for (std::size_t i = 0; i < 16; ++i) set<std::int32_t>(c, 72 + 4 * i, from_int[i]);
    set<std::uint16_t>(c, 136, from_bool);
    set<std::uint32_t>(c, 140, flags);
    const hal::JointVector total = q ? *q : m.q_total();
    for (std::size_t i = 0; i < 7; ++i) {
      set<float>(c, 144 + 4 * i, static_cast<float>(total[static_cast<int>(i)]));
      set<float>(c, 272 + 4 * i, 1000.0f);
      set<float>(c, 300 + 4 * i, 0.7f);
    }
    for (std::size_t i = 0; i < 12; ++i) set<float>(c, 172 + 4 * i, m.get<float>(244 + 4 * i));
    for (std::size_t i = 0; i < 6; ++i) {
      set<float>(c, 328 + 4 * i, i < 3 ? 2000.0f : 200.0f);
      set<float>(c, 352 + 4 * i, 0.7f);
    }
    if (change) change(c);
    return c;
  }

  void reply(const std::vector<std::byte>& bytes) { client->send(kKrc, bytes); }

  /// Receives and answers 0.2 ms later; unset when nothing came.
  std::optional<Seen> turn() {
    auto m = receive();
    if (!m) return m;
    sim_hal::run_until(*krc, clock, clock.now() + microseconds(200));
    reply(answer(*m));
    krc->poll(clock.now());
    last = *m;
    return m;
  }
  void turns(int n) {
    for (int i = 0; i < n; ++i) turn();
  }
  /// Answers until `done`, no longer than `most` cycles.
  template <class Done>
  bool until(Done done, int most = 2000) {
    for (int i = 0; i < most; ++i) {
      const auto m = turn();
      if (m && done(*m)) return true;
    }
    return false;
  }
  /// Lets cycles pass without an answer.
  void say_nothing(int n) {
    for (int i = 0; i < n; ++i)
      if (auto m = receive()) last = *m;
  }

  /// By Stanford's hand-shake into command mode.
  bool command(std::int32_t strategy = 30, std::uint32_t with_flags = 0x35) {
    flags = with_flags;
    from_int[14] = strategy;
    from_int[15] = 10;
    return until([](const Seen& m) { return m.state() == 2 && m.power() != 0; });
  }

  [[nodiscard]] bool was_told(const std::string& part) const {
    for (const std::string& text : told)
      if (text.find(part) != std::string::npos) return true;
    return false;
  }
  /// The rules that were broken, empty for none.
  [[nodiscard]] std::string broken() const {
    std::string all;
    for (const auto& b : krc->report().broken_rules) {
      if (!all.empty()) all += ' ';
      all += name(b.rule);
    }
    return all;
  }

  hal::ManualClock clock;
  sim_hal::MemoryWire wire{clock};
  hal::ArmDynamics dynamics;
  sim_hal::LightPlant plant;
  std::unique_ptr<hal::DatagramLink> krc_end, client;
  std::unique_ptr<sim_hal::KrcEmulator> krc;
  std::vector<std::string> told;

  // what the client says
  std::uint16_t send = 0;
  std::array<std::int32_t, 16> from_int{};
  std::uint16_t from_bool = 0;
  std::uint32_t flags = 0x35;
  std::optional<hal::JointVector> q;
  std::function<void(std::vector<std::byte>&)> change;
  Seen last;
};

}  // namespace colift::test
