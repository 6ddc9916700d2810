// Files that are written and read back, whole, cut at every byte, and damaged.

#include <catch2/catch.hpp>
#include <cstring>
#include <random>
#include <set>

#include "tests/unit/tools/telemetry/disk.hpp"
#include "tools/telemetry/mcap/byte_io.hpp"
#include "tools/telemetry/mcap/mcap_chunk.hpp"
#include "tools/telemetry/mcap/mcap_decode.hpp"
#include "tools/telemetry/mcap/mcap_encode.hpp"
#include "tools/telemetry/mcap/mcap_reader.hpp"
#include "tools/telemetry/mcap/mcap_writer.hpp"

namespace {

using namespace colift;
using namespace colift::telemetry;
using tests::Disk;
using tests::DiskSink;

const Schema kSchema{1, "colift.Test", "jsonschema", R"({"type":"object"})"};
const Channel kJson{1, 1, "/json", "json", {{"unit", "m"}}};
const Channel kBinary{2, 0, "/binary", "x-binary", {}};
const std::map<std::uint16_t, Schema> kSchemas{{1, kSchema}};
const std::map<std::uint16_t, Channel> kChannels{{1, kJson}, {2, kBinary}};

struct Said {
  std::uint16_t channel;
  std::uint64_t time;
  std::string data;
  bool operator==(const Said&) const = default;
};

/// `chunks` chunks of 10 messages, seeded; returns what was said.
std::vector<Said> write_file(McapWriter& writer, int chunks, int level, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::vector<Said> said;
  REQUIRE(writer.begin("", "test"));
  REQUIRE(writer.attach({5, 4, "config.yaml", "application/yaml", "a: 1\n"}));
  REQUIRE(writer.add(Metadata{"run", {{"seed", "7"}, {"empty", ""}}}));
  ChunkBuilder builder(level);
  for (int c = 0; c < chunks; ++c) {
    for (int m = 0; m < 10; ++m) {
      const bool json = random() % 3 != 0;
      std::string data(random() % 60, '\0');
      for (char& byte : data) byte = static_cast<char>(json ? 'a' + random() % 4 : random());
      const auto time = static_cast<std::uint64_t>(1000 * c + 10 * m);
      said.push_back({json ? kJson.id : kBinary.id, time, data});
      builder.add(json ? &kSchema : nullptr, json ? kJson : kBinary,
                  {json ? kJson.id : kBinary.id, static_cast<std::uint32_t>(said.size()), time, time, data});
    }
    REQUIRE(writer.add(builder.close(), kSchemas, kChannels));
  }
  return said;
}

std::vector<Said> read_all(const McapReader& reader, const std::set<std::string>& topics = {}) {
  std::vector<Said> said;
  auto cursor = reader.messages(topics);
  while (const auto m = cursor.next()) said.push_back({m->channel_id, m->log_time, std::string(m->data)});
  return said;
}

McapReader opened(const std::string& bytes) {
  auto reader = McapReader::open(source_of(bytes), "test");
  REQUIRE(reader);
  return std::move(*reader);
}

std::string whole_file(int chunks, int level, std::vector<Said>* said = nullptr) {
  Disk disk;
  McapWriter writer(std::make_unique<DiskSink>(disk));
  auto all = write_file(writer, chunks, level);
  REQUIRE(writer.finish());
  CHECK(writer.size() == disk.bytes.size());
  if (said) *said = std::move(all);
  return disk.bytes;
}

}  // namespace

