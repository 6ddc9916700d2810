#include <catch2/catch.hpp>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <string>

#include "run_example.hpp"
#include "tools/run/run_progress.hpp"
#include "tools/run/run_text.hpp"

using namespace colift;
using namespace colift::tools;
using control::Task;

namespace {

// What was written to a file that lives in memory.
class Paper {
 public:
  Paper() : file_(::open_memstream(&bytes_, &size_)) {}
  ~Paper() {
    std::fclose(file_);
    std::free(bytes_);
  }
  Paper(const Paper&) = delete;
  Paper& operator=(const Paper&) = delete;
  [[nodiscard]] std::FILE* file() const { return file_; }
  [[nodiscard]] std::string text() {
    std::fflush(file_);
    return {bytes_, size_};
  }

 private:
  char* bytes_ = nullptr;
  std::size_t size_ = 0;
  std::FILE* file_;
};

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::string without_codes(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '\x1b') {
      out += text[i];
      continue;
    }
    while (i + 1 < text.size() && !std::isalpha(static_cast<unsigned char>(text[i]))) ++i;
  }
  return out;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

// As full as a screen can be, with words longer than it is wide.
RunStatus crowded() {
  RunStatus s;
  s.t_s = 123.456;
  s.state = Task::Approach;
  s.in_state_s = 3.21;
  s.reason = "collision-free path to the grasp found, though it is a narrow one between two legs";
  s.now = std::string(200, 'x');
  s.done = 0.45;
  hal::DeviceHealth health;
  health.state = hal::DeviceHealth::State::Stalled;
  health.accepted = 1234567;
  health.rejected = 99999;
  health.last_error =
      "a frame of 639 x 480 pixels came where 640 x 480 was expected, for the third time in a row";
  s.devices = {{"arm", health, 200}, {"hand", health, 50}, {"camera", health, 29.97}};
  s.partner = hal::Vec3(1.234, -0.123, 0.431);
  s.partner_note = "two hands at the far edge of the table, moving by 3 mm a second";
  s.candidate = 112;
  s.share_predicted = 0.501;
  s.decision_note = std::string(90, 'd');
  s.load_n = 19.8;
  s.share = 0.49;
  s.height_m = 0.0497;
  s.tilt_rad = 0.0094;
  s.slip_m = 0.0012;
  s.faults = {"a", "b\nc", std::string(120, 'f')};
  return s;
}

}  // namespace

TEST_CASE("no line of the screen is wider than the terminal", "[run]") {
  RunSetting setting;
  setting.scenario =
      "a scenario with a name that is longer than any terminal is wide, and then some more of it";
  for (const bool unicode : {false, true})
    for (const bool colour : {false, true})
      for (const int columns : {40, 80, 120}) {
        const ProgressStyle style{true, false, colour, unicode, columns};
        for (const std::string& line : progress_screen(crowded(), setting, style)) {
          const std::string seen = without_codes(line);
          INFO(seen);
          CHECK(columns_of(seen) <= static_cast<std::size_t>(columns));
          CHECK(seen.find('\n') == std::string::npos);
          if (!unicode) CHECK(columns_of(seen) == seen.size());
          if (!colour) CHECK(line == seen);
        }
      }
}

TEST_CASE("the screen says what it waits for, why, and how the devices are", "[run]") {
  RunSetting setting;
  setting.scenario = "table";
  std::string all;
  for (const std::string& line : progress_screen(crowded(), setting, {true, false, false, true, 80}))
    all += line + "\n";
  for (const char* part :
       {"[approach]", "for 3.2 s", "45 %", "the arm to arrive at the grasp", "collision-free path",
        "arm        stalled", "200 Hz", "1234567 used", "99999 rejected", "(1.23, -0.12, 0.43)", "number 112",
        "50 %", "19.8 N", "49 %", "5.0 cm", "0.5°", "1 mm", "b c"}) {
    INFO(part << "\n" << all);
    CHECK(all.find(part) != std::string::npos);
  }
}

TEST_CASE("the screen has as many lines with everything known as with nothing", "[run]") {
  RunStatus nothing;
  nothing.devices = crowded().devices;
  const RunSetting setting;
  const ProgressStyle style;
  CHECK(progress_screen(nothing, setting, style).size() == progress_screen(crowded(), setting, style).size());
}

TEST_CASE("without a terminal every change is one plain line, said once", "[run]") {
  Paper paper;
  hal::ManualClock wall;
  const RunSetting setting;
  {
    RunProgress progress(paper.file(), {}, setting, wall);
    RunStatus s = crowded();
    s.faults.clear();
    for (int i = 0; i < 100; ++i) {
      s.t_s += 0.03;
      if (i == 40) s.faults.emplace_back("camera: silent");
      if (i == 50) {
        s.state = Task::Close;
        s.reason = "hand at the grasp";
      }
      progress.show(s);
    }
    progress.end();
  }
  const std::string text = paper.text();
  CHECK(text.find('\x1b') == std::string::npos);
  CHECK(count(text, "approach") == 1);
  CHECK(count(text, "hand at the grasp") == 1);
  CHECK(count(text, "camera: silent") == 1);
  for (const std::string& line : lines_of(text)) CHECK(columns_of(line) <= 80);
}

