#pragma once

namespace colift::tools {

/// Whether a person presses Enter at the terminal of a run. The terminal's modes stay as they are: a program
/// that is killed leaves nothing to repair. Nobody is there where the input is no terminal, and nothing is
/// read while the program runs in the background, where reading would stop it.
class EnterKey {
 public:
  explicit EnterKey(int input);

  /// Somebody could press it.
  [[nodiscard]] bool is_there() const { return input_ >= 0; }
  /// It was pressed since the last call. Never waits.
  [[nodiscard]] bool take();

 private:
  int input_;  ///< -1: no terminal, or it was closed.
};

}  // namespace colift::tools