TEST_CASE("what is written is read back, by the summary and from the front", "[mcap]") {
  for (const int level : {0, 3}) {
    std::vector<Said> said;
    const std::string bytes = whole_file(5, level, &said);
    const McapReader reader = opened(bytes);
    const McapInfo& info = reader.info();
    CHECK(info.complete);
    CHECK(info.damage.empty());
    CHECK(info.library == "test");
    CHECK(info.statistics.messages == 50);
    CHECK(info.statistics.start_time == 0);
    CHECK(info.statistics.end_time == 4090);
    CHECK(info.chunks.size() == 5);
    REQUIRE(info.channel("/json"));
    CHECK(info.channel("/json")->metadata.at("unit") == "m");
    CHECK(info.schemas.at(1).data == kSchema.data);
    CHECK(read_all(reader) == said);
    CHECK(reader.attachment("config.yaml")->data == "a: 1\n");
    CHECK(reader.attachment("other").error().code == hal::ErrorCode::NotFound);
    CHECK(reader.metadata("run")->entries.at("seed") == "7");

    const McapInfo scanned = reader.scan();
    CHECK(scanned.damage.empty());
    CHECK(scanned.statistics.messages == info.statistics.messages);
    CHECK(scanned.statistics.per_channel == info.statistics.per_channel);
    CHECK(scanned.attachments.size() == 1);
    CHECK(scanned.metadata.size() == 1);
  }
}

TEST_CASE("one topic alone is read, without the chunks that lack it", "[mcap]") {
  std::vector<Said> said;
  const McapReader reader = opened(whole_file(5, 3, &said));
  std::erase_if(said, [](const Said& s) { return s.channel != kBinary.id; });
  CHECK(read_all(reader, {"/binary"}) == said);
  CHECK(read_all(reader, {"/nothing"}).empty());
}

TEST_CASE("the message index points at the messages", "[mcap]") {
  ChunkBuilder builder(0);
  for (std::uint64_t t : {30u, 10u, 20u}) builder.add(&kSchema, kJson, {1, 0, t, t, "x"});
  const Chunk chunk = builder.close();
  CHECK(chunk.start_time == 10);
  CHECK(chunk.end_time == 30);
  const MessageIndex& index = chunk.index.at(1);
  REQUIRE(index.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(index[i].first == 10 * (i + 1));  // by time
    ByteReader r(std::string_view(chunk.records).substr(static_cast<std::size_t>(index[i].second)));
    CHECK(Op{r.u8()} == Op::Message);
    CHECK(r.u64() == 23);
    CHECK(r.u16() == 1);
    (void)r.u32();
    CHECK(r.u64() == index[i].first);
  }
  CHECK(builder.empty());
}

TEST_CASE("a file cut at any byte is read up to there", "[mcap]") {
  for (const int level : {0, 3}) {
    std::vector<Said> said;
    const std::string bytes = whole_file(4, level, &said);
    std::size_t before = 0;
    for (std::size_t cut = 0; cut < bytes.size(); ++cut) {
      const auto reader = McapReader::open(source_of(bytes.substr(0, cut)), "cut");
      if (cut < kMagic.size()) {
        REQUIRE_FALSE(reader);
        CHECK(reader.error().code == hal::ErrorCode::BadInput);
        continue;
      }
      REQUIRE(reader);
      CHECK_FALSE(reader->info().complete);
      CHECK_FALSE(reader->info().damage.empty());
      CHECK(reader->info().readable <= cut);
      const auto read = read_all(*reader);
      // a beginning of what was said, never less than a shorter file gave
      REQUIRE(read.size() <= said.size());
      REQUIRE(std::equal(read.begin(), read.end(), said.begin()));
      REQUIRE(read.size() >= before);
      before = read.size();
    }
    CHECK(before == said.size());
  }
}

TEST_CASE("an uncompressed chunk that was cut gives every whole message", "[mcap]") {
  std::vector<Said> said;
  const std::string bytes = whole_file(1, 0, &said);
  // just before the last message's last byte
  const auto at = bytes.rfind(said.back().data);
  REQUIRE(at != std::string::npos);
  REQUIRE_FALSE(said.back().data.empty());
  const McapReader reader = opened(bytes.substr(0, at + said.back().data.size() - 1));
  CHECK(read_all(reader).size() == said.size() - 1);
}

