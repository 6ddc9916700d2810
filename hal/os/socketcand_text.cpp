#include "hal/os/socketcand_text.hpp"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <optional>

namespace colift::hal {
namespace {

using Kind = GatewayMessage::Kind;

constexpr std::size_t kLongest = 128;  // the longest that is used here has 51

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

std::string_view trim(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string_view take_word(std::string_view& text) {
  text = trim(text);
  std::size_t n = 0;
  while (n < text.size() && !is_blank(text[n])) ++n;
  const std::string_view word = text.substr(0, n);
  text.remove_prefix(n);
  return word;
}

std::optional<std::uint32_t> read_hex(std::string_view word) {
  std::uint32_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value, 16);
  if (word.empty() || error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  return value;
}

// "23.424242"
bool is_time(std::string_view word) {
  const std::size_t dot = word.find('.');
  if (dot == 0 || dot == std::string_view::npos || dot + 1 == word.size()) return false;
  return std::all_of(word.begin(), word.end(), [](char c) { return (c >= '0' && c <= '9') || c == '.'; }) &&
         word.find('.', dot + 1) == std::string_view::npos;
}

// The gateway writes the bytes in one piece, its manual draws them apart: both are read.
bool read_data(std::string_view text, CanFrame& frame) {
  while (!(text = trim(text)).empty()) {
    if (text.size() < 2 || frame.length >= 8) return false;
    const auto byte = read_hex(text.substr(0, 2));
    if (!byte) return false;
    frame.data[frame.length++] = static_cast<std::uint8_t>(*byte);
    text.remove_prefix(2);
  }
  return true;
}

GatewayMessage of_kind(Kind kind) {
  GatewayMessage message;
  message.kind = kind;
  return message;
}

GatewayMessage read_frame(std::string_view rest) {
  const std::string_view id_word = take_word(rest), time = take_word(rest);
  const auto id = read_hex(id_word);
  if (!id || !is_time(time)) return of_kind(Kind::Broken);
  GatewayMessage message = of_kind(Kind::Frame);
  if (!read_data(rest, message.frame)) return of_kind(Kind::Broken);
  // the number of digits tells the kind of identifier
  if (id_word.size() > 3)
    return of_kind(id_word.size() == 8 && *id < 0x20000000 ? Kind::Other : Kind::Broken);
  if (*id > 0x7ff) return of_kind(Kind::Broken);
  message.frame.id = static_cast<std::uint16_t>(*id);
  return message;
}

GatewayMessage read_error(std::string_view rest) {
  GatewayMessage message = of_kind(Kind::Refused);
  message.words = trim(rest);
  const std::string_view class_word = take_word(rest), time = take_word(rest);
  if (const auto bits = read_hex(class_word); bits && is_time(time) && trim(rest).empty()) {
    message = of_kind(Kind::Error);
    message.error_class = *bits & 0x1fffffff;
  }
  return message;
}

}  // namespace

GatewayMessage parse_gateway_message(std::string_view inside) noexcept {
  const std::string_view word = take_word(inside);
  if (word == "frame") return read_frame(inside);
  if (word == "error") return read_error(inside);
  if (word == "hi") return of_kind(trim(inside).empty() ? Kind::Hi : Kind::Broken);
  if (word == "ok") return of_kind(trim(inside).empty() ? Kind::Ok : Kind::Broken);
  const bool plain = !word.empty() && std::all_of(word.begin(), word.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
  });
  return of_kind(plain ? Kind::Other : Kind::Broken);
}

std::span<char> GatewayParser::room() noexcept {
  if (begin_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, size_ - begin_);
    size_ -= begin_;
    begin_ = 0;
  }
  return std::span(buffer_).subspan(size_);
}

GatewayMessage GatewayParser::next() noexcept {
  for (;;) {
    const std::string_view left(buffer_.data() + begin_, size_ - begin_);
    if (skipping_) {
      const std::size_t end = left.find_first_of("<>");
      if (end == std::string_view::npos) {
        clear();
        return {};
      }
      begin_ += left[end] == '>' ? end + 1 : end;
      skipping_ = false;
      continue;
    }
    const std::size_t start = left.find('<');
    if (start == std::string_view::npos) {
      clear();
      return {};
    }
    begin_ += start;
    const std::string_view body = left.substr(start + 1);
    // a message that never ended is given up where the next one starts
    const std::size_t end = body.find_first_of("<>");
    if (end == std::string_view::npos) {
      if (body.size() < kLongest) return {};
      begin_ += 1;
      skipping_ = true;
      return of_kind(Kind::Broken);
    }
    const bool whole = body[end] == '>' && end < kLongest;
    begin_ += 1 + end + (body[end] == '>' ? 1 : 0);
    return whole ? parse_gateway_message(body.substr(0, end)) : of_kind(Kind::Broken);
  }
}

std::string_view write_gateway_send(const CanFrame& frame, std::array<char, 64>& into) noexcept {
  constexpr char kDigits[] = "0123456789ABCDEF";
  std::size_t n = 0;
  const auto put = [&](char c) { into[n++] = c; };
  for (const char c : std::string_view("< send ")) put(c);
  for (const int shift : {8, 4, 0}) put(kDigits[frame.id >> shift & 15]);
  const std::uint8_t length = std::min<std::uint8_t>(frame.length, 8);
  put(' ');
  put(kDigits[length]);
  for (std::size_t i = 0; i < length; ++i) {
    put(' ');
    put(kDigits[frame.data[i] >> 4]);
    put(kDigits[frame.data[i] & 15]);
  }
  put(' ');
  put('>');
  return {into.data(), n};
}

}  // namespace colift::hal
