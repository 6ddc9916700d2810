#include "hal/can_log/candump.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <fstream>
#include <optional>

namespace colift::hal {
namespace {

constexpr std::uint32_t kErrorFrame = 0x20000000;     // CAN_ERR_FLAG of linux/can.h
constexpr std::int64_t kMostSeconds = 9'000'000'000;  // fits nanoseconds of 64 bits
constexpr Duration kMostBack =
    std::chrono::seconds(1);  // a frame is logged when it is read, not when it came
constexpr std::size_t kLongestInterface = 15;

std::optional<std::uint32_t> hex(std::string_view digits) {
  std::uint32_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
  if (digits.empty() || error != std::errc{} || end != digits.data() + digits.size()) return std::nullopt;
  return value;
}

// "(12.345678)" off the front; nullopt and nothing taken when there is none
std::optional<Timestamp> take_time(std::string_view& rest) {
  const std::size_t close = rest.find(')');
  if (rest.empty() || rest.front() != '(' || close == std::string_view::npos) return std::nullopt;
  const std::string_view inside = rest.substr(1, close - 1);
  const std::size_t dot = inside.find('.');
  if (dot == std::string_view::npos || dot == 0 || dot > 12 || inside.size() - dot - 1 != 6)
    return std::nullopt;
  std::int64_t whole = 0, micro = 0;
  const auto number = [](std::string_view digits, std::int64_t& value) {
    return std::all_of(digits.begin(), digits.end(), [](char c) { return c >= '0' && c <= '9'; }) &&
           std::from_chars(digits.data(), digits.data() + digits.size(), value).ec == std::errc{};
  };
  if (!number(inside.substr(0, dot), whole) || !number(inside.substr(dot + 1), micro) || whole > kMostSeconds)
    return std::nullopt;
  rest.remove_prefix(close + 1);
  return std::chrono::seconds(whole) + std::chrono::microseconds(micro);
}

std::string_view take_word(std::string_view& rest) {
  while (!rest.empty() && rest.front() == ' ') rest.remove_prefix(1);
  const std::string_view word = rest.substr(0, rest.find(' '));
  rest.remove_prefix(word.size());
  return word;
}

class Parser {
 public:
  explicit Parser(const std::string& name) : name_(name) {}

  // an empty text, or why the line is refused
  std::string line(std::string_view text) {
    ++line_;
    if (!text.empty() && text.back() == '\r') text.remove_suffix(1);
    if (text.size() > kLongestCandumpLine)
      return fmt::format("{} characters, at most {} are a line", text.size(), kLongestCandumpLine);
    const bool printable = std::all_of(text.begin(), text.end(),
                                       [](unsigned char c) { return (c >= ' ' && c != 127) || c == '\t'; });
    if (!printable) return "bytes that are no text";
    if (text.empty()) return {};
    if (text.front() == '#') return note(text.substr(1));
    return frame(text);
  }

  Candump take() {
    std::stable_sort(
        log_.frames.begin(), log_.frames.end(),
        [](const CandumpFrame& a, const CandumpFrame& b) { return a.frame.arrived_at < b.frame.arrived_at; });
    return std::move(log_);
  }
  [[nodiscard]] std::string where() const { return fmt::format("{}:{}", name_, line_); }

 private:
  std::string note(std::string_view text) {
    if (!text.empty() && text.front() == ' ') text.remove_prefix(1);
    const auto at = take_time(text);
    if (at && !text.empty() && text.front() == ' ') text.remove_prefix(1);
    log_.notes.push_back({at.value_or(latest_), std::string(text), line_});
    return {};
  }

