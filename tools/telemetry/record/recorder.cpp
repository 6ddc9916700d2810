#include "tools/telemetry/record/recorder.hpp"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

#include "tools/telemetry/channels/messages.hpp"
#include "tools/telemetry/mcap/mcap_chunk.hpp"
#include "tools/telemetry/mcap/mcap_writer.hpp"
#include "tools/telemetry/record/flight_memory.hpp"

namespace colift::telemetry {
namespace {

using namespace std::chrono_literals;

constexpr const char* kLibrary = "colift";

std::map<std::uint16_t, Schema> file_schemas() {
  std::map<std::uint16_t, Schema> all;
  std::uint16_t id = 0;
  for (const ChannelInfo& c : channels()) {
    ++id;
    if (!c.schema_encoding.empty()) all[id] = {id, c.schema_name, c.schema_encoding, c.schema};
  }
  return all;
}

std::map<std::uint16_t, Channel> file_channels() {
  std::map<std::uint16_t, Channel> all;
  std::uint16_t id = 0;
  for (const ChannelInfo& c : channels()) {
    ++id;
    all[id] = {id, c.schema_encoding.empty() ? std::uint16_t{0} : id, c.topic, c.encoding, {}};
  }
  return all;
}

std::uint64_t log_time(hal::Timestamp at) {
  return at.count() < 0 ? 0 : static_cast<std::uint64_t>(at.count());
}

/// "x.mcap", "x-2.mcap", ...
std::filesystem::path numbered(const std::filesystem::path& file, int n) {
  if (n <= 1) return file;
  return file.parent_path() / fmt::format("{}-{}{}", file.stem().string(), n, file.extension().string());
}

}  // namespace

struct Recorder::Impl {
  RecorderConfig config;
  RunDocuments documents;
  const std::map<std::uint16_t, Schema> schemas = file_schemas();
  const std::map<std::uint16_t, Channel> all_channels = file_channels();

  // between the threads
  std::mutex mutex;
  std::condition_variable news, room;
  /// A message, or the place among them where something went wrong.
  struct Item {
    Publication publication;
    bool fault = false;
  };
  std::deque<Item> queue;
  std::size_t queue_bytes = 0;
  std::uint64_t lost_queue = 0;
  bool fault_waits = false;  ///< One is in the queue already.
  bool end = false;

  // the recorder's own thread
  std::unique_ptr<McapWriter> writer;
  ChunkBuilder builder{3};
  std::vector<std::uint32_t> sequences = std::vector<std::uint32_t>(kTopics + 1, 0);
  std::unique_ptr<FlightMemory> memory;     ///< Null where nobody can ask for the last seconds.
  int faults_written = 0;                   ///< Files; what somebody asked for has names of its own.
  std::optional<std::uint64_t> flight_due;  ///< Log time at which the last seconds are written.
  std::uint64_t newest = 0, reported_lost = 0;
  RecorderReport report;
  std::thread thread;

  [[nodiscard]] hal::Result<std::unique_ptr<McapWriter>> begin_file(const std::filesystem::path& file) const {
    auto sink = config.create ? config.create(file) : create_file(file);
    if (!sink) return tl::unexpected(sink.error());
    auto made = std::make_unique<McapWriter>(std::move(*sink));
    if (auto done = made->begin("", kLibrary); !done) return tl::unexpected(done.error());
    for (const Attachment& a : documents.attachments)
      if (auto done = made->attach(a); !done) return tl::unexpected(done.error());
    for (const Metadata& m : documents.metadata)
      if (auto done = made->add(m); !done) return tl::unexpected(done.error());
    return made;
  }

  void add(const Publication& p) {
    const auto id = static_cast<std::uint16_t>(static_cast<int>(p.topic) + 1);
    const std::string payload = p.encode();
    const std::uint64_t time = log_time(p.at);
    const Channel& channel = all_channels.at(id);
    const auto schema = schemas.find(channel.schema_id);
    if (memory) memory->note(p.topic, sequences[id], time, payload);
    builder.add(schema == schemas.end() ? nullptr : &schema->second, channel,
                {id, sequences[id]++, time, time, payload});
    newest = std::max(newest, time);
    if (builder.size() >= config.chunk_bytes ||
        static_cast<double>(newest - builder.start_time()) >= 1e9 * config.chunk_s)
      close_chunk();
    if (flight_due && newest >= *flight_due) write_flight();
  }

