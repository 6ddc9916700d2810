// A recording that was cut becomes a whole one, or nothing.

#include "tools/telemetry/replay/recover.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <random>

#include "tests/unit/tools/telemetry/disk.hpp"
#include "tools/telemetry/mcap/mcap_chunk.hpp"
#include "tools/telemetry/mcap/mcap_writer.hpp"

namespace {

using namespace colift;
using namespace colift::telemetry;
namespace fs = std::filesystem;

constexpr int kChunks = 20, kInChunk = 10, kMessageBytes = 2000;

struct Folder {
  fs::path path = fs::temp_directory_path() / ("colift-recover-" + std::to_string(::getpid()));
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
};

/// A recording without its last part: no summary, and a chunk that is not whole.
McapReader cut_recording() {
  const Channel channel{1, 0, "/noise", "x-binary", {}};
  tests::Disk disk;
  McapWriter writer(std::make_unique<tests::DiskSink>(disk));
  REQUIRE(writer.begin("", "test"));
  REQUIRE(writer.attach({5, 4, "config.yaml", "application/yaml", "a: 1\n"}));
  std::mt19937 random(1);
  ChunkBuilder builder(0);
  for (int c = 0; c < kChunks; ++c) {
    for (int m = 0; m < kInChunk; ++m) {
      std::string data(kMessageBytes, '\0');
      for (char& byte : data) byte = static_cast<char>(random());  // nothing that zstd could make smaller
      const auto n = static_cast<std::uint32_t>(kInChunk * c + m);
      builder.add(nullptr, channel, {channel.id, n, n, n, data});
    }
    REQUIRE(writer.add(builder.close(), {}, {{1, channel}}));
  }
  disk.bytes.resize(disk.bytes.size() - kMessageBytes * kInChunk / 2);
  auto reader = McapReader::open(source_of(disk.bytes), "cut");
  REQUIRE(reader);
  return std::move(*reader);
}

}  // namespace

TEST_CASE("a recording that was cut becomes a whole one of what is left", "[recover]") {
  const Folder folder;
  const McapReader cut = cut_recording();
  CHECK_FALSE(cut.info().complete);
  const fs::path to = folder.path / "whole.mcap";
  const auto done = recover(cut, to);
  REQUIRE(done);
  CHECK(done->attachments == 1);
  CHECK(done->messages >= (kChunks - 1) * kInChunk);
  CHECK(done->messages < kChunks * kInChunk);
  CHECK(done->bytes == fs::file_size(to));
  CHECK_FALSE(done->damage.empty());
  auto source = open_file(to);
  REQUIRE(source);
  const auto whole = McapReader::open(std::move(*source), to.string());
  REQUIRE(whole);
  CHECK(whole->info().complete);
  CHECK(whole->info().damage.empty());
  CHECK(whole->info().statistics.messages == done->messages);
  CHECK(whole->attachment("config.yaml")->data == "a: 1\n");
}

TEST_CASE("on a disk that is full nothing is left that looks like a recording", "[recover]") {
  const Folder folder;
  const McapReader cut = cut_recording();
  const fs::path to = folder.path / "whole.mcap";
  rlimit before{};
  REQUIRE(::getrlimit(RLIMIT_FSIZE, &before) == 0);
  for (const rlim_t bytes : {rlim_t{0}, rlim_t{100}, rlim_t{50000}}) {
    const rlimit small{bytes, before.rlim_max};
    REQUIRE(::setrlimit(RLIMIT_FSIZE, &small) == 0);
    const auto done = recover(cut, to);
    REQUIRE(::setrlimit(RLIMIT_FSIZE, &before) == 0);
    INFO(bytes);
    REQUIRE_FALSE(done);
    CHECK_THAT(done.error().text(), Catch::Contains("whole.mcap"));
    CHECK(fs::is_empty(folder.path));
  }
  // and what stood there before still does
  REQUIRE(recover(cut, to));
  const auto size = fs::file_size(to);
  const rlimit small{100, before.rlim_max};
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &small) == 0);
  const auto again = recover(cut, to);
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &before) == 0);
  CHECK_FALSE(again);
  CHECK(fs::file_size(to) == size);
}
