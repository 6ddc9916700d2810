#include "tools/bring_up/hal_screen.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tools/run/run_progress.hpp"

namespace colift::tools {
namespace {
constexpr double kDraw_s = 0.2, kSay_s = 1.0;
}

LiveScreen::LiveScreen(std::FILE* out, bool json, bool silent)
    : out_(out), silent_(silent), live_(!silent && !json && progress_style(out, json, silent).live) {}

LiveScreen::~LiveScreen() {
  if (lines_ == 0) return;
  std::fputs("\x1b[?25h", out_);
  std::fflush(out_);
}

void LiveScreen::draw(const std::string& text, double at_s) {
  if (silent_ || (drawn_s_ >= 0.0 && at_s - drawn_s_ < kDraw_s)) return;
  drawn_s_ = at_s;
  std::string out = lines_ > 0 ? fmt::format("\x1b[?25l\x1b[{}F", lines_) : std::string("\x1b[?25l");
  lines_ = 0;
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t to = std::min(text.find('\n', from), text.size());
    out.append(text, from, to - from);
    out += "\x1b[K\n";
    ++lines_;
    from = to + 1;
  }
  out += "\x1b[J";
  std::fputs(out.c_str(), out_);
  std::fflush(out_);
}

void LiveScreen::line(const std::string& text) {
  if (silent_) return;
  std::fputs(fmt::format("{}\n", text).c_str(), out_);
  std::fflush(out_);
  lines_ = 0;
}

void LiveScreen::line_now_and_then(const std::string& text, double at_s) {
  if (said_s_ >= 0.0 && at_s - said_s_ < kSay_s) return;
  said_s_ = at_s;
  line(text);
}

}  // namespace colift::tools
