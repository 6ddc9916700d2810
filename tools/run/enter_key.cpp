#include "tools/run/enter_key.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>

namespace colift::tools {

EnterKey::EnterKey(int input) : input_(::isatty(input) == 1 ? input : -1) {}

bool EnterKey::take() {
  bool pressed = false;
  for (pollfd in{input_, POLLIN, 0}; input_ >= 0 && ::poll(&in, 1, 0) == 1;) {
    // -1: not this program's controlling terminal, which stops nobody who reads it
    const pid_t foreground = ::tcgetpgrp(input_);
    if (foreground != -1 && foreground != ::getpgrp()) return false;
    std::array<char, 256> typed{};
    const auto count = ::read(input_, typed.data(), typed.size());
    if (count <= 0) input_ = -1;
    pressed = pressed || (count > 0 && std::find(typed.begin(), typed.begin() + count, '\n') != typed.end());
  }
  return pressed;
}

}  // namespace colift::tools
