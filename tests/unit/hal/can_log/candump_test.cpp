// The format of candump -L, both ways.
#include "hal/can_log/candump.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

using namespace colift::hal;
using namespace std::chrono_literals;
using Direction = CandumpFrame::Direction;

namespace {

std::string refusal(const std::string& text) {
  const auto log = parse_candump(text, "log");
  return log ? std::string() : log.error().text();
}

}  // namespace

TEST_CASE("a log of candump is read: times, bytes, directions, notes, error frames", "[can_log]") {
  const auto log = parse_candump(
      "# recorded on a Tuesday\n"
      "(1700000000.000001) can0 00B#30 T\n"
      "(1700000000.000500)   can0 563#82F9B88130B0 R\r\n"
      "\n"
      "(1700000000.000600) can0 20000004#000C000000000000\n"
      "# (1700000000.250000) call close 0.5\n"
      "(1700000001.000000) can0 405#",
      "log");
  REQUIRE(log);
  REQUIRE(log->frames.size() == 3);
  CHECK(log->interface == "can0");
  CHECK(log->error_frames == 1);
  CHECK(log->frames[0].frame.id == 0x00b);
  CHECK(log->frames[0].frame.length == 1);
  CHECK(log->frames[0].frame.arrived_at == 1'700'000'000s + 1us);
  CHECK(log->frames[0].direction == Direction::Sent);
  CHECK(log->frames[1].direction == Direction::Received);
  CHECK(log->frames[1].frame.data[5] == 0xb0);
  CHECK(log->frames[1].line == 3);
  CHECK(log->frames[2].frame.length == 0);
  CHECK(log->frames[2].direction == Direction::Unknown);
  REQUIRE(log->notes.size() == 2);
  CHECK(log->notes[0].text == "recorded on a Tuesday");
  CHECK(log->notes[1].text == "call close 0.5");
  CHECK(log->notes[1].at == 1'700'000'000s + 250ms);
}

TEST_CASE("what was written is read as it was", "[can_log]") {
  CanFrame frame;
  frame.id = 0x5a6;
  frame.length = 8;
  frame.data = {0xff, 0, 1, 2, 3, 4, 5, 0xfe};
  std::array<char, 96> line{};
  const std::size_t n =
      write_candump(line, "a_very_long_name_of_a_bus", frame, 12s + 345678us, Direction::Sent);
  const auto log = parse_candump({line.data(), n}, "log");
  REQUIRE(log);
  CHECK(log->interface == "a_very_long_nam");
  CHECK(log->frames.at(0).frame == frame);
  CHECK(log->frames.at(0).frame.arrived_at == 12s + 345678us);
  CHECK(log->frames.at(0).direction == Direction::Sent);
}

TEST_CASE("frames that were read late stand in the order of their times", "[can_log]") {
  const auto log =
      parse_candump("(2.500000) can0 00B#30\n(2.000000) can0 563#000000\n(2.500000) can0 00C#30\n", "log");
  REQUIRE(log);
  CHECK(log->frames[0].line == 2);
  CHECK(log->frames[1].line == 1);
  CHECK(log->frames[2].line == 3);
}

TEST_CASE("a line that is no frame is refused, with its number and what is wrong", "[can_log]") {
  const std::string good = "(1.000000) can0 00B#30\n";
  CHECK(refusal(good).empty());
  CHECK(refusal("").empty());
  const std::array<std::pair<const char*, const char*>, 17> bad{{
      {"(1.0) can0 00B#30", "SECONDS.MICROSECONDS"},
      {"1.000000 can0 00B#30", "SECONDS.MICROSECONDS"},
      {"(-1.000000) can0 00B#30", "SECONDS.MICROSECONDS"},
      {"(99999999999.000000) can0 00B#30", "SECONDS.MICROSECONDS"},
      {"(1.000000) can0 00B30", "no #"},
      {"(1.000000) can0 800#30", "above 7FF"},
      {"(1.000000) can0 B#30", "three hexadecimal"},
      {"(1.000000) can0 00G#30", "three hexadecimal"},
      {"(1.000000) can0 0000000B#30", "29-bit"},
      {"(1.000000) can0 00B##130", "FD"},
      {"(1.000000) can0 00B#R", "remote"},
      {"(1.000000) can0 00B#303", "eight bytes"},
      {"(1.000000) can0 00B#303030303030303030", "eight bytes"},
      {"(1.000000) can0 00B#3x", "no byte"},
      {"(1.000000) can0 00B#30 X", "R or T"},
      {"(1.000000) can1 00B#30", "one bus"},
      {"# \x01", "no text"},
  }};
  for (const auto& [line, why] : bad) {
    INFO(line);
    const std::string said = refusal(good + line + "\n");
    CHECK(said.find("log:2:") == 0);
    CHECK(said.find(why) != std::string::npos);
  }
  CHECK(refusal("(5.000000) can0 00B#30\n(3.900000) can0 00B#30\n").find("before") != std::string::npos);
  CHECK(refusal("#" + std::string(600, 'x')).find("characters") != std::string::npos);
}

TEST_CASE("a file that is none, or a bad one, is an error of the file", "[can_log]") {
  CHECK_FALSE(read_candump("no/such/file.log"));
  CHECK_FALSE(read_candump("."));
  int files = 0;
  for (const auto& file : std::filesystem::directory_iterator(COLIFT_TEST_DATA "/bad")) {
    if (file.path().extension() != ".candump") continue;
    ++files;
    INFO(file.path());
    CHECK_FALSE(read_candump(file.path()));
  }
  CHECK(files >= 4);
}
