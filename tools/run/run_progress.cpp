#include "tools/run/run_progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "tools/run/run_text.hpp"

namespace colift::tools {
namespace {

using control::Task;
using hal::DeviceHealth;

constexpr double kMinPeriod_s = 1.0 / 15;
constexpr std::size_t kHeading = 11;

// Only what every terminal shows well on light and on dark paper: no yellow, no blue, no background.
enum class Ink { Plain, Bold, Dim, Good, Bad, Odd };

const char* code(Ink ink) {
  switch (ink) {
    case Ink::Bold:
      return "1";
    case Ink::Dim:
      return "2";
    case Ink::Good:
      return "32";
    case Ink::Bad:
      return "1;31";
    case Ink::Odd:
      return "35";
    case Ink::Plain:
      break;
  }
  return "0";
}

// A line that never grows wider than the screen, whatever is written into it.
class Line {
 public:
  explicit Line(const ProgressStyle& style)
      : style_(style), left_(static_cast<std::size_t>(std::max(20, style.columns))) {}

  Line& write(const std::string& text, Ink ink = Ink::Plain) {
    const std::string part = cut(one_line(text, !style_.unicode), left_);
    if (part.empty()) return *this;
    left_ -= columns_of(part);
    if (style_.colour && ink != Ink::Plain)
      text_ += fmt::format("\x1b[{}m{}\x1b[0m", code(ink), part);
    else
      text_ += part;
    return *this;
  }
  Line& column(const std::string& text, std::size_t width, Ink ink = Ink::Plain) {
    const std::string part = cut(one_line(text, !style_.unicode), width);
    write(part, ink);
    return write(std::string(width - columns_of(part), ' '));
  }
  // Writes so that it ends at the line's end.
  Line& right(const std::string& text, Ink ink = Ink::Plain) {
    const std::size_t width = columns_of(one_line(text, !style_.unicode));
    if (width + 1 > left_) return *this;
    return write(std::string(left_ - width, ' ')).write(text, ink);
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  const ProgressStyle& style_;
  std::size_t left_;
  std::string text_;
};

// The job as a person counts it; states that belong together share a word.
struct Step {
  const char* name;
  std::array<Task, 2> states;
};
constexpr std::array<Step, 12> kSteps{{{"see", {Task::Observe, Task::Observe}},
                                       {"partner", {Task::AwaitPartner, Task::AwaitPartner}},
                                       {"decide", {Task::Decide, Task::Decide}},
                                       {"plan", {Task::Plan, Task::Plan}},
                                       {"approach", {Task::Approach, Task::Approach}},
                                       {"close", {Task::Close, Task::Verify}},
                                       {"ready", {Task::AwaitReady, Task::TestLift}},
                                       {"lift", {Task::Lift, Task::Lift}},
                                       {"hold", {Task::Hold, Task::Hold}},
                                       {"lower", {Task::Lower, Task::Lower}},
                                       {"release", {Task::Release, Task::Release}},
                                       {"home", {Task::Retreat, Task::Done}}}};

// Index of the step that a state belongs to; -1 for states off the way (back-off, stopped, ...).
int step_of(Task state) {
  for (std::size_t i = 0; i < kSteps.size(); ++i)
    if (kSteps[i].states[0] == state || kSteps[i].states[1] == state) return static_cast<int>(i);
  return -1;
}

std::string steps(const RunStatus& status, const ProgressStyle& style) {
  Line line(style);
  const int now = step_of(status.state);
  const bool done = status.state == Task::Done;
  line.write(" ");
  for (int i = 0; i < static_cast<int>(kSteps.size()); ++i) {
    const char* name = kSteps[static_cast<std::size_t>(i)].name;
    if (i == now && !done) {
      line.write(style.colour ? name : fmt::format("[{}]", name), Ink::Bold);
    } else {
      const bool past = now >= 0 && (i < now || done);
      line.write(name, past ? Ink::Good : Ink::Dim);
    }
    line.write(" ");
  }
  return line.text();
}

std::string bar(double part, std::size_t width, const ProgressStyle& style) {
  const auto full =
      static_cast<std::size_t>(std::lround(std::clamp(part, 0.0, 1.0) * static_cast<double>(width)));
  std::string out;
  for (std::size_t i = 0; i < width; ++i)
    out += i < full ? (style.unicode ? "━" : "#") : (style.unicode ? "·" : "-");
  return out;
}

Ink ink_of(Task state) {
  switch (state) {
    case Task::Done:
      return Ink::Good;
    case Task::Refused:
    case Task::Aborted:
    case Task::Stopped:
      return Ink::Bad;
    case Task::BackOff:
    case Task::Contact:
    case Task::Halt:
    case Task::Pause:
    case Task::Yield:
      return Ink::Odd;
    default:
      return Ink::Bold;
  }
}

struct HealthWord {
  const char* word;
  Ink ink;
};
HealthWord word_of(DeviceHealth::State state) {
  using State = DeviceHealth::State;
  switch (state) {
    case State::Absent:
      return {"absent", Ink::Bad};
    case State::Opening:
      return {"opening", Ink::Odd};
    case State::Streaming:
      return {"alive", Ink::Good};
    case State::Stalled:
      return {"stalled", Ink::Odd};
    case State::Lost:
      return {"lost", Ink::Bad};
    case State::Failed:
      return {"failed", Ink::Bad};
  }
  return {"?", Ink::Bad};
}

std::string device_line(const DeviceStatus& device, const ProgressStyle& style) {
  Line line(style);
  const HealthWord health = word_of(device.health.state);
  line.column(device.name, kHeading, Ink::Dim).column(health.word, 9, health.ink);
  line.column(device.rate_hz > 0 ? fmt::format("{:.0f} Hz", device.rate_hz) : "", 9);
  line.write(fmt::format("{} used", device.health.accepted));
  if (device.health.rejected)
    line.write(", ").write(fmt::format("{} rejected", device.health.rejected), Ink::Odd);
  if (!device.health.last_error.empty())
    line.write("; ").write(device.health.last_error,
                           device.health.state == DeviceHealth::State::Streaming ? Ink::Dim : Ink::Bad);
  return line.text();
}

std::string fact(const char* heading, const std::string& text, const ProgressStyle& style,
                 Ink ink = Ink::Plain) {
  return Line(style).column(heading, kHeading, Ink::Dim).write(text, ink).text();
}

std::string joined(const std::string& a, const std::string& b) {
  return a.empty() || b.empty() ? a + b : a + "; " + b;
}

std::string partner_text(const RunStatus& s) {
  return joined(s.partner ? fmt::format("holds the object at {}", place_text(*s.partner)) : "",
                s.partner_note);
}

std::string grasp_text(const RunStatus& s) {
  std::string text = s.candidate ? fmt::format("number {}", *s.candidate) : "";
  if (s.share_predicted) text += fmt::format(", the robot would carry {}", percent_text(*s.share_predicted));
  return joined(text, s.decision_note);
}

std::string load_text(const RunStatus& s) {
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : "   ") + part; };
  if (s.load_n && std::isfinite(*s.load_n)) add(fmt::format("{:.1f} N", *s.load_n));
  if (s.share && std::isfinite(*s.share)) add(fmt::format("share {}", percent_text(*s.share)));
  if (s.height_m && std::isfinite(*s.height_m)) add(fmt::format("height {}", metres_text(*s.height_m)));
  if (s.tilt_rad && std::isfinite(*s.tilt_rad)) add(fmt::format("tilt {}", degrees_text(*s.tilt_rad)));
  if (s.slip_m && std::isfinite(*s.slip_m)) add(fmt::format("slip {}", metres_text(*s.slip_m)));
  return text;
}

std::string rule(const ProgressStyle& style) {
  std::string out;
  for (int i = 0; i < style.columns; ++i) out += style.unicode ? "─" : "-";
  return Line(style).write(out, Ink::Dim).text();
}

bool env_says_utf8() {
  for (const char* name : {"LC_ALL", "LC_CTYPE", "LANG"}) {
    const char* value = std::getenv(name);
    if (!value || !*value) continue;
    const std::string v = value;
    return v.find("UTF-8") != std::string::npos || v.find("utf8") != std::string::npos;
  }
  return false;
}

}  // namespace

