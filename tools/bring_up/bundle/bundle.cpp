#include "tools/bring_up/bundle/bundle.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

namespace colift::tools {
namespace {

constexpr std::size_t kBlock = 512;
constexpr std::size_t kLongestName = 80;

bool is_name(const std::string& name) {
  return !name.empty() && name.size() <= kLongestName && name.front() != '.' &&
         std::all_of(name.begin(), name.end(), [](unsigned char c) {
           return std::isalnum(c) != 0 || c == '.' || c == '-' || c == '_';
         });
}

// fields of the header: offset and text; numbers in octal with a zero at their end
std::string header(const std::string& path, std::size_t size) {
  std::array<char, kBlock> block{};
  const auto put = [&](std::size_t at, const std::string& text) {
    std::copy(text.begin(), text.end(), block.begin() + static_cast<std::ptrdiff_t>(at));
  };
  put(0, path);
  put(100, "0000644");
  put(108, "0000000");
  put(116, "0000000");
  put(124, fmt::format("{:011o}", size));
  put(136, "00000000000");
  put(148, "        ");
  put(156, "0");
  put(257, "ustar");
  put(263, "00");
  unsigned sum = 0;
  for (const char c : block) sum += static_cast<unsigned char>(c);
  put(148, fmt::format("{:06o}", sum));
  block[154] = '\0';
  return {block.data(), block.size()};
}

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

}  // namespace

std::string bundle_bytes(const std::string& folder, const std::vector<BundlePart>& parts) {
  std::string tar;
  for (const BundlePart& part : parts) {
    if (!is_name(part.name)) continue;
    tar += header((is_name(folder) ? folder + "/" : "") + part.name, part.text.size());
    tar += part.text;
    tar.append((kBlock - part.text.size() % kBlock) % kBlock, '\0');
  }
  return tar.append(2 * kBlock, '\0');
}

hal::Result<> check_new_bundle(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return {};
  return hal::failure(hal::ErrorCode::BadInput, file.string(),
                      "exists already and is kept; choose another --out");
}

hal::Result<> write_bundle(const std::filesystem::path& file, const std::vector<BundlePart>& parts) {
  const std::string bytes = bundle_bytes(file.stem().string(), parts);
  const auto bad = [&](const char* why) {
    return hal::failure(hal::ErrorCode::BadInput, file.string(), fmt::format("cannot be written: {}", why));
  };
  const std::unique_ptr<std::FILE, CloseFile> out(std::fopen(file.c_str(), "wxe"));
  if (!out) return bad(std::strerror(errno));
  if (std::fwrite(bytes.data(), 1, bytes.size(), out.get()) != bytes.size() || std::fflush(out.get()) != 0)
    return bad(std::strerror(errno));
  return {};
}

}  // namespace colift::tools
