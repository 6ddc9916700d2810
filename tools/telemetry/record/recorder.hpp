#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tools/telemetry/channels/channels.hpp"
#include "tools/telemetry/mcap/byte_sink.hpp"
#include "tools/telemetry/mcap/mcap_records.hpp"

namespace colift::telemetry {

/// Metadata that only files of last seconds have: such a file may end in the middle of a cycle of the task.
inline constexpr const char* kSnapshot = "colift.snapshot";

/// What every file of a run carries beside its messages.
struct RunDocuments {
  std::vector<Attachment> attachments;
  std::vector<Metadata> metadata;
};

struct RecorderConfig {
  std::optional<std::filesystem::path> file;    ///< The whole run; unset: none.
  std::optional<std::filesystem::path> flight;  ///< Where the last seconds go on a fault; unset: nowhere.
  double flight_s = 15.0;                       ///< How long the last seconds are ...
  std::size_t flight_bytes = 64u << 20;         ///< ... and how much memory they may take, compressed.
  double aftermath_s = 1.0;                     ///< What follows a fault is of interest too.
  int most_flights = 5;                         ///< Files in one run.
  /// A full queue: wait, where the robot's time stands still meanwhile (simulation in lock step), or lose the
  /// message and count it.
  bool wait_when_full = false;
  std::size_t queue_messages = 8192;
  std::size_t queue_bytes = 96u << 20;
  std::size_t chunk_bytes = 4u << 20;
  double chunk_s = 0.5;
  int zstd_level = 3;
  /// Asked about ten times a second: a file that shall get the last seconds now. May be empty.
  std::function<std::optional<std::filesystem::path>()> snapshot_asked;
  /// How files are made; create_file() unless a test wants another disk.
  std::function<hal::Result<std::unique_ptr<ByteSink>>(const std::filesystem::path&)> create;
};

/// What became of the messages. Every message is counted once: written, or lost for one of two reasons.
struct RecorderReport {
  std::uint64_t written = 0;     ///< In the file, or gone through the flight recorder.
  std::uint64_t lost_queue = 0;  ///< The queue was full: the disk or the compressor was too slow.
  std::uint64_t lost_disk = 0;   ///< The disk refused them.
  std::uint64_t file_bytes = 0;
  bool complete = false;                       ///< The file has its summary.
  std::string error;                           ///< First error of the disk; empty when there was none.
  std::vector<std::filesystem::path> flights;  ///< Files with last seconds that were written.
};

/// Takes messages of a run, compresses them in a thread of its own and writes them to a file; keeps the last
/// seconds in memory. publish() costs a short lock and no system call.
class Recorder final : public TelemetrySink {
 public:
  /// Opens the file. Errors: the file cannot be made or its head not be written.
  [[nodiscard]] static hal::Result<std::unique_ptr<Recorder>> start(const RecorderConfig& config,
                                                                    const RunDocuments& documents);
  ~Recorder() override;

  /// Any thread but the arm's.
  void publish(const Publication& publication) override;
  /// Something went wrong: the last seconds are written, with what follows. Any thread.
  void fault();
  /// Writes what is left and the summary, ends the thread. `at_end` goes into the file too. Once.
  RecorderReport finish(const RunDocuments& at_end = {});

 private:
  struct Impl;
  explicit Recorder(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::telemetry
