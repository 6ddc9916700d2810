#pragma once

#include <cstdio>
#include <string>

namespace colift::tools {

/// Words of a running bring-up command: one screen that renews itself on a terminal, lines elsewhere. One
/// thread.
class LiveScreen {
 public:
  /// Nothing at all when `silent`.
  LiveScreen(std::FILE* out, bool json, bool silent);
  ~LiveScreen();
  LiveScreen(const LiveScreen&) = delete;
  LiveScreen& operator=(const LiveScreen&) = delete;

  [[nodiscard]] bool live() const { return live_; }
  /// Puts the text in place of the last one, five times a second at most.
  void draw(const std::string& text, double at_s);
  /// A line that stays.
  void line(const std::string& text);
  /// The same once a second at most.
  void line_now_and_then(const std::string& text, double at_s);

 private:
  std::FILE* out_;
  bool silent_, live_;
  std::size_t lines_ = 0;
  double drawn_s_ = -1.0, said_s_ = -1.0;
};

}  // namespace colift::tools
