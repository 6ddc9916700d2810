// The recorder: nothing is lost silently, and a disk's error is its own.

#include "tools/telemetry/record/recorder.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <future>
#include <nlohmann/json.hpp>

#include "tests/unit/tools/telemetry/disk.hpp"
#include "tools/telemetry/channels/messages.hpp"
#include "tools/telemetry/mcap/mcap_reader.hpp"
#include "tools/telemetry/replay/export.hpp"

namespace {

using namespace colift;
using namespace colift::telemetry;
using tests::Disk;
using tests::DiskSink;

RecorderConfig on(Disk& disk) {
  RecorderConfig config;
  config.file = "run.mcap";
  config.wait_when_full = true;
  config.create = [&disk](const std::filesystem::path&) -> hal::Result<std::unique_ptr<ByteSink>> {
    disk.bytes.clear();
    return std::make_unique<DiskSink>(disk);
  };
  return config;
}

Publication line(int i, std::size_t bytes = 100) {
  const hal::Timestamp at(std::chrono::milliseconds(10 * i));
  return {Topic::Log, at, [=] { return log_message(at, Level::Info, "test", "line " + std::to_string(i)); },
          bytes};
}

std::vector<std::string> lines_of(const std::string& bytes) {
  const auto reader = McapReader::open(source_of(bytes), "disk");
  REQUIRE(reader);
  std::vector<std::string> lines;
  auto cursor = reader->messages({"/log"});
  while (const auto m = cursor.next())
    lines.push_back(nlohmann::json::parse(m->data)["message"].get<std::string>());
  return lines;
}

/// Holds the recorder's thread in the middle of a message until it is let go.
struct Gate {
  std::promise<void> entered_promise, leave_promise;
  std::future<void> entered = entered_promise.get_future();
  std::shared_future<void> leave = leave_promise.get_future().share();
  std::atomic<bool> once{false};
  Publication publication() {
    return {Topic::Log, hal::Timestamp(0),
            [this] {
              if (!once.exchange(true)) {
                entered_promise.set_value();
                leave.wait();
              }
              return log_message(hal::Timestamp(0), Level::Info, "test", "gate");
            },
            10};
  }
};

}  // namespace

TEST_CASE("a recording holds every line in order, and its documents", "[recorder]") {
  Disk disk;
  RunDocuments documents;
  documents.attachments.push_back({0, 0, "config.yaml", "application/yaml", "method: fast\n"});
  documents.metadata.push_back({"colift.run", {{"seed", "7"}}});
  auto recorder = Recorder::start(on(disk), documents);
  REQUIRE(recorder);
  for (int i = 0; i < 500; ++i) (*recorder)->publish(line(i));
  RunDocuments end;
  end.metadata.push_back({"colift.result", {{"outcome", "lifted"}}});
  const RecorderReport report = (*recorder)->finish(end);
  CHECK(report.written == 500);
  CHECK(report.lost_queue + report.lost_disk == 0);
  CHECK(report.complete);
  CHECK(report.error.empty());
  const auto lines = lines_of(disk.bytes);
  REQUIRE(lines.size() == 500);
  for (int i = 0; i < 500; ++i) REQUIRE(lines[static_cast<std::size_t>(i)] == "line " + std::to_string(i));
  const auto reader = McapReader::open(source_of(disk.bytes), "disk");
  CHECK(reader->attachment("config.yaml")->data == "method: fast\n");
  CHECK(reader->metadata("colift.result")->entries.at("outcome") == "lifted");
  CHECK(reader->metadata("colift.recorder")->entries.at("written") == "500");
  CHECK(reader->info().chunks.size() >= 9);  // half a second each
}

TEST_CASE("a queue that is full loses messages, counts them, and says so in the log", "[recorder]") {
  Disk disk;
  RecorderConfig config = on(disk);
  config.wait_when_full = false;
  config.queue_messages = 20;
  auto recorder = Recorder::start(config, {});
  REQUIRE(recorder);
  Gate gate;
  (*recorder)->publish(gate.publication());
  gate.entered.wait();
  for (int i = 0; i < 100; ++i) (*recorder)->publish(line(i));  // returns at once, every time
  gate.leave_promise.set_value();
  const RecorderReport report = (*recorder)->finish();
  CHECK(report.lost_queue == 80);
  CHECK(report.written == 1 + 20 + 1);
  const auto lines = lines_of(disk.bytes);
  REQUIRE(lines.size() == 22);
  CHECK(lines.back().find("lost 80 messages") != std::string::npos);
}

