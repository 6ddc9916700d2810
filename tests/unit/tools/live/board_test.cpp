#include "tools/live/board.hpp"
#include "tools/live/hub.hpp"

#include <catch2/catch.hpp>
#include <string>

using namespace colift;
using namespace colift::live;
using telemetry::Publication;
using telemetry::Topic;

namespace {

Publication message(Topic topic, int number, int* encoded = nullptr) {
  return {topic, hal::Timestamp(number), [number, encoded] {
            if (encoded) ++*encoded;
            return std::to_string(number);
          }};
}

}  // namespace

TEST_CASE("who comes late gets the newest of everything, and the log's history") {
  Board board;
  for (int i = 0; i < 1000; ++i) {
    board.put(message(Topic::Scene, i));
    board.put(message(Topic::Log, i));
  }
  REQUIRE(board.history(Topic::Scene).size() == 1);
  CHECK(board.history(Topic::Scene).front()->text() == "999");
  REQUIRE(board.history(Topic::Log).size() == rule_of(Topic::Log).history);
  CHECK(board.history(Topic::Log).back()->text() == "999");
  CHECK(board.history(Topic::Plan).empty());
}

TEST_CASE("who comes late gets no pose of an object that nobody sees any more, but the robot's model") {
  Board board;
  CHECK(board.put(message(Topic::Tracked, 1)) != nullptr);
  board.put(message(Topic::Description, 2));
  CHECK(board.history(Topic::Tracked).empty());
  REQUIRE(board.history(Topic::Description).size() == 1);
  Outbox box;  // of one that still waits, only the newest
  for (int i = 0; i < 10; ++i) box.push(Topic::Tracked, std::to_string(i));
  CHECK(box.take().message == "9");
  CHECK(box.empty());
}

TEST_CASE("a server that gets no processor for long forgets what comes all the time, not what lasts") {
  Hub hub({}, PageFiles("/nowhere"));
  CHECK(hub.hand_in(message(Topic::Description, 1)));
  CHECK_FALSE(hub.hand_in(message(Topic::Map, 2)));
  for (int i = 0; i < 50000; ++i) CHECK_FALSE(hub.hand_in(message(Topic::Joints, i)));
  hub.pass_on();
  REQUIRE(hub.board().history(Topic::Description).size() == 1);
  CHECK(hub.board().history(Topic::Map).size() == 1);
  CHECK(hub.board().history(Topic::Joints).front()->text() == "49999");
  CHECK(hub.dropped.load() > 40000u);
  // even of nothing but these there is an end
  for (int i = 0; i < 50000; ++i) (void)hub.hand_in(message(Topic::Scene, i));
  CHECK(hub.dropped.load() > 80000u);
}

TEST_CASE("a message is made when it is wanted, and once") {
  Board board;
  int encoded = 0;
  const auto post = board.put(message(Topic::Cloud, 1, &encoded));
  CHECK(encoded == 0);
  CHECK(post->text() == "1");
  CHECK(post->text() == "1");
  CHECK(encoded == 1);
}

TEST_CASE("what is for recordings alone is not live") {
  Board board;
  CHECK(board.put(message(Topic::Depth, 1)) == nullptr);
  CHECK(board.put(message(Topic::Inputs, 1)) == nullptr);
}

TEST_CASE("a slow client sees fewer pictures, the newest ones, and every change of state") {
  Outbox box;
  for (int i = 0; i < 100; ++i) box.push(Topic::Transforms, std::to_string(i));
  for (int i = 0; i < 3; ++i) box.push(Topic::Change, std::to_string(i));
  CHECK(box.take().message == "99");
  for (const char* expected : {"0", "1", "2"}) CHECK(box.take().message == expected);
  CHECK(box.empty());
  CHECK(box.dropped() == 99);
}

TEST_CASE("of the robot's time only the newest waits, and it takes nobody's place") {
  Outbox box;
  box.push_control("hello", false);
  for (int i = 0; i < 100000; ++i) box.push_time(std::to_string(i));
  box.push(Topic::Status, "s");
  CHECK_FALSE(box.hopeless());
  CHECK(box.take().message == "hello");
  CHECK(box.take().message == "99999");
  CHECK(box.take().message == "s");
  CHECK(box.empty());
  box.push_time("later");
  CHECK(box.take().binary);
}

TEST_CASE("a client that reads nothing costs a bounded amount of memory") {
  Outbox box;
  for (int i = 0; i < 100000; ++i) box.push(Topic::Log, std::to_string(i));
  std::size_t count = 0;
  std::string last;
  while (!box.empty()) {
    last = box.take().message;
    ++count;
  }
  CHECK(count <= 400);
  CHECK(last == "99999");
  for (int i = 0; i < 1000; ++i) box.push_control("x", false);
  CHECK(box.hopeless());
}