  std::string frame(std::string_view rest) {
    const auto at = take_time(rest);
    if (!at) return "expected (SECONDS.MICROSECONDS) INTERFACE IDENTIFIER#BYTES, as candump -L writes";
    if (*at + kMostBack < latest_) return "its time is more than a second before that of a line above";
    const std::string_view interface = take_word(rest), words = take_word(rest), letter = take_word(rest);
    if (interface.empty() || interface.size() > kLongestInterface) return "no name of an interface";
    if (!take_word(rest).empty() || (!letter.empty() && letter != "R" && letter != "T"))
      return "expected the end of the line, or R or T";
    const std::size_t mark = words.find('#');
    if (mark == std::string_view::npos) return "no # between identifier and bytes";
    const std::string_view id_text = words.substr(0, mark), bytes = words.substr(mark + 1);
    const auto id = hex(id_text);
    if (!id || (id_text.size() != 3 && id_text.size() != 8))
      return fmt::format("\"{}\" is no identifier of three hexadecimal digits", id_text.substr(0, 20));
    const bool is_error = id_text.size() == 8 && (*id & kErrorFrame) != 0;
    if (id_text.size() == 8 && !is_error) return "a 29-bit identifier: the hand has none";
    if (!is_error && *id > 0x7ff) return "an identifier above 7FF";
    if (!bytes.empty() && bytes.front() == '#') return "a CAN FD frame: the hand's bus has none";
    if (!bytes.empty() && (bytes.front() == 'R' || bytes.front() == 'r'))
      return "a remote frame: the hand's bus has none";
    if (bytes.size() % 2 != 0 || bytes.size() > 16) return "expected zero to eight bytes of two digits each";
    CandumpFrame read;
    read.frame.id = static_cast<std::uint16_t>(*id & 0x7ff);
    read.frame.length = static_cast<std::uint8_t>(bytes.size() / 2);
    for (std::size_t i = 0; i < bytes.size(); i += 2) {
      const auto byte = hex(bytes.substr(i, 2));
      if (!byte) return fmt::format("\"{}\" is no byte", bytes.substr(i, 2));
      read.frame.data[i / 2] = static_cast<std::uint8_t>(*byte);
    }
    if (log_.interface.empty()) log_.interface = interface;
    if (log_.interface != interface)
      return fmt::format("interface {}, but {} above: one bus at a time", interface, log_.interface);
    latest_ = std::max(latest_, *at);
    if (is_error) {
      ++log_.error_frames;
      return {};
    }
    read.frame.arrived_at = *at;
    read.line = line_;
    read.direction = letter == "R"   ? CandumpFrame::Direction::Received
                     : letter == "T" ? CandumpFrame::Direction::Sent
                                     : CandumpFrame::Direction::Unknown;
    log_.frames.push_back(read);
    return {};
  }

  const std::string& name_;
  Candump log_;
  Timestamp latest_{0};
  std::uint32_t line_ = 0;
};

}  // namespace

Result<Candump> parse_candump(std::string_view text, const std::string& name) {
  if (text.size() > kMostCandumpBytes)
    return failure(ErrorCode::BadInput, name,
                   fmt::format("{} bytes, at most {} are read", text.size(), kMostCandumpBytes));
  Parser parser(name);
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    if (std::string why = parser.line(text.substr(0, end)); !why.empty())
      return failure(ErrorCode::BadInput, parser.where(), std::move(why));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return parser.take();
}

Result<Candump> read_candump(const std::filesystem::path& file) {
  const auto bad = [&](std::string why) {
    return failure(ErrorCode::BadInput, file.string(), std::move(why));
  };
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return bad("is no file");
  const auto size = std::filesystem::file_size(file, error);
  if (error) return bad("its size cannot be read");
  if (size > kMostCandumpBytes)
    return bad(fmt::format("{} bytes, at most {} are read", size, kMostCandumpBytes));
  std::ifstream in(file, std::ios::binary);
  std::string text(static_cast<std::size_t>(size), '\0');
  if (!in.read(text.data(), static_cast<std::streamsize>(size))) return bad("cannot be read");
  return parse_candump(text, file.string());
}

std::size_t write_candump(std::span<char> buffer, std::string_view interface, const CanFrame& frame,
                          Timestamp at, CandumpFrame::Direction direction) noexcept {
  const auto micros = std::chrono::duration_cast<std::chrono::microseconds>(at).count();
  const auto size = static_cast<std::ptrdiff_t>(buffer.size());
  char* to = fmt::format_to_n(buffer.data(), static_cast<std::size_t>(size), "({:010}.{:06}) {} {:03X}#",
                              micros / 1'000'000, micros % 1'000'000, interface.substr(0, kLongestInterface),
                              frame.id)
                 .out;
  for (std::size_t i = 0; i < std::min<std::size_t>(frame.length, 8); ++i)
    to = fmt::format_to(to, "{:02X}", frame.data[i]);
  const std::string_view tail = direction == CandumpFrame::Direction::Sent       ? " T\n"
                                : direction == CandumpFrame::Direction::Received ? " R\n"
                                                                                 : "\n";
  to = std::copy(tail.begin(), tail.end(), to);
  return static_cast<std::size_t>(to - buffer.data());
}

std::string candump_time(Timestamp at) {
  const auto micros = std::chrono::duration_cast<std::chrono::microseconds>(at).count();
  return fmt::format("({:010}.{:06})", micros / 1'000'000, micros % 1'000'000);
}

}  // namespace colift::hal