ProgressStyle progress_style(std::FILE* out, bool json, bool quiet) {
  ProgressStyle style;
  style.silent = quiet;
  const char* term = std::getenv("TERM");
  const char* no_colour = std::getenv("NO_COLOR");
  const bool terminal = ::isatty(::fileno(out)) == 1 && term && std::strcmp(term, "dumb") != 0;
  style.live = terminal && !json && !quiet;
  style.colour = style.live && !(no_colour && *no_colour);
  style.unicode = env_says_utf8();
  return style;
}

std::vector<std::string> progress_screen(const RunStatus& s, const RunSetting& setting,
                                         const ProgressStyle& style) {
  std::vector<std::string> lines;
  std::string what = setting.scenario.empty() ? setting.robot : setting.scenario;
  what += " · " + setting.method;
  if (setting.simulated) what += fmt::format(" · seed {}", setting.seed);
  if (setting.dry_run) what += " · dry run";
  lines.push_back(Line(style)
                      .write("CoLift ", Ink::Bold)
                      .write(cut(what, 58), Ink::Dim)
                      .right(fmt::format("{:.1f} s", s.t_s))
                      .text());
  lines.push_back(rule(style));
  lines.push_back(steps(s, style));
  lines.push_back("");

  Line state(style);
  state.column("state", kHeading, Ink::Dim).write(std::string(control::word(s.state)), ink_of(s.state));
  if (!control::is_end(s.state)) state.write(fmt::format("  for {:.1f} s", s.in_state_s));
  if (s.done)
    state.write("  ")
        .write(bar(*s.done, 24, style), Ink::Good)
        .write(fmt::format(" {}", percent_text(*s.done)));
  lines.push_back(state.text());
  lines.push_back(fact("because", s.reason, style));
  lines.push_back(fact("waits for", std::string(control::waits_for(s.state)), style));
  lines.push_back(s.press.empty() ? fact("now", s.now, style)
                                  : fact("now", s.press + "; " + s.now, style, Ink::Odd));
  lines.push_back("");
  for (const DeviceStatus& device : s.devices) lines.push_back(device_line(device, style));
  lines.push_back("");
  lines.push_back(fact("partner", partner_text(s), style));
  lines.push_back(fact("grasp", grasp_text(s), style));
  lines.push_back(fact("load", load_text(s), style));
  // always two lines for faults, so that nothing jumps when one comes
  constexpr std::size_t kFaults = 2;
  for (std::size_t i = 0; i < kFaults; ++i) {
    const std::size_t shown = std::min(kFaults, s.faults.size());
    const std::string text = i < shown ? s.faults[s.faults.size() - shown + i] : "";
    lines.push_back(fact(i == 0 ? "faults" : "", i == 0 && shown == 0 ? "none" : text, style,
                         text.empty() ? Ink::Dim : Ink::Odd));
  }
  return lines;
}