TEST_CASE("a queue is full of bytes too", "[recorder]") {
  Disk disk;
  RecorderConfig config = on(disk);
  config.wait_when_full = false;
  config.queue_bytes = 1000;
  auto recorder = Recorder::start(config, {});
  Gate gate;
  (*recorder)->publish(gate.publication());
  gate.entered.wait();
  for (int i = 0; i < 5; ++i) (*recorder)->publish(line(i, 400));
  gate.leave_promise.set_value();
  CHECK((*recorder)->finish().lost_queue == 3);
}

TEST_CASE("in lock step a full queue waits instead", "[recorder]") {
  Disk disk;
  RecorderConfig config = on(disk);
  config.queue_messages = 3;
  auto recorder = Recorder::start(config, {});
  for (int i = 0; i < 300; ++i) (*recorder)->publish(line(i));
  const RecorderReport report = (*recorder)->finish();
  CHECK(report.lost_queue == 0);
  CHECK(report.written == 300);
}

TEST_CASE("a disk that fills up costs lines that are counted; the file stays readable", "[recorder]") {
  Disk disk;
  disk.room = 6000;
  RecorderConfig config = on(disk);
  config.zstd_level = 0;
  auto recorder = Recorder::start(config, {});
  REQUIRE(recorder);
  for (int i = 0; i < 1000; ++i) (*recorder)->publish(line(i));
  const RecorderReport report = (*recorder)->finish();
  CHECK(report.written > 0);
  CHECK(report.lost_disk > 0);
  CHECK(report.written + report.lost_disk == 1000);
  CHECK_FALSE(report.complete);
  CHECK(report.error.find("No space left") != std::string::npos);
  CHECK(lines_of(disk.bytes).size() == report.written);
}

TEST_CASE("a limit of the file's size is like a full disk, not the end of the program", "[recorder]") {
  const auto file =
      std::filesystem::temp_directory_path() / ("colift-limit-" + std::to_string(::getpid()) + ".mcap");
  rlimit before{};
  REQUIRE(::getrlimit(RLIMIT_FSIZE, &before) == 0);
  const rlimit small{20000, before.rlim_max};
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &small) == 0);
  RecorderConfig config;
  config.file = file;
  config.wait_when_full = true;
  config.zstd_level = 0;
  auto recorder = Recorder::start(config, {});
  REQUIRE(recorder);
  for (int i = 0; i < 1000; ++i) (*recorder)->publish(line(i));
  const RecorderReport report = (*recorder)->finish();
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &before) == 0);
  CHECK(report.written > 0);
  CHECK(report.lost_disk > 0);
  CHECK(report.error.find("File too large") != std::string::npos);
  std::ifstream in(file, std::ios::binary);
  CHECK(lines_of({std::istreambuf_iterator<char>(in), {}}).size() == report.written);
  std::filesystem::remove(file);
}

TEST_CASE("a disk that cannot be begun is an error at the start", "[recorder]") {
  Disk disk;
  disk.room = 3;
  CHECK_FALSE(Recorder::start(on(disk), {}));
  RecorderConfig config;
  config.file = "/nowhere/run.mcap";
  const auto refused = Recorder::start(config, {});
  REQUIRE_FALSE(refused);
  CHECK(refused.error().where == "/nowhere/run.mcap");
}

