// The sessions of tests/data/hand_sessions: what driver and emulated hand say today is what was recorded, or
// listed with its reason. And that one byte is enough to be noticed.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "accepted_differences.hpp"
#include "hal/drivers/barrett_can/pucks/puck_codec.hpp"
#include "hal/drivers/barrett_can/replay/puck_session.hpp"

using namespace colift;
namespace fs = std::filesystem;

namespace {

constexpr std::size_t kAllOfThem = 200;  // what is not listed cannot be accepted

std::vector<fs::path> files_with(const std::string& extension) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(fs::path(COLIFT_TEST_DATA) / "hand_sessions"))
    if (entry.path().extension() == extension) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

hal::Candump read(const fs::path& file) {
  auto log = hal::read_candump(file);
  INFO((log ? std::string() : log.error().text()));
  REQUIRE(log);
  return std::move(*log);
}

std::vector<AcceptedDifference> accepted_of(const fs::path& session) {
  std::ifstream in(fs::path(session).replace_extension(".differences"));
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  auto accepted = read_accepted(text, session.stem().string() + ".differences");
  INFO((accepted ? std::string() : accepted.error().text()));
  REQUIRE(accepted);
  return std::move(*accepted);
}

/// What is left of a session's differences. A log without calls is for the emulated hand alone.
std::string judged(const hal::Candump& log, const std::vector<AcceptedDifference>& accepted) {
  std::optional<hal::DriverReplay> driver;
  if (auto played = hal::replay_driver(log, "session"))
    driver = std::move(*played);
  else if (played.error().code != hal::ErrorCode::NotFound)
    return played.error().text();
  return judge_kept(accepted, driver, tools::replay_emulator(log, kAllOfThem));
}

bool is_named(const std::string& differences, std::uint32_t line, const std::string& side) {
  return ("\n" + differences).find("\nline " + std::to_string(line) + ": " + side + ": ") !=
         std::string::npos;
}

/// Two thirds into the session, behind waking and looking.
template <class Is>
hal::CandumpFrame& one_of(hal::Candump& log, const Is& is) {
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < log.frames.size(); ++i)
    if (is(log.frames[i])) found.push_back(i);
  REQUIRE_FALSE(found.empty());
  return log.frames[found[found.size() * 2 / 3]];
}

bool is_setting(const hal::CandumpFrame& f) {
  const auto says = hal::barrett::decode_request(f.frame);
  // of DS one second more or less is no difference
  return f.direction == hal::CandumpFrame::Direction::Sent && says && says->sets &&
         says->property != hal::barrett::Property::Ds;
}

bool is_value(const hal::CandumpFrame& f) {
  const auto answer = hal::barrett::read_answer(f.frame);
  return f.direction == hal::CandumpFrame::Direction::Received && answer && answer->value &&
         answer->property != hal::barrett::Property::P;
}

}  // namespace

TEST_CASE("a kept session of the hand is played as it was recorded, or as its listed differences say",
          "[hand][replay]") {
  const auto sessions = files_with(".log");
  CHECK(sessions.size() >= 6);
  for (const fs::path& session : sessions) {
    const hal::Candump log = read(session);
    const std::string differences = judged(log, accepted_of(session));
    INFO(session.filename().string()
         << ": meant? tests/data/hand_sessions/README.md says what to do with these differences:\n"
         << differences);
    CHECK(differences.empty());
  }
  for (const fs::path& list : files_with(".differences")) {
    INFO(list.filename().string());
    CHECK(fs::exists(fs::path(list).replace_extension(".log")));
  }
}

TEST_CASE("a kept session is played twice alike, to the last question", "[hand][replay]") {
  for (const fs::path& session : files_with(".log")) {
    const hal::Candump log = read(session);
    const auto text = [&] {
      auto driver = hal::replay_driver(log, "session");
      std::optional<hal::DriverReplay> played;
      if (driver) played = std::move(*driver);
      return tools::replay_document("session", played, "", tools::replay_emulator(log));
    };
    INFO(session.filename().string());
    CHECK(text() == text());
  }
}

TEST_CASE("one byte of a setting in a kept session is named with its line", "[hand][replay]") {
  for (const fs::path& session : files_with(".log")) {
    hal::Candump log = read(session);
    if (!hal::replay_driver(log, "session")) continue;  // without calls nobody says the setting
    auto& setting = one_of(log, is_setting);
    setting.frame.data[2] ^= 1;
    const std::string differences = judged(log, accepted_of(session));
    INFO(session.filename().string() << ", line " << setting.line << ":\n" << differences);
    CHECK(is_named(differences, setting.line, "driver"));
  }
}

TEST_CASE("one byte of an answer in a kept session is named with its line", "[hand][replay]") {
  for (const fs::path& session : files_with(".log")) {
    hal::Candump log = read(session);
    auto& answer = one_of(log, is_value);
    answer.frame.data[0] = 0x80 | static_cast<std::uint8_t>(hal::barrett::Property::Vbus);  // never asked
    const std::string differences = judged(log, accepted_of(session));
    INFO(session.filename().string() << ", line " << answer.line << ":\n" << differences);
    CHECK(is_named(differences, answer.line, "emulator"));
    if (hal::replay_driver(log, "session")) CHECK(is_named(differences, answer.line, "driver"));
  }
}

TEST_CASE("a listed difference is accepted as long as it occurs, and no other", "[hand][replay]") {
  hal::DriverReplay driver;
  driver.differences = {{7, "F1: MT = 2200 is said 0.61 s later than recorded"}, {9, "F1: P? is new"}};
  tools::EmulatorReplay emulator;
  emulator.differences = {{12, "F2 SG: 586 with 6 bytes, the emulated hand answers as 586 with 4"}};
  const auto judge = [&](const std::string& text) {
    const auto accepted = read_accepted(text, "a.differences");
    INFO((accepted ? std::string() : accepted.error().text()));
    REQUIRE(accepted);
    return judge_kept(*accepted, driver, emulator);
  };
  const std::string all =
      "# of one evening\n\n"
      "driver   F1: MT = * later  # this hand is slow\n"
      "driver   F1: P?            # asked since 1.3\n"
      "emulator F[123] SG: * with 6 bytes # its firmware answers wide\n";
  CHECK(judge(all).empty());
  CHECK(judge("").find("line 9: driver: F1: P? is new\n") != std::string::npos);
  CHECK(judge("").find("line 12: emulator: F2 SG") != std::string::npos);
  // of the other side it is another difference
  CHECK(is_named(judge("emulator F1: MT # slow\n"), 7, "driver"));

  driver.differences.pop_back();
  CHECK(judge(all) == "accepted in line 4, occurs no more: driver F1: P?\n");
  emulator.more = 3;
  CHECK(judge(all).find("emulator: 3 differences more than can be listed") != std::string::npos);
}

TEST_CASE("a difference is listed with its side and a reason", "[hand][replay]") {
  for (const char* line : {"driver F1: MT", "driver F1: MT #", "driver # why", "hand F1: MT # why", "driver",
                           "F1: MT = 3 # why", "driver# why"}) {
    INFO(line);
    const auto accepted = read_accepted(std::string("\n") + line + "\n", "a.differences");
    REQUIRE_FALSE(accepted);
    CHECK(accepted.error().where == "a.differences:2");
  }
}
