#pragma once

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <string>
#include <string_view>

#include "hal/drivers/capture_link/capture_words.hpp"

namespace colift::capture {

/// A line to the controller (capture_words.hpp). Never waits: when nobody reads, it is lost. In front of it
/// an end of line, because the library may have begun one.
inline void say(std::string_view text) {
  std::string line = "\n@" + std::string(text) + "\n";
  for (std::size_t i = 1; i + 1 < line.size(); ++i)
    if (line[i] == '\n') line[i] = ' ';
  (void)!::write(STDOUT_FILENO, line.data(), line.size());
}

/// The last words.
inline void say_end(hal::capture::CaptureEnd end, std::string_view reason) {
  say("error " + std::string(hal::capture::word(end)) + " " + std::string(reason));
}

}  // namespace colift::capture
