// When the capture process is killed and started anew, in a test's time.

#include <catch2/catch.hpp>

#include "hal/drivers/capture_link/capture_monitor.hpp"
#include "hal/drivers/capture_link/capture_words.hpp"

using namespace colift::hal;
using namespace colift::hal::capture;
using namespace std::chrono_literals;
using Do = CaptureMonitor::Do;

namespace {

/// A process as the watch sees it: it does what it is told, unless it hangs.
struct Story {
  CaptureTimes times;
  CaptureMonitor watch{times};
  Timestamp now{0};
  CaptureMonitor::Sight sight;
  bool beats = true, gives_frames = true, dies_when_killed = true;
  int starts = 0, kills = 0, abandoned = 0;
  std::vector<double> started_at;

  void run(Duration time) {
    for (const Timestamp end = now + time; now < end; now += 10ms) {
      if (sight.exists && beats) ++sight.heartbeat;
      if (sight.exists && beats && gives_frames && now.count() % 30'000'000 == 0) ++sight.frames;
      switch (watch.look(sight, now)) {
        case Do::Nothing:
          break;
        case Do::Start:
          ++starts;
          started_at.push_back(seconds(now));
          sight = {};
          sight.exists = true;
          break;
        case Do::Kill:
          ++kills;
          if (dies_when_killed) die("signal 9");
          break;
        case Do::Abandon:
          ++abandoned;
          sight.exists = false;
          break;
      }
    }
  }
  void die(const char* how) {
    sight.exists = false;
    sight.ended = how;
  }
};

}  // namespace

TEST_CASE("nothing is started before it is wanted, and one that works is left alone", "[capture]") {
  Story s;
  s.run(1s);
  CHECK(s.starts == 0);
  s.watch.want();
  s.run(60s);
  CHECK(s.starts == 1);
  CHECK(s.kills == 0);
}

TEST_CASE("a process without sign of life is killed within its deadline and started anew", "[capture]") {
  Story s;
  s.watch.want();
  s.run(5s);
  s.beats = false;
  s.run(590ms);
  CHECK(s.kills == 0);
  s.run(50ms);
  CHECK(s.kills == 1);
  CHECK_THAT(s.watch.why(), Catch::Contains("no sign of life"));
  s.beats = true;
  s.run(1s);
  CHECK(s.starts == 2);
  CHECK(s.watch.running());
}

TEST_CASE("a process that lives without frames is ended later than one that hangs", "[capture]") {
  Story s;
  s.watch.want();
  s.run(5s);
  s.gives_frames = false;
  s.run(2900ms);
  CHECK(s.kills == 0);
  s.run(200ms);
  CHECK(s.kills == 1);
}

TEST_CASE("opening may take its time, but not for ever", "[capture]") {
  Story s;
  s.beats = s.gives_frames = false;
  s.watch.want();
  s.run(5900ms);
  CHECK(s.kills == 0);
  s.run(200ms);
  CHECK(s.kills == 1);
  CHECK_THAT(s.watch.why(), Catch::Contains("first frame"));
}

TEST_CASE("pauses between starts grow up to two seconds, and begin short after a good time", "[capture]") {
  Story s;
  s.watch.want();
  for (int i = 0; i < 12; ++i) {
    s.run(20ms);
    s.die("signal 11");
    s.run(2100ms);
  }
  REQUIRE(s.started_at.size() >= 8);
  const auto gap = [&](std::size_t i) { return s.started_at[i + 1] - s.started_at[i]; };
  CHECK(gap(0) < 0.4);
  for (std::size_t i = 0; i + 1 < s.started_at.size(); ++i) CHECK(gap(i) < 2.2);
  s.run(5s);
  const std::size_t before = s.started_at.size();
  s.die("signal 9");
  const double died = seconds(s.now);
  s.run(1s);
  REQUIRE(s.started_at.size() == before + 1);
  CHECK(s.started_at.back() - died < 0.4);
}

TEST_CASE("without a device it is tried no more often than every two seconds, without end", "[capture]") {
  Story s;
  s.watch.want();
  s.run(20ms);
  for (int i = 0; i < 100; ++i) {
    s.sight.no_device = true;
    s.die("no Kinect on USB");
    s.run(2050ms);
  }
  CHECK(s.starts == 101);
}

TEST_CASE("a process that even SIGKILL does not end is left alone after a while", "[capture]") {
  Story s;
  s.watch.want();
  s.run(5s);
  s.beats = s.dies_when_killed = false;
  s.run(1500ms);
  CHECK(s.kills == 1);
  CHECK(s.abandoned == 0);
  s.run(500ms);
  CHECK(s.abandoned == 1);
  s.beats = true;
  s.run(1s);
  CHECK(s.starts == 2);
}

TEST_CASE("what the process says is understood line by line, in any pieces", "[capture]") {
  const std::string all =
      "\n@state opening\n\n@serial A00367\n@name PrimeSense PS1080\n@constants 7.5 120 0.1042 200\n@features "
      "infrared motor\nlibusb: "
      "hm\n"
      "@frame\n@frame\n@error request the motor refuses\n@error device-lost the device is gone\n";
  for (std::size_t piece = 1; piece < 40; ++piece) {
    CaptureLines lines;
    CaptureNews news;
    for (std::size_t i = 0; i < all.size(); i += piece)
      lines.take(std::string_view(all).substr(i, piece), news);
    CHECK(news.frames == 2);
    CHECK(news.serial == "A00367");
    CHECK(news.constants == std::vector{7.5, 120.0, 0.1042, 200.0});
    CHECK(news.name == "PrimeSense PS1080");
    CHECK(news.infrared);
    CHECK(news.motor);
    CHECK(news.end == CaptureEnd::DeviceLost);
    CHECK(news.reason == "the device is gone");
    CHECK(news.refused == "the motor refuses");
    CHECK(news.last_words == "libusb: hm");
    CHECK(news.garbage == 0);
  }
}

TEST_CASE("nonsense from the process is counted and bounded", "[capture]") {
  CaptureLines lines;
  CaptureNews news;
  lines.take("@constants 1 2 3 4 5 6 7 8 9\n@constants a b\n@constants 1 nan\n@error nonsense x\n@what\n@\n",
             news);
  CHECK(news.garbage == 6);
  CHECK(news.constants.empty());
  CHECK_FALSE(news.end);
  lines.take(std::string(1'000'000, '@') + "\n", news);
  CHECK(news.garbage == 7);
  lines.take("text \x1b[2J with \x01 control\n", news);
  CHECK(news.last_words == "text [2J with  control");
}
