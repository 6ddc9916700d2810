// A bus's frames on their way into a file: nothing waits, nothing is lost unsaid.
#include "hal/can_log/can_log_writer.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <memory>
#include <string>

#include "hal/can_log/logged_can_bus.hpp"

using namespace colift::hal;
using namespace std::chrono_literals;
using Direction = CandumpFrame::Direction;

namespace {

struct Folder {
  std::filesystem::path path = std::filesystem::temp_directory_path() / "colift_can_log_test";
  Folder() {
    std::filesystem::remove_all(path);
    std::filesystem::create_directories(path);
  }
  ~Folder() { std::filesystem::remove_all(path); }
};

struct OneFrameBus final : CanBus {
  Result<> open() override { return {}; }
  void close() noexcept override {}
  Received receive(CanFrame& into, Duration) noexcept override {
    if (left-- <= 0) return Received::Nothing;
    into = {};
    into.id = 0x566;
    into.arrived_at = 4s;
    return Received::Frame;
  }
  Sent send(const CanFrame&) noexcept override { return full ? Sent::Full : Sent::Yes; }
  CanHealth health() const noexcept override { return {}; }
  int left = 1;
  bool full = false;
};

}  // namespace

TEST_CASE("all that was logged is in the file when the writer is gone", "[can_log]") {
  const Folder folder;
  {
    auto log = CanLogWriter::create(folder.path / "a.log", "can0", 100s);
    REQUIRE(log);
    CanFrame frame;
    frame.id = 0x00b;
    frame.length = 1;
    for (int i = 0; i < 3000; ++i) (*log)->frame(frame, 1s + i * 1ms, Direction::Sent);
    (*log)->note(ShortText("the end"), 5s);
  }
  const auto log = read_candump(folder.path / "a.log");
  REQUIRE(log);
  CHECK(log->frames.size() == 3000);
  CHECK(log->frames.back().frame.arrived_at == 101s + 2999ms);
  REQUIRE(log->notes.size() == 1);
  CHECK(log->notes[0].text == "the end");
  CHECK(log->notes[0].at == 105s);
}

TEST_CASE("what does not fit into the queue is counted, and the file says so", "[can_log]") {
  const Folder folder;
  constexpr int kMany = 200'000;
  std::uint64_t lost = 0;
  {
    auto log = CanLogWriter::create(folder.path / "b.log", "can0", 0s);
    REQUIRE(log);
    for (int i = 0; i < kMany; ++i) (*log)->frame({}, 1s, Direction::Received);
    lost = (*log)->lost();
  }
  const auto log = read_candump(folder.path / "b.log");
  REQUIRE(log);
  CHECK(log->frames.size() + lost == kMany);
  if (lost > 0) {
    REQUIRE_FALSE(log->notes.empty());
    CHECK(log->notes.front().text.find("the queue was full") != std::string::npos);
  }
}

TEST_CASE("a log ends at its limit and remains readable", "[can_log]") {
  const Folder folder;
  {
    auto log = CanLogWriter::create(folder.path / "c.log", "can0", 0s, {.most_bytes = 1000});
    REQUIRE(log);
    for (int i = 0; i < 100; ++i) (*log)->frame({}, 1s, Direction::Received);
  }
  CHECK(std::filesystem::file_size(folder.path / "c.log") < 1100);
  const auto log = read_candump(folder.path / "c.log");
  REQUIRE(log);
  CHECK(log->frames.size() > 20);
  CHECK(log->notes.back().text.find("limit") != std::string::npos);
}

TEST_CASE("a log that exists is kept: the next one has a number", "[can_log]") {
  const Folder folder;
  for (const char* name : {"d.log", "d-2.log", "d-3.log"}) {
    auto log = CanLogWriter::create(folder.path / "d.log", "can0", 0s);
    REQUIRE(log);
    CHECK((*log)->file().filename() == name);
  }
  const auto none = CanLogWriter::create(folder.path / "no" / "such.log", "can0", 0s);
  REQUIRE_FALSE(none);
  CHECK(none.error().code == ErrorCode::BadConfig);
}

TEST_CASE("a logged bus logs what came and what left, not what was refused", "[can_log]") {
  const Folder folder;
  ManualClock clock;
  clock.advance(7s);
  {
    auto log = CanLogWriter::create(folder.path / "e.log", "can0", 0s);
    REQUIRE(log);
    auto inner = std::make_unique<OneFrameBus>();
    OneFrameBus& wire = *inner;
    LoggedCanBus bus(std::move(inner), **log, clock);
    REQUIRE(bus.open());
    CanFrame frame;
    CHECK(bus.receive(frame, 0s) == CanBus::Received::Frame);
    CHECK(bus.receive(frame, 0s) == CanBus::Received::Nothing);
    CHECK(bus.send(frame) == CanBus::Sent::Yes);
    wire.full = true;
    CHECK(bus.send(frame) == CanBus::Sent::Full);
  }
  const auto log = read_candump(folder.path / "e.log");
  REQUIRE(log);
  REQUIRE(log->frames.size() == 2);
  CHECK(log->frames[0].frame.arrived_at == 4s);
  CHECK(log->frames[0].direction == Direction::Received);
  CHECK(log->frames[1].frame.arrived_at == 7s);
  CHECK(log->frames[1].direction == Direction::Sent);
}