TEST_CASE("the flight recorder writes the last seconds before a fault, and what follows", "[recorder]") {
  const auto folder =
      std::filesystem::temp_directory_path() / ("colift-flight-" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  RecorderConfig config;
  config.wait_when_full = true;
  config.flight = folder / "flight.mcap";
  config.flight_s = 2.0;
  config.aftermath_s = 1.0;
  RunDocuments documents;
  documents.metadata.push_back({"colift.run", {{"seed", "7"}}});
  auto recorder = Recorder::start(config, documents);
  REQUIRE(recorder);
  for (int i = 0; i < 1000; ++i) {  // ten seconds
    (*recorder)->publish(line(i));
    const hal::Timestamp at(std::chrono::milliseconds(10 * i));
    if (i == 100 || i == 300 || i == 950)  // long before, before, and in the last two seconds
      for (const Topic topic : {Topic::Scene, Topic::Change, Topic::Preview})
        (*recorder)->publish({topic, at, [i] { return "{\"i\":" + std::to_string(i) + "}"; }});
  }
  (*recorder)->fault();
  const RecorderReport report = (*recorder)->finish();
  REQUIRE(report.flights.size() == 1);
  std::ifstream in(report.flights[0], std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  const auto lines = lines_of(bytes);
  REQUIRE_FALSE(lines.empty());
  CHECK(lines.back() == "line 999");
  CHECK(lines.size() >= 200);  // the two seconds that were asked for, and at most two chunks more
  CHECK(lines.size() <= 310);
  const auto reader = McapReader::open(source_of(bytes), "flight");
  CHECK(reader->info().complete);
  CHECK(reader->metadata("colift.run")->entries.at("seed") == "7");
  CHECK(reader->metadata(kSnapshot));
  CHECK(reader->scan().damage.empty());
  std::map<std::string, std::string> said;
  auto cursor = reader->messages({"/scene", "/task/change", "/camera/preview"});
  while (const auto m = cursor.next())
    said[reader->info().channels.at(m->channel_id).topic] += std::string(m->data);
  CHECK(said["/scene"] == R"({"i":300}{"i":950})");  // what held when the file begins, then what came
  CHECK(said["/task/change"] == R"({"i":100}{"i":300}{"i":950})");
  CHECK(said["/camera/preview"] == R"({"i":950})");
  const auto start = reader->info().statistics.start_time;
  CHECK(start > 7'000'000'000);  // they are stamped as part of the last seconds
  std::filesystem::remove_all(folder);
}

TEST_CASE("a snapshot is written when it is asked for, and nothing without", "[recorder]") {
  const auto file =
      std::filesystem::temp_directory_path() / ("colift-snapshot-" + std::to_string(::getpid()) + ".mcap");
  RecorderConfig config;
  config.wait_when_full = true;
  std::promise<void> written;
  int asked = 0;
  config.snapshot_asked = [&]() -> std::optional<std::filesystem::path> {
    ++asked;
    if (asked == 2) return file;
    if (asked == 3) written.set_value();
    return std::nullopt;
  };
  auto recorder = Recorder::start(config, {});
  for (int i = 0; i < 10; ++i) (*recorder)->publish(line(i));
  written.get_future().wait();
  CHECK(std::filesystem::exists(file));
  CHECK((*recorder)->finish().flights.size() == 1);
  std::filesystem::remove(file);
}

TEST_CASE("a recording becomes tables, with numbers and words as they are", "[recorder]") {
  Disk disk;
  auto recorder = Recorder::start(on(disk), {});
  REQUIRE(recorder);
  const auto say = [&](Topic topic, const std::string& json) {
    (*recorder)->publish({topic, hal::Timestamp(1'500'000'000), [json] { return json; }});
  };
  say(Topic::Change, R"({"t":0.5,"state":"lift","because":"the \"partner\", who holds"})");
  say(Topic::Truth, R"({"list":[1,2],"data":")" + std::string(2000, 'A') + R"(","yes":true,"none":null})");
  (*recorder)->finish();
  const auto reader = McapReader::open(source_of(disk.bytes), "disk");
  REQUIRE(reader);
  const auto folder = std::filesystem::temp_directory_path() / ("colift-csv-" + std::to_string(::getpid()));
  const auto done = export_csv(*reader, folder);
  REQUIRE(done);
  CHECK(done->count == 2);
  const auto text = [&](const char* name) {
    std::ifstream in(folder / name);
    return std::string{std::istreambuf_iterator<char>(in), {}};
  };
  CHECK(text("task_change.csv") ==
        "log_time_s,because,state,t\n1.500000000,\"the \"\"partner\"\", who holds\",\"lift\",0.5\n");
  CHECK(text("truth.csv") == "log_time_s,list.0,list.1,yes\n1.500000000,1,2,1\n");
  std::filesystem::remove_all(folder);
}
