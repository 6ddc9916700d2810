// Frames in shared memory, from a writer that may be stopped or broken at any byte.

#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstring>
#include <random>
#include <thread>

#include "hal/drivers/capture_link/frame_ring.hpp"

using namespace colift::hal;
using namespace colift::hal::capture;

namespace {

constexpr std::uint32_t kWidth = 640, kHeight = 480;
constexpr std::size_t kPixels = 640UL * 480;
constexpr RingShape kShape{2, 640 * 488};

FrameStamp stamp(std::uint32_t ticks) {
  FrameStamp s;
  s.ticks = ticks;
  s.width = kWidth;
  s.height = kHeight;
  return s;
}

struct Pair {
  FrameRing ring = FrameRing::make(kShape).value();
  FrameRingWriter writer = FrameRingWriter::map(ring.fd()).value();
};

}  // namespace

TEST_CASE("a frame that was written is read once, with everything that goes with it", "[capture]") {
  Pair p;
  RawFrame f;
  CHECK_FALSE(p.ring.read(Stream::Depth, f).value());
  std::vector<std::uint16_t> pixels(kPixels);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint16_t>(i);
  (void)p.writer.write(Stream::Depth, stamp(77), pixels.data());
  REQUIRE(p.ring.read(Stream::Depth, f).value());
  CHECK(f.pixels == pixels);
  CHECK(f.stamp.ticks == 77);
  CHECK(f.stamp.number == 1);
  CHECK_FALSE(p.ring.read(Stream::Depth, f).value());
  p.writer.beat();
  p.writer.set_state(CaptureState::Streaming);
  CHECK(p.ring.heartbeat() == 1);
  CHECK(p.ring.state() == CaptureState::Streaming);
}

TEST_CASE("who is slow gets the newest frame and knows how many he missed", "[capture]") {
  Pair p;
  RawFrame f;
  std::vector<std::uint16_t> pixels(kPixels, 700);
  (void)p.writer.write(Stream::Depth, stamp(1), pixels.data());
  REQUIRE(p.ring.read(Stream::Depth, f).value());
  for (std::uint32_t i = 2; i <= 12; ++i) (void)p.writer.write(Stream::Depth, stamp(i), pixels.data());
  REQUIRE(p.ring.read(Stream::Depth, f).value());
  CHECK(f.stamp.ticks == 12);
  CHECK(p.ring.missed(Stream::Depth) == 10);
}

TEST_CASE("a reader beside a writer never sees half of one frame and half of another", "[capture]") {
  Pair p;
  std::atomic<bool> stop{false};
  std::thread writer([&] {
    std::vector<std::uint16_t> pixels(kPixels);
    for (std::uint32_t n = 1; !stop; ++n) {
      std::fill(pixels.begin(), pixels.end(), static_cast<std::uint16_t>(n & 1023u));
      (void)p.writer.write(Stream::Depth, stamp(n & 1023u), pixels.data());
    }
  });
  RawFrame f;
  int read = 0, torn = 0;
  while (read < 200) {
    const auto got = p.ring.read(Stream::Depth, f);
    REQUIRE(got);
    if (!*got) continue;
    ++read;
    for (const std::uint16_t v : f.pixels) torn += v != f.stamp.ticks;
  }
  stop = true;
  writer.join();
  CHECK(torn == 0);
}

TEST_CASE("memory that holds anything at all is refused frame by frame, and never read beyond its end",
          "[capture]") {
  std::mt19937_64 random(11);
  for (int round = 0; round < 60; ++round) {
    Pair p;
    std::vector<std::uint16_t> pixels(kPixels, 900);
    (void)p.writer.write(Stream::Depth, stamp(1), pixels.data());
    auto* memory = static_cast<std::uint8_t*>(
        ::mmap(nullptr, ring_bytes(kShape), PROT_READ | PROT_WRITE, MAP_SHARED, p.ring.fd(), 0));
    REQUIRE(memory != MAP_FAILED);
    // the head and the head of some slot, or a single pixel
    for (int i = 0; i < 40; ++i) memory[8 + random() % 120] = static_cast<std::uint8_t>(random());
    for (int i = 0; i < 4; ++i)
      memory[random() % ring_bytes(kShape)] ^= static_cast<std::uint8_t>(1 + random() % 255);
    RawFrame f;
    for (int i = 0; i < 3; ++i) {
      const auto got = p.ring.read(Stream::Depth, f);
      if (got && *got) {
        CHECK(f.pixels.size() == kPixels);
        CHECK(f.pixels == pixels);
      }
      (void)p.ring.read(Stream::Infrared, f);
    }
    ::munmap(memory, ring_bytes(kShape));
  }
}

