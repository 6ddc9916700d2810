#include "hal/drivers/capture_link/frame_ring.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace colift::hal::capture {
namespace {

constexpr std::size_t kPage = 4096;
static_assert(sizeof(FrameStamp) % 8 == 0);
constexpr std::size_t kStampWords = sizeof(FrameStamp) / 8;

struct Head {
  std::uint32_t magic, version;
  std::uint32_t streams, slot_pixels;
  std::uint64_t beat, state;
  std::uint64_t newest[kMaxStreams];
};
static_assert(sizeof(Head) <= kPage);

/// What a slot begins with; the pixels follow, four to a word.
struct SlotHead {
  std::uint64_t generation;  // twice the number of the frame; one less while it is written
  std::uint64_t stamp[kStampWords];
};

std::size_t slot_bytes(const RingShape& shape) {
  return sizeof(SlotHead) + 2 * std::size_t{shape.slot_pixels};
}

bool possible(const RingShape& shape) {
  return shape.streams >= 1 && shape.streams <= kMaxStreams && shape.slot_pixels >= 4 &&
         shape.slot_pixels <= kMaxSlotPixels && shape.slot_pixels % 4 == 0;
}

Head& head(void* memory) {
  return *static_cast<Head*>(memory);
}

SlotHead& slot(void* memory, const RingShape& shape, Stream stream, std::uint64_t number) {
  const std::size_t index = static_cast<std::size_t>(stream) * kSlots + number % kSlots;
  return *reinterpret_cast<SlotHead*>(static_cast<char*>(memory) + kPage + index * slot_bytes(shape));
}

std::uint64_t* words_of(SlotHead& s) {
  return reinterpret_cast<std::uint64_t*>(&s + 1);
}

/// Pixels of an image that fits a slot; 0: it does not.
std::size_t pixels_of(const FrameStamp& stamp, const RingShape& shape) {
  const std::uint64_t count = std::uint64_t{stamp.width} * stamp.height;
  return count <= shape.slot_pixels ? static_cast<std::size_t>(count) : 0;
}

// A seqlock: every word is read and written whole, because another process may be writing it at this moment.
// The words of a frame are stored with release and loaded with acquire rather than between fences (Boehm,
// "Can seqlocks get along with programming language memory models?", 2012): who sees a word of a newer frame
// then sees that frame's odd generation too. On x86 these are plain moves, and ThreadSanitizer, which does
// not know fences, follows them.
using Word = std::atomic_ref<std::uint64_t>;
static_assert(Word::is_always_lock_free);
constexpr auto kRelaxed = std::memory_order_relaxed;
constexpr auto kAcquire = std::memory_order_acquire;
constexpr auto kRelease = std::memory_order_release;

std::uint64_t load(std::uint64_t& word, std::memory_order order = kRelaxed) {
  return Word(word).load(order);
}
void store(std::uint64_t& word, std::uint64_t value, std::memory_order order = kRelaxed) {
  Word(word).store(value, order);
}

std::uint64_t mix(std::uint64_t sum, std::uint64_t word) {
  sum = (sum ^ word) * 0x9e3779b97f4a7c15ULL;  // odd: a step that loses nothing
  return sum ^ (sum >> 29);
}

}  // namespace

std::uint64_t pixel_sum(const std::uint16_t* pixels, std::size_t count) {
  // four chains, so that the machine can work on them side by side
  std::uint64_t chains[4] = {1, 2, 3, 4};
  std::size_t i = 0;
  for (; i + 16 <= count; i += 16)
    for (std::size_t c = 0; c < 4; ++c) {
      std::uint64_t word = 0;
      std::memcpy(&word, pixels + i + 4 * c, sizeof word);
      chains[c] = mix(chains[c], word);
    }
  for (; i < count; ++i) chains[0] = mix(chains[0], pixels[i]);
  return mix(mix(chains[0], chains[1]), mix(chains[2], chains[3]));
}

std::size_t ring_bytes(const RingShape& shape) {
  return kPage + shape.streams * kSlots * slot_bytes(shape);
}

// ---- the process's side