  void close_chunk() {
    if (builder.empty()) return;
    auto chunk = std::make_shared<const Chunk>(builder.close());
    if (writer) {
      if (auto done = writer->add(*chunk, schemas, all_channels); done) {
        report.written += chunk->messages;
      } else {
        report.lost_disk += chunk->messages;
        if (report.error.empty()) report.error = done.error().text();
      }
    } else {
      report.written += chunk->messages;
    }
    if (memory) memory->keep(std::move(chunk));
  }

  /// What held before the first of these chunks, stamped with its beginning: what is shown then.
  [[nodiscard]] std::optional<Chunk> opening(const std::vector<std::shared_ptr<const Chunk>>& chunks) const {
    if (chunks.empty()) return std::nullopt;
    const std::uint64_t time = chunks.front()->start_time;
    ChunkBuilder first(config.zstd_level);
    memory->before([&](Topic topic, std::uint32_t sequence, const std::string& payload) {
      const auto id = static_cast<std::uint16_t>(static_cast<int>(topic) + 1);
      const Channel& channel = all_channels.at(id);
      const auto schema = schemas.find(channel.schema_id);
      first.add(schema == schemas.end() ? nullptr : &schema->second, channel,
                {id, sequence, time, time, payload});
    });
    if (first.empty()) return std::nullopt;
    return first.close();
  }

  void write_last(const std::filesystem::path& file) {
    close_chunk();
    const auto chunks = memory->chunks();
    const auto before = opening(chunks);
    // whole or not at all, for whoever waits for it
    const std::filesystem::path part = file.string() + ".part";
    const auto written = [&]() -> hal::Result<> {
      auto made = begin_file(part);
      if (!made) return tl::unexpected(made.error());
      if (auto done = (*made)->add(Metadata{kSnapshot, {{"seconds", fmt::format("{}", config.flight_s)}}});
          !done)
        return done;
      if (before)
        if (auto done = (*made)->add(*before, schemas, all_channels); !done) return done;
      for (const auto& chunk : chunks)
        if (auto done = (*made)->add(*chunk, schemas, all_channels); !done) return done;
      return (*made)->finish();
    }();
    std::error_code error;
    if (written) std::filesystem::rename(part, file, error);
    if (!written || error) {
      if (report.error.empty()) report.error = written ? error.message() : written.error().text();
      std::filesystem::remove(part, error);
      return;
    }
    report.flights.push_back(file);
  }

  void write_flight() {
    flight_due.reset();
    if (!config.flight || faults_written >= config.most_flights) return;
    const std::size_t before = report.flights.size();
    write_last(numbered(*config.flight, faults_written + 1));
    if (report.flights.size() > before) ++faults_written;
  }

  /// The losses as a line of the log itself, so that nobody takes the gap for silence.
  void tell_losses(std::uint64_t lost) {
    if (lost == reported_lost) return;
    const std::string text =
        fmt::format("the recorder lost {} messages: its queue was full", lost - reported_lost);
    reported_lost = lost;
    const hal::Timestamp at(static_cast<std::int64_t>(newest));
    add({Topic::Log, at, [at, text] { return log_message(at, Level::Warning, "recorder", text); }, 256});
  }