RunProgress::RunProgress(std::FILE* out, const ProgressStyle& style, const RunSetting& setting,
                         const hal::Clock& wall)
    : out_(out), style_(style), setting_(&setting), wall_(&wall) {}

RunProgress::~RunProgress() {
  end();
}

void RunProgress::show(const RunStatus& status) {
  if (style_.silent) return;
  if (!style_.live) {
    plain(status);
    return;
  }
  const hal::Timestamp now = wall_->now();
  const bool changed = !last_ || last_->state != status.state;
  last_ = status;
  fill_rates(*last_);
  if (!changed && drawn_at_ && hal::seconds(now - *drawn_at_) < kMinPeriod_s) return;
  drawn_at_ = now;
  draw(*last_);
}

void RunProgress::line_was_typed() {
  if (lines_ > 0) ++lines_;
}

void RunProgress::fill_rates(RunStatus& status) {
  for (DeviceStatus& device : status.devices) {
    if (device.rate_hz > 0) continue;
    const std::uint64_t accepted = device.health.accepted;
    auto count =
        std::find_if(counts_.begin(), counts_.end(), [&](const Count& c) { return c.name == device.name; });
    if (count == counts_.end()) {
      counts_.push_back({device.name, status.t_s, 0.0, accepted});
      continue;
    }
    const double passed = status.t_s - count->t_s;
    // a device that was opened anew counts from the start again
    if (passed >= 1.0 || accepted < count->accepted) {
      const bool grew = accepted >= count->accepted && passed > 0;
      *count = {device.name, status.t_s,
                grew ? static_cast<double>(accepted - count->accepted) / passed : 0.0, accepted};
    }
    device.rate_hz = count->rate_hz;
  }
}

void RunProgress::draw(const RunStatus& status) {
  const std::vector<std::string> screen = progress_screen(status, *setting_, style_);
  // one write, held together where the terminal knows how (mode 2026), each line over its old self
  std::string out = "\x1b[?2026h\x1b[?25l";
  if (lines_) out += fmt::format("\x1b[{}F", lines_);
  for (const std::string& line : screen) out += line + "\x1b[K\n";
  out += "\x1b[J\x1b[?2026l";
  lines_ = screen.size();
  std::fwrite(out.data(), 1, out.size(), out_);
  std::fflush(out_);
}

void RunProgress::plain(const RunStatus& s) {
  const auto width = static_cast<std::size_t>(std::max(20, style_.columns));
  std::string out;
  if (said_ != s.state) {
    out += entry(fmt::format("{:8.2f} s  {}", s.t_s, control::word(s.state)),
                 one_line(s.reason, !style_.unicode), 26, width);
    said_ = s.state;
  }
  for (; faults_said_ < s.faults.size(); ++faults_said_)
    out += entry(fmt::format("{:8.2f} s  fault", s.t_s), one_line(s.faults[faults_said_], !style_.unicode),
                 26, width);
  if (press_said_ != s.press) {
    press_said_ = s.press;
    if (!s.press.empty())
      out += entry(fmt::format("{:8.2f} s  confirm", s.t_s),
                   one_line(s.press + "; " + s.now, !style_.unicode), 26, width);
  }
  if (out.empty()) return;
  std::fwrite(out.data(), 1, out.size(), out_);
  std::fflush(out_);
}

void RunProgress::end() {
  if (!style_.live || style_.silent || !last_) return;
  draw(*last_);
  std::fputs("\x1b[?25h\n", out_);
  std::fflush(out_);
  last_.reset();
  lines_ = 0;
}

}  // namespace colift::tools