Result<FrameRingWriter> FrameRingWriter::map(int fd) {
  const auto wrong = [](std::string what) {
    return failure(ErrorCode::BadInput, "capture.ring", std::move(what));
  };
  Head found{};
  struct stat s {};
  if (::fstat(fd, &s) != 0 || ::pread(fd, &found, sizeof found, 0) != static_cast<ssize_t>(sizeof found) ||
      found.magic != kRingMagic)
    return wrong(fmt::format("file {} is no ring", fd));
  if (found.version != kRingVersion)
    return wrong(fmt::format("version {}, expected {}: program and capture process are of different builds",
                             found.version, kRingVersion));
  const RingShape shape{found.streams, found.slot_pixels};
  if (!possible(shape) || static_cast<std::size_t>(s.st_size) != ring_bytes(shape))
    return wrong(fmt::format("file {} has {} bytes, which are not those of {} streams of {} pixels", fd,
                             s.st_size, shape.streams, shape.slot_pixels));
  void* memory = ::mmap(nullptr, ring_bytes(shape), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  if (memory == MAP_FAILED) return wrong(fmt::format("cannot be mapped: {}", std::strerror(errno)));
  return FrameRingWriter(memory, shape);
}

FrameRingWriter::FrameRingWriter(FrameRingWriter&& other) noexcept
    : memory_(std::exchange(other.memory_, nullptr)), shape_(other.shape_) {
  std::swap(written_, other.written_);
}

FrameRingWriter& FrameRingWriter::operator=(FrameRingWriter&& other) noexcept {
  std::swap(memory_, other.memory_);
  std::swap(shape_, other.shape_);
  std::swap(written_, other.written_);
  return *this;
}

FrameRingWriter::~FrameRingWriter() {
  if (memory_ != nullptr) ::munmap(memory_, ring_bytes(shape_));
}

void FrameRingWriter::beat() {
  std::uint64_t& beat = head(memory_).beat;
  store(beat, load(beat) + 1);
}

void FrameRingWriter::set_state(CaptureState state) {
  store(head(memory_).state, static_cast<std::uint64_t>(state));
}

bool FrameRingWriter::write(Stream stream, FrameStamp stamp, const std::uint16_t* pixels) {
  const std::size_t count = pixels_of(stamp, shape_);
  if (count == 0 || static_cast<std::uint32_t>(stream) >= shape_.streams) return false;
  const std::uint64_t number = ++written_[static_cast<std::size_t>(stream)];
  stamp.number = number;
  stamp.sum = pixel_sum(pixels, count);
  SlotHead& s = slot(memory_, shape_, stream, number);
  store(s.generation, 2 * number - 1);  // before every word: those are release stores
  std::uint64_t words[kStampWords];
  std::memcpy(words, &stamp, sizeof stamp);
  for (std::size_t i = 0; i < kStampWords; ++i) store(s.stamp[i], words[i], kRelease);
  std::uint64_t* const to = words_of(s);
  for (std::size_t i = 0; i < count; i += 4) {
    std::uint64_t word = 0;
    std::memcpy(&word, pixels + i, 2 * std::min<std::size_t>(4, count - i));
    store(to[i / 4], word, kRelease);
  }
  store(s.generation, 2 * number, kRelease);
  store(head(memory_).newest[static_cast<std::size_t>(stream)], number, kRelease);
  return true;
}

// ---- the controller's side

Result<FrameRing> FrameRing::make(const RingShape& shape) {
  constexpr auto kWhere = "capture.ring";
  if (!possible(shape))
    return failure(ErrorCode::BadConfig, kWhere,
                   fmt::format("{} streams of {} pixels", shape.streams, shape.slot_pixels));
  const std::size_t bytes = ring_bytes(shape);
  const int fd = ::memfd_create("colift-capture", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (fd < 0)
    return failure(ErrorCode::DeviceFault, kWhere, fmt::format("no shared memory: {}", std::strerror(errno)));
  // sealed: a process that cut it short would otherwise kill the reader
  if (::ftruncate(fd, static_cast<off_t>(bytes)) != 0 ||
      ::fcntl(fd, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0) {
    const int why = errno;
    ::close(fd);
    return failure(ErrorCode::DeviceFault, kWhere,
                   fmt::format("{} bytes of shared memory: {}", bytes, std::strerror(why)));
  }
  void* memory = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  if (memory == MAP_FAILED) {
    const int why = errno;
    ::close(fd);
    return failure(ErrorCode::DeviceFault, kWhere, fmt::format("cannot be mapped: {}", std::strerror(why)));
  }
  head(memory).magic = kRingMagic;
  head(memory).version = kRingVersion;
  head(memory).streams = shape.streams;
  head(memory).slot_pixels = shape.slot_pixels;
  return FrameRing(fd, memory, shape);
}

FrameRing::FrameRing(FrameRing&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)),
      memory_(std::exchange(other.memory_, nullptr)),
      shape_(other.shape_) {
  std::swap(read_, other.read_);
  std::swap(missed_, other.missed_);
}

FrameRing& FrameRing::operator=(FrameRing&& other) noexcept {
  std::swap(fd_, other.fd_);
  std::swap(memory_, other.memory_);
  std::swap(shape_, other.shape_);
  std::swap(read_, other.read_);
  std::swap(missed_, other.missed_);
  return *this;
}

FrameRing::~FrameRing() {
  if (memory_ != nullptr) ::munmap(memory_, ring_bytes(shape_));
  if (fd_ >= 0) ::close(fd_);
}

std::uint64_t FrameRing::heartbeat() const {
  return load(head(memory_).beat);
}

CaptureState FrameRing::state() const {
  const std::uint64_t state = load(head(memory_).state);
  return state <= static_cast<std::uint64_t>(CaptureState::Ended) ? static_cast<CaptureState>(state)
                                                                  : CaptureState::Ended;
}

std::uint64_t FrameRing::newest(Stream stream) const {
  return load(head(memory_).newest[static_cast<std::size_t>(stream)], kAcquire);
}

Result<bool> FrameRing::read(Stream stream, RawFrame& into) {
  const auto at = static_cast<std::size_t>(stream);
  if (at >= shape_.streams) return false;
  const std::uint64_t number = newest(stream);
  if (number == read_[at]) return false;
  const auto refuse = [&](std::string reason) {
    read_[at] = number;
    return failure(ErrorCode::BadReply, "capture.frame", std::move(reason));
  };
  if (number < read_[at]) return refuse(fmt::format("frame {} after frame {}", number, read_[at]));
  SlotHead& s = slot(memory_, shape_, stream, number);
  // whether what was read since is one frame: asked after every word, those are acquire loads
  const auto whole = [&] { return load(s.generation, kAcquire) == 2 * number; };
  if (!whole()) return false;  // overwritten already
  std::uint64_t words[kStampWords];
  for (std::size_t i = 0; i < kStampWords; ++i) words[i] = load(s.stamp[i], kAcquire);
  if (!whole()) return false;
  std::memcpy(&into.stamp, words, sizeof into.stamp);
  const FrameStamp& stamp = into.stamp;
  if (stamp.number != number) return refuse(fmt::format("frame {} calls itself {}", number, stamp.number));
  const std::size_t count = pixels_of(stamp, shape_);
  if (count == 0)
    return refuse(fmt::format("a frame of {} x {} pixels, and a slot holds {}", stamp.width, stamp.height,
                              shape_.slot_pixels));
  into.pixels.resize(count);
  std::uint64_t* const from = words_of(s);
  for (std::size_t i = 0; i < count; i += 4) {
    const std::uint64_t word = load(from[i / 4], kAcquire);
    std::memcpy(into.pixels.data() + i, &word, 2 * std::min<std::size_t>(4, count - i));
  }
  if (!whole()) return false;
  if (stamp.sum != pixel_sum(into.pixels.data(), count))
    return refuse(fmt::format("the pixels of frame {} are not those that were sent", number));
  if (read_[at] > 0) missed_[at] += number - read_[at] - 1;
  read_[at] = number;
  return true;
}

}  // namespace colift::hal::capture