  void run() {
    for (;;) {
      std::deque<Item> batch;
      std::uint64_t lost = 0;
      bool last = false;
      {
        std::unique_lock lock(mutex);
        news.wait_for(lock, 100ms, [&] { return end || !queue.empty(); });
        // a few at a time: room is made while the rest is compressed
        while (!queue.empty() && batch.size() < 64) {
          if (queue.front().fault) fault_waits = false;
          queue_bytes -= queue.front().publication.bytes;
          batch.push_back(std::move(queue.front()));
          queue.pop_front();
        }
        lost = lost_queue;
        last = end && queue.empty();
      }
      room.notify_all();
      for (const Item& item : batch) {
        if (!item.fault)
          add(item.publication);
        else if (!flight_due)
          flight_due = newest + static_cast<std::uint64_t>(1e9 * config.aftermath_s);
      }
      tell_losses(lost);
      if (config.snapshot_asked)
        if (const auto file = config.snapshot_asked()) write_last(*file);
      if (last) return;
    }
  }
};

Recorder::Recorder(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {
  impl_->thread = std::thread([i = impl_.get()] {
    // on a robot everything else goes first
    if (!i->config.wait_when_full) (void)::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), 10);
    i->run();
  });
}

hal::Result<std::unique_ptr<Recorder>> Recorder::start(const RecorderConfig& config,
                                                       const RunDocuments& documents) {
  auto impl = std::make_unique<Impl>();
  impl->config = config;
  impl->documents = documents;
  impl->builder = ChunkBuilder(config.zstd_level);
  if (config.flight || config.snapshot_asked)
    impl->memory = std::make_unique<FlightMemory>(config.flight_s, config.flight_bytes);
  if (config.file) {
    auto writer = impl->begin_file(*config.file);
    if (!writer) return tl::unexpected(writer.error());
    impl->writer = std::move(*writer);
  }
  return std::unique_ptr<Recorder>(new Recorder(std::move(impl)));
}

Recorder::~Recorder() {
  if (impl_->thread.joinable()) (void)finish();
}

void Recorder::publish(const Publication& p) {
  Impl& i = *impl_;
  {
    std::unique_lock lock(i.mutex);
    const auto fits = [&] {
      // one message larger than the whole queue goes through an empty one
      return i.queue.empty() ||
             (i.queue.size() < i.config.queue_messages && i.queue_bytes + p.bytes <= i.config.queue_bytes);
    };
    if (i.config.wait_when_full) i.room.wait(lock, [&] { return i.end || fits(); });
    if (i.end || !fits()) {
      ++i.lost_queue;
      return;
    }
    i.queue_bytes += p.bytes;
    i.queue.push_back({p, false});
  }
  i.news.notify_one();
}

void Recorder::fault() {
  const std::lock_guard lock(impl_->mutex);
  if (impl_->fault_waits) return;
  impl_->fault_waits = true;
  impl_->queue.push_back({Publication{Topic::Log, hal::Timestamp(0), {}, 0}, true});
}

RecorderReport Recorder::finish(const RunDocuments& at_end) {
  Impl& i = *impl_;
  if (!i.thread.joinable()) return i.report;
  {
    const std::lock_guard lock(i.mutex);
    i.end = true;
  }
  i.news.notify_all();
  i.room.notify_all();
  i.thread.join();
  i.close_chunk();
  i.documents.attachments.insert(i.documents.attachments.end(), at_end.attachments.begin(),
                                 at_end.attachments.end());
  i.documents.metadata.insert(i.documents.metadata.end(), at_end.metadata.begin(), at_end.metadata.end());
  if (i.flight_due) i.write_flight();
  i.report.lost_queue = i.lost_queue;
  if (!i.writer) return i.report;

  const auto remember = [&](const hal::Result<>& done) {
    if (!done && i.report.error.empty()) i.report.error = done.error().text();
    return done.has_value();
  };
  for (const Attachment& a : at_end.attachments) (void)remember(i.writer->attach(a));
  for (const Metadata& m : at_end.metadata) (void)remember(i.writer->add(m));
  (void)remember(i.writer->add(Metadata{"colift.recorder",
                                        {{"written", std::to_string(i.report.written)},
                                         {"lost_queue", std::to_string(i.report.lost_queue)},
                                         {"lost_disk", std::to_string(i.report.lost_disk)},
                                         {"error", i.report.error}}}));
  i.report.complete = remember(i.writer->finish());
  i.report.file_bytes = i.writer->size();
  i.writer.reset();
  return i.report;
}

}  // namespace colift::telemetry
