#pragma once

#include <functional>
#include <memory>
#include <string>

#include "control/recovery/recovery.hpp"

namespace colift::tools {

/// The person at the keyboard: asked before each step, and holding a key while the arm moves. The terminal is
/// as it was when this is gone.
class KeyboardOperator {
 public:
  /// `hold_s`: the key counts as released when it was not repeated for this time.
  explicit KeyboardOperator(double hold_s);
  ~KeyboardOperator();
  KeyboardOperator(const KeyboardOperator&) = delete;
  KeyboardOperator& operator=(const KeyboardOperator&) = delete;
  /// stdin is a terminal.
  [[nodiscard]] static bool is_there();
  /// `interrupted` also ends a question.
  [[nodiscard]] control::RecoveryHooks hooks(const std::function<bool()>& interrupted);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Confirms everything but that a person holds the object: simulation only.
[[nodiscard]] control::RecoveryHooks confirm_everything(const std::function<bool()>& interrupted, bool quiet);

}  // namespace colift::tools