TEST_CASE("what a person has to press is said once for each time that the run waits for it", "[run]") {
  Paper paper;
  hal::ManualClock wall;
  const RunSetting setting;
  RunStatus s = crowded();
  {
    RunProgress progress(paper.file(), {}, setting, wall);
    for (int i = 0; i < 100; ++i) {
      s.now = i % 50 < 25 ? "" : "waits for confirmation: nobody is near any more";
      s.press = i % 50 < 25 ? "" : "press Enter to continue";
      progress.show(s);
    }
    progress.end();
  }
  CHECK(count(paper.text(), "press Enter to continue; waits for confirmation") == 2);
  bool shown = false;
  for (const std::string& line : progress_screen(s, setting, {}))
    shown = shown || line.find("press Enter to continue") != std::string::npos;
  CHECK(shown);
}

TEST_CASE("a line that was typed below a live screen is drawn over", "[run]") {
  Paper paper;
  hal::ManualClock wall;
  const RunSetting setting;
  RunProgress progress(paper.file(), {true, false, true, true, 80}, setting, wall);
  RunStatus s = crowded();
  progress.line_was_typed();  // before there is a screen
  progress.show(s);
  progress.line_was_typed();
  s.state = Task::Close;
  progress.show(s);
  const std::size_t height = progress_screen(s, setting, {}).size();
  CHECK(count(paper.text(), "\x1b[" + std::to_string(height + 1) + "F") == 1);
}

TEST_CASE("a live screen is renewed in place, not more often than a person sees", "[run]") {
  Paper paper;
  hal::ManualClock wall;
  const RunSetting setting;
  RunProgress progress(paper.file(), {true, false, true, true, 80}, setting, wall);
  RunStatus s = crowded();
  for (int i = 0; i < 100; ++i) {
    progress.show(s);
    wall.advance(std::chrono::milliseconds(10));
  }
  const std::size_t drawn = count(paper.text(), "\x1b[?2026h");
  CHECK(drawn >= 10);
  CHECK(drawn <= 16);
  s.state = Task::Close;
  progress.show(s);
  CHECK(count(paper.text(), "\x1b[?2026h") == drawn + 1);
  // every picture but the first goes back to where the one before began
  const std::size_t height = progress_screen(s, setting, {}).size();
  CHECK(count(paper.text(), "\x1b[" + std::to_string(height) + "F") == drawn);
  progress.end();
  const std::string text = paper.text();
  CHECK(text.rfind("\x1b[?25h") > text.rfind("\x1b[?25l"));
  const std::size_t length = text.size();
  progress.end();
  CHECK(paper.text().size() == length);
}

TEST_CASE("rates are worked out from what the devices accepted", "[run]") {
  Paper paper;
  hal::ManualClock wall;
  const RunSetting setting;
  RunProgress progress(paper.file(), {true, false, false, false, 80}, setting, wall);
  RunStatus s;
  s.devices = {{"camera", {}, 0.0}};
  for (int i = 0; i <= 90; ++i) {
    s.t_s = i / 30.0;
    s.devices[0].health.accepted = static_cast<std::uint64_t>(i);
    wall.advance(std::chrono::milliseconds(100));
    progress.show(s);
  }
  CHECK(paper.text().find("30 Hz") != std::string::npos);
}

TEST_CASE("with --quiet nothing is said", "[run]") {
  Paper paper;
  const hal::ManualClock wall;
  const RunSetting setting;
  RunProgress progress(paper.file(), progress_style(paper.file(), false, true), setting, wall);
  progress.show(crowded());
  progress.end();
  CHECK(paper.text().empty());
}

TEST_CASE("the summary says how good it was, in lines that fit", "[run]") {
  for (const auto& e : {tests::lifted_run(), tests::refused_run(), tests::stopped_run()})
    for (const int columns : {60, 80}) {
      const std::string text = run_summary(e.view(), columns);
      INFO(text);
      CHECK(text.find(e.record.reason.substr(0, 20)) != std::string::npos);
      for (const std::string& line : lines_of(text))
        CHECK(columns_of(line) <= static_cast<std::size_t>(columns));
    }
  const std::string lifted = run_summary(tests::lifted_run().view());
  for (const char* part :
       {"lifted", "5.0 cm high (truth 4.9 cm)", "0.5° (truth 0.5°)", "carried 49 %, 44 to 55 % (truth 49 %)",
        "wanted 50 %", "4.04 kg", "truth 4.00 kg", "0.12 s"}) {
    INFO(part << "\n" << lifted);
    CHECK(lifted.find(part) != std::string::npos);
  }
  CHECK(run_summary(tests::stopped_run().view()).find("still holds the object") != std::string::npos);
}

TEST_CASE("text is wrapped without loss and cut with three dots", "[run]") {
  CHECK(wrapped("aa bb cc", 5) == std::vector<std::string>{"aa bb", "cc"});
  CHECK(wrapped("°°°°°", 2) == std::vector<std::string>{"°°", "°°", "°"});
  CHECK(wrapped("", 5).empty());
  CHECK(cut("0.5° and more", 7) == "0.5°...");
  CHECK(cut("0.5°", 4) == "0.5°");
  CHECK(one_line("a\nb\x1b[31m ±1°\xFF", true) == "a b [31m +-1 deg?");
  CHECK(metres_text(0.0497) == "5.0 cm");
  CHECK(metres_text(0.008) == "8 mm");
  CHECK(metres_text(-0.0001) == "0 mm");
  CHECK(metres_text(std::nan("")) == "unknown");
}
