#include "hal/can_log/can_log_writer.hpp"

#include <fmt/format.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <thread>
#include <utility>

#include "hal/types/spsc_ring.hpp"

namespace colift::hal {
namespace {

constexpr auto kPause = std::chrono::milliseconds(10);  // the queue holds a second of a busy bus
constexpr int kFlushEvery = 10;                         // pauses
constexpr int kMostNames = 1000;

struct Entry {
  Timestamp at{0};
  CanFrame frame;
  CandumpFrame::Direction direction = CandumpFrame::Direction::Unknown;
  bool is_note = false;
  ShortText text;
};

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

}  // namespace

struct CanLogWriter::Impl {
  std::filesystem::path path;
  std::string interface;
  Duration to_wall{0};
  CanLogLimits limits;
  std::unique_ptr<std::FILE, CloseFile> file;
  SpscRing<Entry, 4096> ring;
  std::atomic<std::uint64_t> unwritten{0}, queued{0};
  std::uint64_t taken = 0;  // with the mutex
  std::uint64_t bytes = 0, named_lost = 0;
  bool full = false;
  std::mutex mutex;  // of the pause alone: who logs does not take it
  std::condition_variable end_pause, drained;
  bool stop = false, hurry = false;
  std::thread thread;

  void put(const char* text, std::size_t size) {
    if (!full && bytes + size > limits.most_bytes) {
      full = true;
      std::fputs("# the log has reached its limit and ends here\n", file.get());
    }
    if (full || std::fwrite(text, 1, size, file.get()) != size)
      unwritten.fetch_add(1, std::memory_order_relaxed);
    else
      bytes += size;
  }

  void put_note(std::string_view text, Timestamp at) {
    const std::string line = fmt::format("# {} {}\n", candump_time(at + to_wall), text);
    put(line.data(), line.size());
  }

  void drain() {
    Timestamp last{0};
    std::uint64_t count = 0;
    while (const auto entry = ring.pop()) {
      ++count;
      last = entry->at;
      if (entry->is_note) {
        put_note(entry->text.str(), entry->at);
        continue;
      }
      std::array<char, 96> line{};
      put(line.data(), write_candump(line, interface, entry->frame, entry->at + to_wall, entry->direction));
    }
    if (const std::uint64_t lost = ring.refused(); lost != named_lost && last != Timestamp{0}) {
      put_note(fmt::format("lost {} frames: the queue was full", lost - named_lost), last);
      named_lost = lost;
    }
    const std::lock_guard lock(mutex);
    taken += count;
    drained.notify_all();
  }

  void push(const Entry& entry) noexcept {
    if (ring.push(entry)) queued.fetch_add(1, std::memory_order_relaxed);
  }

  void run() {
    for (int pauses = 0;; ++pauses) {
      drain();
      if (pauses % kFlushEvery == 0) std::fflush(file.get());
      std::unique_lock lock(mutex);
      if (end_pause.wait_for(lock, kPause, [this] { return stop || hurry; }) && stop) break;
      hurry = false;
    }
    drain();
    std::fflush(file.get());
  }
};

CanLogWriter::CanLogWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {
  impl_->thread = std::thread([i = impl_.get()] { i->run(); });
}

CanLogWriter::~CanLogWriter() {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->stop = true;
  }
  impl_->end_pause.notify_all();
  if (impl_->thread.joinable()) impl_->thread.join();
}

Result<std::unique_ptr<CanLogWriter>> CanLogWriter::create(const std::filesystem::path& file,
                                                           std::string interface, Duration to_wall,
                                                           const CanLogLimits& limits) {
  auto impl = std::make_unique<Impl>();
  impl->interface = interface.substr(0, 15);
  impl->to_wall = to_wall;
  impl->limits = limits;
  for (int n = 1; n <= kMostNames && !impl->file; ++n) {
    impl->path = file;
    if (n > 1)
      impl->path.replace_filename(fmt::format("{}-{}{}", file.stem().string(), n, file.extension().string()));
    impl->file.reset(std::fopen(impl->path.c_str(), "wxe"));
    if (!impl->file && errno != EEXIST)
      return failure(ErrorCode::BadConfig, file.string(),
                     fmt::format("the log of the bus cannot be made: {}", std::strerror(errno)));
  }
  if (!impl->file)
    return failure(ErrorCode::BadConfig, file.string(), "a thousand logs of this name exist: move them");
  return std::unique_ptr<CanLogWriter>(new CanLogWriter(std::move(impl)));
}

void CanLogWriter::frame(const CanFrame& frame, Timestamp at, CandumpFrame::Direction direction) noexcept {
  Entry entry;
  entry.at = at;
  entry.frame = frame;
  entry.direction = direction;
  impl_->push(entry);
}

void CanLogWriter::note(const ShortText& text, Timestamp at) noexcept {
  Entry entry;
  entry.at = at;
  entry.is_note = true;
  entry.text = text;
  impl_->push(entry);
}

void CanLogWriter::flush() {
  Impl& i = *impl_;
  const std::uint64_t all = i.queued.load(std::memory_order_relaxed);
  std::unique_lock lock(i.mutex);
  i.hurry = true;
  i.end_pause.notify_all();
  i.drained.wait(lock, [&] { return i.taken >= all; });
}

const std::filesystem::path& CanLogWriter::file() const {
  return impl_->path;
}

std::uint64_t CanLogWriter::lost() const {
  return impl_->ring.refused() + impl_->unwritten.load(std::memory_order_relaxed);
}

Duration to_wall_clock() {
  const auto wall = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<Duration>(wall) - SteadyClock().now();
}

}  // namespace colift::hal
