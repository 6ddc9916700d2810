#include "sim_hal/emulator/krc/krc_faults.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "fri_peer.hpp"

using namespace colift;
using namespace colift::sim_hal;
using test::Bench;
using test::Seen;

namespace {

/// A session with a fault `after_s` after command mode was reached.
struct Faulty : Bench {
  explicit Faulty(const std::string& kind, double after_s = 0.1, bool restart = false)
      : Bench(config(restart)) {
    REQUIRE(krc->start(clock.now()));
    REQUIRE(command());
    at_s = hal::seconds(clock.now()) + after_s;
    krc->inject(parse_krc_fault(std::to_string(at_s) + ":" + kind).value());
  }
  static KrcConfig config(bool restart) {
    KrcConfig c = stanford();
    if (restart) c.restart_s = 0.5;
    return c;
  }
  /// Answers until some time after the fault's beginning.
  void live(double s) {
    while (hal::seconds(clock.now()) < at_s + s) turn();
  }
  double at_s = 0.0;
};

}  // namespace

TEST_CASE("a fault is read from one line", "[krc]") {
  const auto f = parse_krc_fault("4.5:loss.in=20%:2");
  REQUIRE(f);
  CHECK(f->kind == KrcFault::Kind::Loss);
  CHECK(f->way == KrcFault::Direction::ToKrc);
  CHECK(f->at_s == 4.5);
  CHECK(f->for_s == 2.0);
  CHECK(f->value == 20.0);
  CHECK(f->percent);
  CHECK(parse_krc_fault("0:quality=bad")->value == 1.0);
  CHECK(parse_krc_fault("1:jump=0.1@2")->joint == 1);
  CHECK(parse_krc_fault("1:loss=3")->counted);
  CHECK(parse_krc_fault("1:estop:3")->for_s == 3.0);
  CHECK(krc_fault({2.0, "arm", "unplug", 0.5})->kind == KrcFault::Kind::Unplug);
}

TEST_CASE("what is no fault is refused with what was expected", "[krc]") {
  for (const auto& [text, part] : std::vector<std::pair<std::string, std::string>>{
           {"loss", "expected T:KIND"},
           {"x:loss", "the time is \"x\""},
           {"-1:loss", "the time"},
           {"1:", "there are loss, delay"},
           {"1:lost", "there are loss, delay"},
           {"1:loss:0", "the duration"},
           {"1:loss:nan", "the duration"},
           {"1:loss=101%", "from 0 to 100"},
           {"1:delay=5%", "takes no percentage"},
           {"1:monitor=2", "takes no value"},
           {"1:monitor.in", "neither .in nor .out"},
           {"1:jump@8", "expected 1 to 7"},
           {"1:quality=good", "the value of quality"},
       }) {
    CAPTURE(text);
    const auto f = parse_krc_fault(text);
    REQUIRE_FALSE(f);
    CHECK(f.error().code == hal::ErrorCode::BadInput);
    CHECK(f.error().text().find(part) != std::string::npos);
  }
  CHECK(krc_fault({2.0, "arm", "blind", 0.5}).error().code == hal::ErrorCode::BadConfig);
}

TEST_CASE("up to three lost datagrams in a row are bridged, either way", "[krc]") {
  for (const char* kind : {"loss.in=3", "loss.out=3", "loss=3"}) {
    CAPTURE(kind);
    Faulty b(kind);
    b.live(0.5);
    CHECK(b.last.state() == 2);
    CHECK(b.krc->report().missed == 3);
    CHECK(b.krc->report().most_missed_in_a_row == 3);
    CHECK(b.broken().empty());
  }
}

TEST_CASE("more of them end command mode, and the client is not blamed", "[krc]") {
  for (const char* kind : {"loss.in=4", "loss.out=4", "loss:0.1", "silent:0.1", "drop:0.1", "loss=60%:1"}) {
    CAPTURE(kind);
    Faulty b(kind);
    b.live(1.0);
    CHECK(b.last.state() == 1);
    CHECK(b.last.power() == 0);
    CHECK(b.broken().empty());
    CHECK(b.krc->report().mode_changes.size() == 3);
    CHECK(b.was_told("fault begins"));
  }
}