TEST_CASE("any byte that is another one is survived, and a damaged chunk is left out", "[mcap]") {
  std::vector<Said> said;
  const std::string bytes = whole_file(4, 3, &said);
  std::mt19937 random(3);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string bad = bytes;
    bad[i] = static_cast<char>(bad[i] ^ (1u << (random() % 8)));
    const auto reader = McapReader::open(source_of(bad), "bad");
    if (!reader) continue;
    const auto read = read_all(*reader);
    // an index record may have become a message
    REQUIRE(read.size() <= said.size() + 1);
  }
  // in the middle of the second chunk's compressed bytes
  const McapReader whole = opened(bytes);
  std::string bad = bytes;
  const ChunkIndex& second = whole.info().chunks.at(1);
  bad[static_cast<std::size_t>(second.offset + second.length / 2)] ^= 0x55;
  const McapReader reader = opened(bad);
  CHECK(read_all(reader).size() == said.size() - 10);
  const McapInfo scanned = reader.scan();
  REQUIRE(scanned.damage.size() == 1);
  CHECK(scanned.damage[0].find(std::to_string(second.offset)) != std::string::npos);
}

TEST_CASE("lengths that lie cost neither time nor memory", "[mcap]") {
  const std::string head = std::string(kMagic) + encode_header("", "liar");
  std::string bytes = head;
  ByteWriter w(bytes);
  w.u8(static_cast<std::uint8_t>(Op::Attachment)), w.u64(UINT64_MAX - 4);
  CHECK_FALSE(opened(bytes).info().damage.empty());

  Chunk bomb;
  bomb.compression = "zstd";
  bomb.uncompressed_size = UINT64_MAX;
  bomb.records = "nothing";
  CHECK_FALSE(opened(head + encode(bomb)).info().damage.empty());
  bomb.uncompressed_size = 100;
  bomb.compression = "lz4";
  const McapReader lz4 = opened(head + encode(bomb));
  REQUIRE_FALSE(lz4.info().damage.empty());
  CHECK(lz4.info().damage[0].find("lz4") != std::string::npos);
}

TEST_CASE("statistics that end before they start are counted anew", "[mcap]") {
  std::string bytes = whole_file(2, 0);
  Statistics s = opened(bytes).info().statistics;
  const std::string honest = encode(s);
  std::swap(s.start_time, s.end_time);
  CHECK_FALSE(decode_statistics(std::string_view(encode(s)).substr(kRecordHead)));
  const std::size_t at = bytes.find(honest);
  REQUIRE(at != std::string::npos);
  bytes.replace(at, honest.size(), encode(s));
  const McapReader reader = opened(bytes);
  CHECK(reader.info().statistics.start_time == 0);
  CHECK(reader.info().statistics.end_time == 1090);
  CHECK(reader.info().statistics.messages == 20);
}

TEST_CASE("a full disk costs what did not fit, and the file stays good", "[mcap]") {
  Disk disk;
  McapWriter writer(std::make_unique<DiskSink>(disk));
  const auto said = write_file(writer, 3, 0);
  const std::uint64_t good = writer.size();
  disk.room = disk.bytes.size() + 50;  // a part of the next chunk fits
  ChunkBuilder builder(0);
  for (int i = 0; i < 10; ++i) builder.add(&kSchema, kJson, {1, 0, 9000, 9000, "does not fit"});
  const Chunk lost = builder.close();
  CHECK_FALSE(writer.add(lost, kSchemas, kChannels));
  CHECK(writer.size() == good);
  CHECK(disk.bytes.size() == good);
  CHECK(writer.statistics().messages == said.size());

  disk.room = UINT64_MAX;  // somebody made room
  CHECK(writer.add(lost, kSchemas, kChannels));
  REQUIRE(writer.finish());
  const McapReader reader = opened(disk.bytes);
  CHECK(reader.info().complete);
  CHECK(reader.scan().damage.empty());
  CHECK(read_all(reader).size() == said.size() + 10);
}

TEST_CASE("what is no recording is refused in a sentence", "[mcap]") {
  for (const std::string& bytes : {std::string(), std::string("short"), std::string(100, 'x')}) {
    const auto reader = McapReader::open(source_of(bytes), "picture.png");
    REQUIRE_FALSE(reader);
    CHECK(reader.error().where == "picture.png");
    CHECK(reader.error().detail.find("MCAP") != std::string::npos);
  }
}
