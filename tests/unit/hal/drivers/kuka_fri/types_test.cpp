#include <catch2/catch.hpp>
#include <thread>

#include "hal/drivers/kuka_fri/wire/answer_times.hpp"
#include "hal/drivers/kuka_fri/wire/packet_clock.hpp"
#include "hal/types/latest_value.hpp"
#include "hal/types/spsc_ring.hpp"

namespace colift::hal {
namespace {

struct Big {
  std::array<std::uint64_t, 100> words{};
};

}  // namespace

TEST_CASE("the latest value is the last one written", "[types]") {
  LatestValue<Big> slot;
  CHECK(slot.count() == 0);
  CHECK(slot.read().words[99] == 0);
  Big b;
  b.words.fill(7);
  slot.write(b);
  CHECK(slot.count() == 1);
  CHECK(slot.read().words == b.words);
}

TEST_CASE("a reader never sees half a value", "[types]") {
  LatestValue<Big> slot;
  constexpr std::uint64_t kWrites = 20000;
  std::atomic<int> mixed{0};
  std::thread reader([&] {
    for (std::uint64_t last = 0; last < kWrites;) {
      const Big b = slot.read();
      for (const auto w : b.words) mixed += w != b.words[0];
      if (b.words[0] < last) ++mixed;
      last = b.words[0];
    }
  });
  for (std::uint64_t i = 1; i <= kWrites; ++i) {
    Big b;
    b.words.fill(i);
    slot.write(b);
  }
  reader.join();
  CHECK(mixed == 0);
}

TEST_CASE("a full ring refuses and counts, an empty one gives nothing", "[types]") {
  SpscRing<int, 4> ring;
  CHECK_FALSE(ring.pop());
  for (int i = 0; i < 4; ++i) CHECK(ring.push(i));
  CHECK_FALSE(ring.push(4));
  CHECK(ring.refused() == 1);
  for (int i = 0; i < 4; ++i) CHECK(ring.pop() == i);
  CHECK_FALSE(ring.pop());
}

TEST_CASE("a ring hands everything over in order, between two threads", "[types]") {
  SpscRing<std::uint32_t, 64> ring;
  constexpr std::uint32_t kValues = 50000;
  std::thread writer([&] {
    for (std::uint32_t i = 0; i < kValues;)
      if (ring.push(i))
        ++i;
      else
        std::this_thread::yield();
  });
  std::uint32_t wrong = 0;
  for (std::uint32_t i = 0; i < kValues;) {
    const auto value = ring.pop();
    if (!value) {
      std::this_thread::yield();
      continue;
    }
    wrong += *value != i;
    ++i;
  }
  writer.join();
  CHECK(wrong == 0);
}

TEST_CASE("answer times fall into the bucket that holds them", "[types]") {
  AnswerTimes times;
  CHECK(times.percentile_us(0.99) == 0);
  for (int i = 1; i <= 1000; ++i) times.add(std::chrono::microseconds(i));
  times.add(std::chrono::milliseconds(3));
  CHECK(times.count() == 1001);
  CHECK(times.worst_us() == 3000);
  CHECK(times.percentile_us(0.5) >= 500);
  CHECK(times.percentile_us(0.5) <= 640);
  CHECK(times.percentile_us(1.0) >= 3000);
  for (std::size_t i = 1; i < AnswerTimes::kBuckets; ++i)
    CHECK(AnswerTimes::upper_us(i) > AnswerTimes::upper_us(i - 1));
  times.add(std::chrono::hours(1));  // beyond all buckets: the last one
  CHECK(times.in_bucket(AnswerTimes::kBuckets - 1) == 1);
}

TEST_CASE("the first answers that took too long are kept with their times", "[types]") {
  AnswerTimes times;
  const int many = static_cast<int>(AnswerTimes::kSlow) + 10;
  for (int i = 0; i < many; ++i) times.note_slow(std::chrono::seconds(i), std::chrono::seconds(i + 1));
  REQUIRE(times.slow() == AnswerTimes::kSlow);
  CHECK(times.slow(3).arrived == std::chrono::seconds(3));
  CHECK(times.slow(3).answered == std::chrono::seconds(4));
  times.reset();
  CHECK(times.slow() == 0);
}

TEST_CASE("the packets' clock keeps out jitter and follows a drift", "[types]") {
  PacketClock clock;
  const double drift = GENERATE(0.0, 50e-6, -50e-6);
  Timestamp last = clock.start(std::chrono::seconds(1));
  double arrival_s = 1.0, worst_step = 0.0;
  for (int i = 1; i <= 200000; ++i) {
    arrival_s = 1.0 + 0.002 * i * (1.0 + drift);
    const double jitter = (i * 7919 % 100) * 1e-5;  // 0 to 1 ms
    const Timestamp at =
        clock.advance(1, 0.002, Timestamp(static_cast<std::int64_t>((arrival_s + jitter) * 1e9)));
    worst_step = std::max(worst_step, std::abs(seconds(at - last) - 0.002));
    last = at;
  }
  CHECK(worst_step <= 0.21e-6);
  CHECK(std::abs(seconds(last) - arrival_s) < 0.0025);
}

}  // namespace colift::hal