TEST_CASE("random loss loses its share, the same for the same seed", "[krc]") {
  const auto missed = [](std::uint64_t seed) {
    KrcConfig config = Bench::stanford();
    config.seed = seed;
    config.faults.push_back(parse_krc_fault("0:loss.in=10%:100").value());
    Bench b(config);
    REQUIRE(b.krc->start(b.clock.now()));
    std::vector<std::uint64_t> path;
    for (int i = 0; i < 20; ++i) {
      b.turns(100);
      path.push_back(b.krc->report().missed);
    }
    return path;
  };
  const auto path = missed(1);
  CHECK(path.back() > 150);
  CHECK(path.back() < 250);
  CHECK(missed(1) == path);
  CHECK(missed(2) != path);
}

TEST_CASE("delayed, doubled and swapped answers", "[krc]") {
  SECTION("a short delay costs latency only") {
    Faulty b("delay.in=1:5");
    b.live(1.0);
    CHECK(b.last.state() == 2);
    CHECK(b.last.get<float>(164) == Approx(0.0012).margin(1e-6));
    CHECK(b.krc->report().missed == 0);
  }
  SECTION("a delay of more than a cycle makes all answers late") {
    Faulty b("delay.in=3:5");
    b.live(1.0);
    CHECK(b.last.state() == 1);
    CHECK(b.krc->report().late > 100);
    CHECK(b.krc->report().mode_changes.back().reason.find("4 answers in a row") != std::string::npos);
  }
  SECTION("doubled answers are counted once") {
    Faulty b("duplicate.in:1");
    b.live(0.5);
    CHECK(b.last.state() == 2);
    CHECK(b.krc->report().duplicate >= 195);
    CHECK(b.krc->report().missed == 0);
  }
  SECTION("doubled measurements are answered twice") {
    Faulty b("duplicate.out:1");
    b.live(0.5);
    CHECK(b.last.state() == 2);
  }
  SECTION("swapped neighbours: every second answer is late, the older one is not used") {
    Faulty b("reorder.in:0.1");
    b.live(0.5);
    CHECK(b.krc->report().reordered >= 20);
  }
  SECTION("a burst is a gap and then all at once") {
    Faulty b("burst.in=3:0.03");
    b.live(0.5);
    CHECK(b.last.state() == 2);
    CHECK(b.krc->report().late > 0);
    CHECK(b.krc->report().most_missed_in_a_row <= 3);
  }
  SECTION("spoiled answers are refused or judged, and not the client's fault") {
    Faulty b("corrupt.in:2");
    b.live(1.0);
    CHECK(b.broken().empty());
    CHECK(b.krc->report().rejected.size() > 1);
  }
}

TEST_CASE("spoiled measurements differ from good ones", "[krc]") {
  Faulty b("corrupt.out=50%:1");
  int spoiled = 0, all = 0;
  while (hal::seconds(b.clock.now()) < b.at_s + 0.9) {
    const auto m = b.receive();
    if (!m) continue;
    if (hal::seconds(b.clock.now()) < b.at_s) {
      b.reply(b.answer(*m));
      continue;
    }
    ++all;
    if (m->bytes.size() != 916) ++spoiled;
  }
  // a quarter of them is cut short
  CHECK(spoiled > all / 20);
  CHECK(spoiled < all / 4);
}

TEST_CASE("emergency stop and drive errors: at once, without drives", "[krc]") {
  for (const char* kind : {"emergency-stop:0.3", "drive-error@5:0.3"}) {
    CAPTURE(kind);
    Faulty b(kind);
    b.live(0.2);
    CHECK(b.last.state() == 1);
    CHECK(b.last.power() == 0);
    CHECK(b.last.get<std::uint16_t>(184) == (kind[0] == 'd' ? 1 << 4 : 0));
    CHECK(b.broken().empty());
    b.live(0.5);
    CHECK(b.last.get<std::uint16_t>(184) == 0);
    CHECK(b.last.power() == 0);
  }
}

TEST_CASE("with an operator the session can begin again after an emergency stop", "[krc]") {
  Faulty b("estop:0.3", 0.1, true);
  b.live(0.2);
  b.from_int[15] = 20;
  b.live(1.5);
  CHECK(b.command());
}

TEST_CASE("forced to monitor mode the drives stay on, and a new start is possible", "[krc]") {
  Faulty b("monitor:0.1");
  b.live(0.3);
  CHECK(b.last.state() == 1);
  CHECK(b.last.power() == 0x7F);
  CHECK(b.was_told("command mode left: monitor mode was forced"));
  b.from_int[15] = 20;
  b.turns(300);
  CHECK(b.command());
}

TEST_CASE("forced quality shows, and below bad it ends command mode", "[krc]") {
  Faulty bad("quality=bad:0.2");
  bad.live(0.1);
  CHECK(bad.last.quality() == 1);
  CHECK(bad.last.state() == 2);
  bad.live(0.4);
  CHECK(bad.last.quality() == 3);
  Faulty none("quality=unacceptable:0.2");
  none.live(0.1);
  CHECK(none.last.state() == 1);
  CHECK(none.broken().empty());
}

