// A session that was recorded against emulated pucks, played to the same driver and the same pucks: equal.
// And what one changed byte of the log does.
#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <thread>

#include "hal/can_log/logged_can_bus.hpp"
#include "hal/drivers/barrett_can/barrett_hand.hpp"
#include "hal/drivers/barrett_can/make_barrett_hand.hpp"
#include "hal/drivers/barrett_can/replay/hand_log.hpp"
#include "hal/drivers/barrett_can/replay/replay_driver.hpp"
#include "hal/os/make_can_bus.hpp"
#include "sim_hal/emulator/hand/hand_gateway.hpp"
#include "sim_hal/emulator/hand/hand_light_plant.hpp"
#include "sim_hal/emulator/hand/hand_lock_step.hpp"
#include "sim_hal/emulator/hand/hand_server.hpp"
#include "tools/bring_up/replay/hand_replay.hpp"

using namespace colift;
using namespace std::chrono_literals;
namespace fs = std::filesystem;

namespace {

struct Folder {
  fs::path path = fs::temp_directory_path() / "colift_hand_replay_test";
  Folder() {
    fs::remove_all(path);
    fs::create_directories(path);
  }
  ~Folder() { fs::remove_all(path); }
};

std::string slurp(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Cold hand, found zeros, preshape, a grip of 0.10 m, release: in lock step, as text.
std::string recorded_in_memory(double asked_nm = 0.6) {
  const Folder folder;
  hal::ManualClock clock;
  clock.advance(1000s);
  sim_hal::MemoryCan can(clock);
  const auto far_end = can.node();
  sim_hal::LightHandPlant plant;
  sim_hal::HandEmulator pucks({}, plant, *far_end);
  REQUIRE(far_end->open());
  REQUIRE(pucks.start(clock.now()));
  const fs::path file = folder.path / "session.log";
  {
    auto log = hal::CanLogWriter::create(file, "can0", 0s);
    REQUIRE(log);
    hal::LoggedCanBus bus(can.node(sim_hal::lock_step(pucks, clock)), **log, clock);
    hal::BarrettHandConfig config;
    config.max_torque_nm = 0.9;  // not the default: it has to be in the log
    hal::note_hand_settings(**log, config, clock);
    hal::LoggedHand hand(std::make_unique<hal::BarrettHand>(bus, config, clock), **log, clock);
    const auto pass = [&](hal::Duration by) {
      for (const auto end = clock.now() + by; clock.now() < end;) {
        sim_hal::run_until(pucks, clock, clock.now() + 1ms);
        (void)hand.state();
        (*log)->flush();
      }
    };
    REQUIRE(hand.configure());
    REQUIRE(hand.activate());
    REQUIRE(hand.preshape(0.4));
    pass(1500ms);
    CHECK_FALSE(hand.close(5.0));  // refused then and now
    plant.put(sim_hal::HandObject::of_width(0.10));
    REQUIRE(hand.close(asked_nm));
    pass(2500ms);
    CHECK(hand.state()->held);
    REQUIRE(hand.release());
    pass(1500ms);
    hand.deactivate();
    CHECK((*log)->lost() == 0);
  }
  return slurp(file);
}

hal::Candump parsed(const std::string& text) {
  auto log = hal::parse_candump(text, "session");
  INFO((log ? std::string() : log.error().text()));
  REQUIRE(log);
  return std::move(*log);
}

hal::DriverReplay played(const hal::Candump& log) {
  auto replay = hal::replay_driver(log, "session");
  INFO((replay ? std::string() : replay.error().text()));
  REQUIRE(replay);
  return std::move(*replay);
}

std::string words(const std::vector<hal::barrett::ReplayDifference>& differences) {
  std::string t;
  for (const auto& d : differences) t += std::to_string(d.line) + ": " + d.words + "\n";
  return t;
}

/// The first line with `what` behind position `from`, its number, and the text with that line replaced.
struct Edit {
  std::string text;
  std::uint32_t line = 0;
};
Edit edited(const std::string& text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  REQUIRE(at != std::string::npos);
  Edit e{text, 1 + static_cast<std::uint32_t>(
                       std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n'))};
  e.text.replace(at, what.size(), by);
  return e;
}

bool names(const std::vector<hal::barrett::ReplayDifference>& differences, std::uint32_t line) {
  return std::any_of(differences.begin(), differences.end(), [&](const auto& d) { return d.line == line; });
}

const std::string& session() {
  static const std::string text = recorded_in_memory();
  return text;
}

}  // namespace

TEST_CASE("a session in lock step is played to the driver and the emulator: equal", "[hand][replay]") {
  const auto log = parsed(session());
  const auto driver = played(log);
  INFO(words(driver.differences));
  CHECK(driver.equal());
  CHECK(driver.calls == 7);
  CHECK(driver.questions > 1000);
  CHECK(driver.settings > 50);
  const auto emulator = tools::replay_emulator(log);
  INFO(words(emulator.differences));
  CHECK(emulator.equal());
  const auto text = tools::replay_text(driver, "", emulator);
  CHECK(text.find("says what was recorded") != std::string::npos);
  CHECK(text.find("STAT") != std::string::npos);
}

TEST_CASE("a session whose second of power-on was rounded otherwise is equal too", "[hand][replay]") {
  using namespace hal::barrett;
  auto log = parsed(session());
  int changed = 0;
  for (auto& line : log.frames) {
    const auto says = decode_request(line.frame);
    const auto answer = read_answer(line.frame);
    const bool set = says && says->sets && says->property == Property::Ds;
    const bool read = changed > 0 && answer && answer->property == Property::Ds;
    if (!set && !read) continue;
    ++line.frame.data[2];
    ++changed;
  }
  REQUIRE(changed == 8);  // four pucks, set and read back
  const auto driver = played(log);
  INFO(words(driver.differences));
  CHECK(driver.equal());
}

TEST_CASE("one byte of a setting is named with its line", "[hand][replay]") {
  // F1: TSTOP = 100 ms of a move
  const Edit e = edited(session(), "00B#CE006400 T", "00B#CE006500 T");
  const auto driver = played(parsed(e.text));
  INFO(words(driver.differences));
  CHECK_FALSE(driver.equal());
  CHECK(names(driver.differences, e.line));
}

TEST_CASE("one byte of an answer's head is named with its line", "[hand][replay]") {
  // F2: STAT = 2 becomes an answer about ERROR, which nobody asked for
  const Edit e = edited(session(), "586#85000200 R", "586#84000200 R");
  const auto log = parsed(e.text);
  CHECK(names(played(log).differences, e.line));
  CHECK(names(tools::replay_emulator(log).differences, e.line));
}

TEST_CASE("an answer of a length or a value that the emulated hand never gives is named", "[hand][replay]") {
  // F3's strain as 32 bits
  const std::size_t at = session().find(" 5A6#9900");
  REQUIRE(at != std::string::npos);
  const std::string answer = session().substr(at, 13);
  const Edit wide = edited(session(), answer, answer + "0000");
  CHECK(names(tools::replay_emulator(parsed(wide.text)).differences, wide.line));
  const Edit beyond = edited(session(), answer, " 5A6#9900FFEF");
  CHECK(names(tools::replay_emulator(parsed(beyond.text)).differences, beyond.line));
}

TEST_CASE("a call that went otherwise then is named", "[hand][replay]") {
  const Edit e = edited(session(), "outcome LimitExceeded", "outcome ok");
  const auto driver = played(parsed(e.text));
  REQUIRE_FALSE(driver.equal());
  CHECK(names(driver.differences, e.line - 1));
  CHECK(words(driver.differences).find("close was ok then") != std::string::npos);
}

TEST_CASE("a hand that says nothing in the log is silent for the driver too", "[hand][replay]") {
  std::string without;
  std::istringstream lines(session());
  for (std::string line; std::getline(lines, line);)
    if (line.find(" 5A6#") == std::string::npos && line.find(" 5A3#") == std::string::npos)
      without += line + "\n";
  const auto driver = played(parsed(without));
  CHECK(words(driver.differences).find("configure was ok then and is LinkLost now") != std::string::npos);
}

TEST_CASE("a scan is of one question, also where pads are slower than they are asked", "[hand][replay]") {
  // F1: TACT = 2, at milliseconds, and rows of its full scan
  std::string text;
  const auto at = [](int ms) { return "(1." + std::to_string(1000 + ms).substr(1) + "000) can0 "; };
  const auto ask = [&](int ms) { text += at(ms) + "00B#EA000200 T\n"; };
  const auto scan = [&](int ms, int rows) {
    for (int row = 0; row < rows; ++row)
      text += at(ms + row) + "569#" + std::to_string(row) + "000000000000000 R\n";
  };
  const auto counts = [&] {
    std::vector<int> all;
    for (const auto& request : hal::barrett::read_puck_session(parsed(text).frames).requests)
      all.push_back(request.answers.at(0).count);
    return all;
  };
  ask(0);
  ask(300);
  SECTION("one that begins within half a second of its question, and ends after it") {
    scan(498, 5);
    CHECK(counts() == std::vector{5, 0});
  }
  SECTION("one that begins later than that") {
    scan(501, 5);
    CHECK(counts() == std::vector{0, 5});
  }
  SECTION("one that was cut off gets nothing of the next") {
    scan(310, 3);
    scan(350, 5);
    CHECK(counts() == std::vector{3, 5});
  }
}

TEST_CASE("logs that no driver can be asked about are refused in words", "[hand][replay]") {
  const auto plain = hal::replay_driver(parsed("(1.000000) can0 405#05\n"), "session");
  REQUIRE_FALSE(plain);
  CHECK(plain.error().code == hal::ErrorCode::NotFound);
  for (const char* note :
       {"# (1.000000) call dance", "# (1.000000) call close", "# (1.000000) call close nan",
        "# (1.000000) clock -3", "# (1.000000) config reply_ms: -8"}) {
    INFO(note);
    const auto bad =
        hal::replay_driver(parsed(std::string("(1.000000) can0 405#05\n") + note + "\n"), "session");
    REQUIRE_FALSE(bad);
    CHECK(bad.error().code == hal::ErrorCode::BadInput);
  }
}

TEST_CASE("a log that ends in the middle of a scan is not a hand that lost rows", "[hand][replay]") {
  const std::string rows = " 569#";               // F1's, five in a row
  const auto cut_behind = [&](std::size_t row) {  // the second row there
    return session().substr(0, session().find('\n', session().find(rows, row + 1)) + 1);
  };
  SECTION("the last line is its second row") {
    std::size_t row = session().rfind(rows);
    for (int k = 0; k < 4; ++k) row = session().rfind(rows, row - 1);
    const auto emulator = tools::replay_emulator(parsed(cut_behind(row)));
    INFO(words(emulator.differences));
    CHECK(emulator.equal());
  }
  SECTION("where the log goes on, the rows are missing") {
    const std::size_t row = session().find(rows, session().size() / 2), end = session().find('\n', row);
    std::string text = session().substr(0, end + 1);
    std::istringstream later(session().substr(end + 1));
    int left_out = 0;
    for (std::string line; std::getline(later, line);)
      if (left_out == 3 || line.find(rows) == std::string::npos || line.find("#0", 20) != std::string::npos)
        text += line + "\n";
      else
        ++left_out;
    CHECK_FALSE(tools::replay_emulator(parsed(text)).equal());
  }
}

namespace {

/// How late a thread of this process was woken at worst, from its making to stop(), s.
class WakeUps {
 public:
  ~WakeUps() { stop(); }
  double stop() {
    ended_ = true;
    if (thread_.joinable()) thread_.join();
    return worst_s_;
  }

 private:
  std::atomic<bool> ended_ = false;
  double worst_s_ = 0.0;
  std::thread thread_{[this] {
    const hal::SteadyClock clock;
    for (auto last = clock.now(); !ended_; last = clock.now()) {
      std::this_thread::sleep_for(1ms);
      worst_s_ = std::max(worst_s_, hal::seconds(clock.now() - last) - 1e-3);
    }
  }};
};

struct RealSession {
  bool through = false;
  double worst_late_s = 0.0;  ///< of the threads of the hand's server, and of any thread
};

RealSession record_over_gateway(const fs::path& file) {
  RealSession session;
  WakeUps wake_ups;
  sim_hal::HandEmulatorConfig emulated;
  emulated.puck.awake = true;
  auto plant = std::make_unique<sim_hal::LightHandPlant>();
  plant->put(sim_hal::HandObject::of_width(0.10));
  auto gate = std::make_unique<sim_hal::HandGateway>(sim_hal::HandGatewayConfig{"127.0.0.1", 0, "can0"});
  const sim_hal::HandGateway& gateway = *gate;
  sim_hal::HandServer server(emulated, std::move(plant), std::move(gate));
  REQUIRE(server.start());
  hal::BarrettHandConfig config;
  config.can = "socketcand:127.0.0.1:" + std::to_string(gateway.port()) + "/can0";
  config.bus_log = file.string();
  auto bus = hal::make_can_bus(config.can);
  auto log = hal::make_bus_log(config);
  REQUIRE(bus);
  REQUIRE(log);
  const auto hand = hal::make_barrett_hand(std::move(*bus), config, std::move(*log));
  REQUIRE(hand->configure());
  const hal::SteadyClock clock;
  const auto in_time = [&](const auto& happens) {
    for (const auto until = clock.now() + 20s; clock.now() < until; std::this_thread::sleep_for(1ms))
      if (happens()) return true;
    return false;
  };
  const auto state_is = [&](const auto& fact) {
    const auto state = hand->state();
    return state && fact(*state);
  };
  session.through = in_time([&] { return hand->activate().has_value(); }) &&
                    in_time([&] { return hand->close(0.5).has_value(); }) &&
                    in_time([&] { return state_is([](const hal::HandState& now) { return now.held; }); }) &&
                    in_time([&] { return hand->release().has_value(); }) &&
                    in_time([&] { return state_is([](const hal::HandState& now) { return !now.moving; }); });
  hand->deactivate();
  session.worst_late_s = std::max(wake_ups.stop(), 1e-3 * server.timing().worst_late_ms);
  return session;
}

}  // namespace

// While a computer stands still, the driver is late with everything and may give up; no replay is late. Such
// a session says nothing about the replay: another one is recorded.
TEST_CASE("a session over the gateway, in real time, is played both ways: equal", "[hand][replay][server]") {
  constexpr double kStoodStill_s = 0.05;
  constexpr int kMost = 5;
  const Folder folder;
  const fs::path file = folder.path / "gateway.log";
  for (int recorded = 1; recorded <= kMost; ++recorded) {
    fs::remove(file);
    const RealSession session = record_over_gateway(file);
    const auto log = hal::read_candump(file);
    INFO((log ? std::string() : log.error().text()));
    REQUIRE(log);
    CHECK(log->interface == "can0");
    const auto driver = hal::replay_driver(*log, "session");
    const auto emulator = tools::replay_emulator(*log);
    const bool equal = session.through && driver && driver->equal() && emulator.equal();
    if (!equal && session.worst_late_s > kStoodStill_s) {
      WARN("session " << recorded << ": the computer stood still for " << session.worst_late_s
                      << " s: not compared");
      continue;
    }
    CHECK(session.through);
    REQUIRE(driver);
    INFO(words(driver->differences));
    INFO(words(emulator.differences));
    CHECK(driver->equal());
    CHECK(emulator.equal());
    return;
  }
}