TEST_CASE("a frame with one wrong pixel, of another size or under another number is refused", "[capture]") {
  const auto spoil = GENERATE(0, 1, 2);
  Pair p;
  std::vector<std::uint16_t> pixels(kPixels, 900);
  FrameStamp s = stamp(1);
  (void)p.writer.write(Stream::Depth, s, pixels.data());
  auto* memory = static_cast<std::uint8_t*>(
      ::mmap(nullptr, ring_bytes(kShape), PROT_READ | PROT_WRITE, MAP_SHARED, p.ring.fd(), 0));
  REQUIRE(memory != MAP_FAILED);
  const std::size_t slot_bytes = (ring_bytes(kShape) - 4096) / (kShape.streams * kSlots);
  if (spoil == 1) memory[4096 + slot_bytes + 8 + offsetof(FrameStamp, width) + 3] = 1;
  if (spoil == 0) memory[4096 + slot_bytes + 8 + sizeof(FrameStamp) + 12345] ^= 1;
  if (spoil == 2) memory[4096 + slot_bytes + 8] ^= 4;
  RawFrame f;
  const auto got = p.ring.read(Stream::Depth, f);
  REQUIRE_FALSE(got);
  CHECK(got.error().code == ErrorCode::BadReply);
  CHECK_FALSE(p.ring.read(Stream::Depth, f).value());  // not again
  ::munmap(memory, ring_bytes(kShape));
}

TEST_CASE("a writer that dies while it writes leaves no frame behind", "[capture]") {
  Pair p;
  std::vector<std::uint16_t> pixels(kPixels, 900);
  (void)p.writer.write(Stream::Depth, stamp(1), pixels.data());
  auto* memory = static_cast<std::uint8_t*>(
      ::mmap(nullptr, ring_bytes(kShape), PROT_READ | PROT_WRITE, MAP_SHARED, p.ring.fd(), 0));
  const std::size_t slot_bytes = (ring_bytes(kShape) - 4096) / (kShape.streams * kSlots);
  const std::uint64_t writing = 1;  // the generation of frame 1 while it is written
  std::memcpy(memory + 4096 + slot_bytes, &writing, sizeof writing);
  RawFrame f;
  CHECK_FALSE(p.ring.read(Stream::Depth, f).value());
  ::munmap(memory, ring_bytes(kShape));
}

TEST_CASE("the memory cannot be cut short under the reader", "[capture]") {
  Pair p;
  CHECK(::ftruncate(p.ring.fd(), 4096) != 0);
  CHECK_FALSE(FrameRingWriter::map(STDIN_FILENO));
}

TEST_CASE("images of any size that fits come whole, others are not written", "[capture]") {
  FrameRing ring = FrameRing::make({1, 20}).value();
  FrameRingWriter writer = FrameRingWriter::map(ring.fd()).value();
  RawFrame f;
  const std::vector<std::uint16_t> pixels{1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11,
                                          12, 13, 14, 15, 16, 17, 18, 19, 20, 21};
  FrameStamp s;
  for (const auto& [width, height] : {std::pair{5U, 3U}, {20U, 1U}, {1U, 1U}, {4U, 4U}}) {
    s.width = width;
    s.height = height;
    REQUIRE(writer.write(Stream::Depth, s, pixels.data()));
    REQUIRE(ring.read(Stream::Depth, f).value());
    CHECK(f.stamp.width == width);
    CHECK(f.pixels == std::vector(pixels.begin(), pixels.begin() + width * height));
  }
  for (const auto& [width, height] : {std::pair{7U, 3U}, {0U, 5U}, {0x10000U, 0x10000U}}) {
    s.width = width;
    s.height = height;
    CHECK_FALSE(writer.write(Stream::Depth, s, pixels.data()));
  }
  s.width = s.height = 1;
  CHECK_FALSE(writer.write(Stream::Infrared, s, pixels.data()));
  CHECK_FALSE(ring.read(Stream::Depth, f).value());
  CHECK_FALSE(ring.read(Stream::Infrared, f).value());
}

TEST_CASE("memory of a shape that cannot be is not made", "[capture]") {
  for (const RingShape& shape : {RingShape{0, 8}, {3, 8}, {1, 0}, {1, 7}, {1, kMaxSlotPixels + 4}})
    CHECK_FALSE(FrameRing::make(shape));
}