TEST_CASE("drives off in command mode: who goes on moving breaks a rule, who mirrors does not", "[krc]") {
  for (const bool moves : {false, true}) {
    Faulty b("drives-off:0.3");
    b.live(0.05);
    CHECK(b.last.power() == 0);
    CHECK(b.last.state() == 2);
    if (moves) {
      hal::JointVector q = b.last.q_total();
      for (int i = 0; i < 20; ++i) {
        q[0] += 0.001;
        b.q = q;
        b.turn();
      }
    }
    b.live(0.5);
    CHECK(b.broken() == (moves ? "moved-without-power" : ""));
    CHECK(b.last.state() == (moves ? 1 : 2));
    if (!moves) CHECK(b.last.power() == 0x7F);
  }
}

TEST_CASE("what the controller measures can be wrong", "[krc]") {
  const auto look = [](const std::string& kind, auto check) {
    CAPTURE(kind);
    Faulty b(kind + ":0.3");
    b.live(0.0);
    const Seen before = b.last;
    b.live(0.1);
    check(before, b.last);
    b.live(0.5);
    CHECK((b.last.q() - before.q()).norm() < 1e-4);
    CHECK(b.last.state() == 2);
    CHECK(b.broken().empty());
  };
  look("jump=0.2@2", [](const Seen& was, const Seen& is) { CHECK(is.q()[1] - was.q()[1] == Approx(0.2)); });
  look("nan@6", [](const Seen&, const Seen& is) { CHECK(std::isnan(is.q()[5])); });
  look("temperature=85", [](const Seen&, const Seen& is) { CHECK(is.get<float>(188 + 24) == 85.0f); });
  look("drive-warning@1", [](const Seen&, const Seen& is) { CHECK(is.get<std::uint16_t>(186) == 1); });
  look("torque-offset=6@2", [](const Seen& was, const Seen& is) {
    CHECK(is.joints(444)[1] - was.joints(444)[1] == Approx(6.0).margin(0.01));
    CHECK(is.joints(472)[1] - was.joints(472)[1] == Approx(-6.0).margin(0.01));
  });
  look("freeze", [](const Seen&, const Seen& is) {
    CHECK(is.get<float>(140) < is.send() * 0.002 - 0.05);  // the time stands still, the counter does not
  });
}

TEST_CASE("switched off and on the controller is silent, then begins anew", "[krc]") {
  Faulty b("unplug:1.0");
  int silent = 0, first = 0;
  while (hal::seconds(b.clock.now()) < b.at_s + 1.3) {
    if (const auto m = b.turn()) {
      if (silent > 0 && first == 0) first = m->send();
    } else {
      ++silent;
    }
  }
  CHECK(silent >= 3);
  CHECK(first == 1);
  CHECK(b.last.state() == 1);
  CHECK(b.last.power() == 0x7F);
  b.from_int[15] = 20;
  b.turns(50);
  CHECK(b.command());
}

TEST_CASE("every fault of the arm that a scenario may name is one of the emulator's", "[krc]") {
  const auto with = [](const std::string& device, const std::string& what) {
    return parse_scenario(
        "schema: colift.scenario/1\n"
        "object: {kind: box, size: [0.6, 0.3, 0.2], mass: 3, pose: {xyz: [0.8, 0, 0]}}\n"
        "partner: {kind: none}\n"
        "faults: [{at_s: 1.5, device: " +
            device + ", do: " + what + ", for_s: 0.25}]\n",
        "s.yaml");
  };
  for (const char* what :
       {"freeze",      "drop",          "unplug",     "corrupt",     "late",    "silent",  "loss",
        "delay",       "reorder",       "duplicate",  "burst",       "quality", "monitor", "emergency-stop",
        "drive-error", "drive-warning", "drives-off", "temperature", "jump",    "nan",     "torque-offset",
        "contact"}) {
    CAPTURE(what);
    const auto scenario = with("arm", what);
    if (!scenario) FAIL(scenario.error().text());
    const auto fault = krc_fault(scenario->faults.front());
    REQUIRE(fault);
    CHECK(fault->at_s == 1.5);
    CHECK(fault->for_s == 0.25);
  }
  const auto refused = with("hand", "emergency-stop");
  REQUIRE_FALSE(refused);
  CHECK(refused.error().detail.find("only an arm can do") != std::string::npos);
}
