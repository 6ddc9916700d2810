#pragma once

#include <array>
#include <string>
#include <string_view>

namespace colift::hal {

/// Words of bounded length that are copied without allocation, so that they can leave a real-time cycle.
class ShortText {
 public:
  ShortText() = default;
  explicit ShortText(std::string_view text) { set(text); }
  /// Cuts what is longer than 184 characters.
  void set(std::string_view text) { size_ = text.copy(letters_.data(), letters_.size()); }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] std::string str() const { return {letters_.data(), size_}; }

 private:
  std::array<char, 184> letters_{};
  std::size_t size_ = 0;
};

}  // namespace colift::hal
