#include "hal/drivers/recorded/file_bytes.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <limits>
#include <system_error>

namespace colift::hal {
namespace {

constexpr std::uintmax_t kLargestFile = std::uintmax_t{1} << 31;

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\v' || c == '\f';
}

}  // namespace

Result<std::vector<std::byte>> load_file(const std::filesystem::path& file) {
  namespace fs = std::filesystem;
  const auto refuse = [&](std::string detail) {
    return failure(ErrorCode::BadInput, file.string(), std::move(detail));
  };
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::not_found) return refuse("there is no such file");
  if (error) return refuse("the file cannot be reached: " + error.message());
  if (status.type() == fs::file_type::directory) return refuse("this is a directory; expected a file");
  // a pipe or a device may never end
  if (status.type() != fs::file_type::regular) return refuse("this is not a regular file");
  const std::uintmax_t size = fs::file_size(file, error);
  if (error) return refuse("the size of the file is unknown: " + error.message());
  if (size == 0) return refuse("the file is empty (0 bytes)");
  if (size > kLargestFile) {
    return refuse(fmt::format("the file has {} bytes; at most {} are read", size, kLargestFile));
  }

  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  if (!stream) {
    return refuse("the file cannot be opened: " + std::generic_category().message(errno != 0 ? errno : EIO));
  }
  std::vector<std::byte> bytes(static_cast<std::size_t>(size));
  stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (static_cast<std::size_t>(stream.gcount()) != bytes.size()) {
    return refuse(fmt::format("only {} of {} bytes could be read", stream.gcount(), bytes.size()));
  }
  return bytes;
}

std::string shown(std::string_view text) {
  constexpr std::size_t kShown = 40;
  std::string out = "'";
  for (const char c : text.substr(0, kShown)) {
    const auto code = static_cast<unsigned char>(c);
    if (code >= 0x20 && code < 0x7f) {
      out += c;
    } else {
      out += fmt::format("\\x{:02x}", code);
    }
  }
  out += text.size() > kShown ? "...'" : "'";
  return out;
}

std::optional<double> to_number(std::string_view word) {
  // from_chars knows no plus sign, several writers do
  if (word.size() > 1 && word.front() == '+' && word[1] != '-') word.remove_prefix(1);
  double value = std::numeric_limits<double>::quiet_NaN();
  const char* const end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, value);
  if (error != std::errc{} || stop != end) return std::nullopt;
  return value;
}

std::optional<std::uint64_t> to_count(std::string_view word) {
  std::uint64_t value = 0;
  const char* const end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, value);
  if (error != std::errc{} || stop != end || value > (std::uint64_t{1} << 63)) return std::nullopt;
  return value;
}

std::string_view next_word(std::string_view& rest) {
  std::size_t begin = 0;
  while (begin < rest.size() && is_space(rest[begin])) ++begin;
  std::size_t end = begin;
  while (end < rest.size() && !is_space(rest[end])) ++end;
  const std::string_view word = rest.substr(begin, end - begin);
  rest.remove_prefix(end);
  return word;
}

std::optional<std::string_view> LineScanner::next() {
  if (offset_ >= bytes_.size()) return std::nullopt;
  const std::string_view rest = as_text(bytes_.subspan(offset_));
  const std::size_t feed = rest.find('\n');
  std::string_view line = rest.substr(0, feed);
  offset_ += feed == std::string_view::npos ? rest.size() : feed + 1;
  ++line_;
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

}  // namespace colift::hal
