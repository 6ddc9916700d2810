// Values handed from one thread to another: the latest one, and all of them in order.

#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <optional>
#include <thread>

#include "hal/types/spsc_ring.hpp"
#include "hal/types/triple_buffer.hpp"

using namespace colift;

namespace {

/// Torn when its parts disagree.
struct Whole {
  std::array<std::uint64_t, 32> parts{};
  Whole() = default;
  explicit Whole(std::uint64_t x) { parts.fill(x); }
  [[nodiscard]] bool torn() const {
    for (const std::uint64_t p : parts)
      if (p != parts[0]) return true;
    return false;
  }
};

}  // namespace

TEST_CASE("The latest value is read once, and older ones are never seen") {
  hal::TripleBuffer<int> slot;
  int got = -1;
  CHECK_FALSE(slot.read(got));
  slot.write(1);
  slot.write(2);
  REQUIRE(slot.read(got));
  CHECK(got == 2);
  CHECK_FALSE(slot.read(got));
  slot.write(3);
  REQUIRE(slot.read(got));
  CHECK(got == 3);
}

TEST_CASE("A value is never torn, and never goes backwards") {
  constexpr std::uint64_t kLast = 300'000;
  hal::TripleBuffer<Whole> slot;
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= kLast; ++i) slot.write(Whole(i));
  });
  Whole got;
  std::uint64_t before = 0;
  bool torn = false, backwards = false;
  while (before != kLast) {
    if (!slot.read(got)) continue;
    torn = torn || got.torn();
    backwards = backwards || got.parts[0] <= before;
    before = got.parts[0];
  }
  writer.join();
  CHECK_FALSE(torn);
  CHECK_FALSE(backwards);
}

TEST_CASE("A ring keeps the order, and says when it is full") {
  hal::SpscRing<int, 4> ring;
  CHECK_FALSE(ring.pop());
  for (int i = 0; i < 4; ++i) CHECK(ring.push(i));
  CHECK_FALSE(ring.push(4));
  CHECK(ring.refused() == 1);
  for (int i = 0; i < 4; ++i) CHECK(ring.pop() == i);
  CHECK_FALSE(ring.pop());
}

TEST_CASE("Through a small ring everything arrives, once and in order") {
  constexpr std::uint64_t kLast = 200'000;
  hal::SpscRing<Whole, 8> ring;
  std::thread producer([&] {
    for (std::uint64_t i = 1; i <= kLast; ++i)
      while (!ring.push(Whole(i))) std::this_thread::yield();
  });
  std::uint64_t wrong = 0;
  for (std::uint64_t i = 1; i <= kLast; ++i) {
    std::optional<Whole> got;
    while (!(got = ring.pop())) std::this_thread::yield();
    if (got->torn() || got->parts[0] != i) ++wrong;
  }
  producer.join();
  CHECK(wrong == 0);
}
