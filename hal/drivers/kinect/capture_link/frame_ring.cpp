#include "hal/drivers/kinect/capture_link/frame_ring.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace colift::hal::kinect {
namespace {

constexpr std::size_t kPage = 4096;
constexpr std::size_t kSlotWords = kInfraredPixels / 4;  // of 64 bits, four pixels each
static_assert(kInfraredPixels % 4 == 0 && kPixels % 4 == 0);
static_assert(sizeof(FrameStamp) % 8 == 0);
constexpr std::size_t kStampWords = sizeof(FrameStamp) / 8;

struct Head {
  std::uint32_t magic, version;
  std::uint64_t bytes;
  std::uint64_t beat, state;
  std::uint64_t newest[kStreams];
};
static_assert(sizeof(Head) <= kPage);

struct Slot {
  std::uint64_t generation;  // twice the number of the frame; one less while it is written
  std::uint64_t stamp[kStampWords];
  std::uint64_t words[kSlotWords];
};

constexpr std::size_t kBytes = kPage + kStreams * kSlots * sizeof(Slot);

Head& head(void* memory) {
  return *static_cast<Head*>(memory);
}

Slot& slot(void* memory, Stream stream, std::uint64_t number) {
  const std::size_t index = static_cast<std::size_t>(stream) * kSlots + number % kSlots;
  return *reinterpret_cast<Slot*>(static_cast<char*>(memory) + kPage + index * sizeof(Slot));
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

std::size_t pixels_of(Stream stream) {
  return stream == Stream::Depth ? kPixels : kInfraredPixels;
}
std::uint32_t height_of(Stream stream) {
  return static_cast<std::uint32_t>(stream == Stream::Depth ? kHeight : kInfraredHeight);
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

std::size_t ring_bytes() {
  return kBytes;
}

// ---- the process's side

Result<FrameRingWriter> FrameRingWriter::map(int fd) {
  constexpr auto kWhere = "kinect.ring";
  struct stat s {};
  if (::fstat(fd, &s) != 0 || static_cast<std::size_t>(s.st_size) != kBytes)
    return failure(ErrorCode::BadInput, kWhere,
                   fmt::format("file {} has {} bytes, a ring has {}", fd, s.st_size, kBytes));
  void* memory = ::mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  if (memory == MAP_FAILED)
    return failure(ErrorCode::BadInput, kWhere, fmt::format("cannot be mapped: {}", std::strerror(errno)));
  FrameRingWriter writer(memory);
  if (head(memory).magic != kRingMagic || head(memory).version != kRingVersion)
    return failure(ErrorCode::BadInput, kWhere,
                   fmt::format("version {}, expected {}: program and capture process are of different builds",
                               head(memory).version, kRingVersion));
  return writer;
}

FrameRingWriter::FrameRingWriter(FrameRingWriter&& other) noexcept
    : memory_(std::exchange(other.memory_, nullptr)) {
  for (std::uint32_t s = 0; s < kStreams; ++s) written_[s] = other.written_[s];
}

FrameRingWriter& FrameRingWriter::operator=(FrameRingWriter&& other) noexcept {
  std::swap(memory_, other.memory_);
  std::swap(written_, other.written_);
  return *this;
}

FrameRingWriter::~FrameRingWriter() {
  if (memory_ != nullptr) ::munmap(memory_, kBytes);
}

void FrameRingWriter::beat() {
  std::uint64_t& beat = head(memory_).beat;
  store(beat, load(beat) + 1);
}

void FrameRingWriter::set_state(CaptureState state) {
  store(head(memory_).state, static_cast<std::uint64_t>(state));
}

void FrameRingWriter::write(Stream stream, FrameStamp stamp, const std::uint16_t* pixels) {
  const std::uint64_t number = ++written_[static_cast<std::size_t>(stream)];
  const std::size_t count = pixels_of(stream);
  stamp.number = number;
  stamp.sum = pixel_sum(pixels, count);
  Slot& s = slot(memory_, stream, number);
  store(s.generation, 2 * number - 1);  // before every word: those are release stores
  std::uint64_t words[kStampWords];
  std::memcpy(words, &stamp, sizeof stamp);
  for (std::size_t i = 0; i < kStampWords; ++i) store(s.stamp[i], words[i], kRelease);
  for (std::size_t i = 0; i < count / 4; ++i) {
    std::uint64_t word = 0;
    std::memcpy(&word, pixels + 4 * i, sizeof word);
    store(s.words[i], word, kRelease);
  }
  store(s.generation, 2 * number, kRelease);
  store(head(memory_).newest[static_cast<std::size_t>(stream)], number, kRelease);
}

// ---- the controller's side

Result<FrameRing> FrameRing::make() {
  constexpr auto kWhere = "kinect.ring";
  const int fd = ::memfd_create("colift-kinect", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (fd < 0)
    return failure(ErrorCode::DeviceFault, kWhere, fmt::format("no shared memory: {}", std::strerror(errno)));
  // sealed: a process that cut it short would otherwise kill the reader
  if (::ftruncate(fd, static_cast<off_t>(kBytes)) != 0 ||
      ::fcntl(fd, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0) {
    const int why = errno;
    ::close(fd);
    return failure(ErrorCode::DeviceFault, kWhere,
                   fmt::format("{} bytes of shared memory: {}", kBytes, std::strerror(why)));
  }
  void* memory = ::mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  if (memory == MAP_FAILED) {
    const int why = errno;
    ::close(fd);
    return failure(ErrorCode::DeviceFault, kWhere, fmt::format("cannot be mapped: {}", std::strerror(why)));
  }
  head(memory).magic = kRingMagic;
  head(memory).version = kRingVersion;
  head(memory).bytes = kBytes;
  return FrameRing(fd, memory);
}

FrameRing::FrameRing(FrameRing&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), memory_(std::exchange(other.memory_, nullptr)) {
  std::swap(read_, other.read_);
  std::swap(missed_, other.missed_);
}

FrameRing& FrameRing::operator=(FrameRing&& other) noexcept {
  std::swap(fd_, other.fd_);
  std::swap(memory_, other.memory_);
  std::swap(read_, other.read_);
  std::swap(missed_, other.missed_);
  return *this;
}

FrameRing::~FrameRing() {
  if (memory_ != nullptr) ::munmap(memory_, kBytes);
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
  const std::uint64_t number = newest(stream);
  if (number == read_[at]) return false;
  const auto refuse = [&](std::string reason) {
    read_[at] = number;
    return failure(ErrorCode::BadReply, "kinect.frame", std::move(reason));
  };
  if (number < read_[at]) return refuse(fmt::format("frame {} after frame {}", number, read_[at]));
  Slot& s = slot(memory_, stream, number);
  if (load(s.generation, kAcquire) != 2 * number) return false;  // overwritten already
  std::uint64_t words[kStampWords];
  for (std::size_t i = 0; i < kStampWords; ++i) words[i] = load(s.stamp[i], kAcquire);
  const std::size_t count = pixels_of(stream);
  into.pixels.resize(count);
  for (std::size_t i = 0; i < count / 4; ++i) {
    const std::uint64_t word = load(s.words[i], kAcquire);
    std::memcpy(into.pixels.data() + 4 * i, &word, sizeof word);
  }
  if (load(s.generation) != 2 * number) return false;  // after every word: those were acquire loads
  std::memcpy(&into.stamp, words, sizeof into.stamp);

  const FrameStamp& stamp = into.stamp;
  if (stamp.number != number) return refuse(fmt::format("frame {} calls itself {}", number, stamp.number));
  if (stamp.width != static_cast<std::uint32_t>(kWidth) || stamp.height != height_of(stream))
    return refuse(fmt::format("a frame of {} x {} pixels, expected {} x {}", stamp.width, stamp.height,
                              kWidth, height_of(stream)));
  if (stamp.sum != pixel_sum(into.pixels.data(), count))
    return refuse(fmt::format("the pixels of frame {} are not those that were sent", number));
  if (read_[at] > 0) missed_[at] += number - read_[at] - 1;
  read_[at] = number;
  return true;
}

}  // namespace colift::hal::kinect
