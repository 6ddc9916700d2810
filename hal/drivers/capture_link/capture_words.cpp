#include "hal/drivers/capture_link/capture_words.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace colift::hal::capture {
namespace {

constexpr std::size_t kLongest = 400;
constexpr std::size_t kLongestName = 40, kMostNumbers = 8;

/// Printable ASCII only: it goes to a terminal.
std::string clean(std::string_view text) {
  std::string t(text.substr(0, kLongest));
  std::erase_if(t, [](char c) { return c < ' ' || c > '~'; });
  return t;
}

std::string_view first_word(std::string_view& text) {
  const std::size_t space = std::min(text.find(' '), text.size());
  const std::string_view w = text.substr(0, space);
  text.remove_prefix(std::min(space + 1, text.size()));
  return w;
}

/// Empty: not numbers, or too many.
std::vector<double> read_numbers(std::string_view text) {
  std::vector<double> numbers;
  while (!text.empty()) {
    const std::string_view w = first_word(text);
    double value = 0.0;
    const auto [end, error] = std::from_chars(w.data(), w.data() + w.size(), value);
    if (error != std::errc{} || end != w.data() + w.size() || !std::isfinite(value)) return {};
    if (numbers.size() == kMostNumbers) return {};
    numbers.push_back(value);
  }
  return numbers;
}

}  // namespace

void CaptureLines::take(std::string_view bytes, CaptureNews& news) {
  for (const char c : bytes) {
    if (c != '\n') {
      if (rest_.size() < kLongest)
        rest_ += c;
      else
        too_long_ = true;
      continue;
    }
    if (!rest_.empty() && !(too_long_ && rest_[0] == '@')) line(rest_, news);
    if (too_long_ && !rest_.empty() && rest_[0] == '@') ++news.garbage;
    rest_.clear();
    too_long_ = false;
  }
}

void CaptureLines::line(std::string_view text, CaptureNews& news) const {
  if (text[0] != '@') {
    news.last_words = clean(text);
    return;
  }
  text.remove_prefix(1);
  const std::string_view what = first_word(text);
  if (what == "frame") {
    ++news.frames;
  } else if (what == "state") {
    // the ring says it too
  } else if (what == "serial") {
    news.serial = clean(text.substr(0, kLongestName));
  } else if (what == "name") {
    news.name = clean(text.substr(0, kLongestName));
  } else if (what == "constants") {
    news.constants = read_numbers(text);
    if (news.constants.empty()) ++news.garbage;
  } else if (what == "features") {
    while (!text.empty()) {
      const std::string_view w = first_word(text);
      news.infrared = news.infrared || w == "infrared";
      news.motor = news.motor || w == "motor";
    }
  } else if (what == "finished") {
    news.finished = true;
  } else if (what == "note") {
    news.last_words = clean(text);
  } else if (what == "error") {
    const std::string_view w = first_word(text);
    const auto at = std::find(kCaptureEndWords.begin(), kCaptureEndWords.end(), w);
    if (at == kCaptureEndWords.end()) {
      ++news.garbage;
      return;
    }
    const auto end = static_cast<CaptureEnd>(at - kCaptureEndWords.begin());
    if (end == CaptureEnd::Request) {
      news.refused = clean(text);
    } else {
      news.end = end;
      news.reason = clean(text);
    }
  } else {
    ++news.garbage;
  }
}

}  // namespace colift::hal::capture
