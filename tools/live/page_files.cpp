#include "tools/live/page_files.hpp"

#include <array>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

namespace colift::live {
namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 9> kTypes{{
    {".html", "text/html; charset=utf-8"},
    {".js", "text/javascript; charset=utf-8"},
    {".css", "text/css; charset=utf-8"},
    {".json", "application/json"},
    {".svg", "image/svg+xml"},
    {".png", "image/png"},
    {".ico", "image/x-icon"},
    {".woff2", "font/woff2"},
    {".txt", "text/plain; charset=utf-8"},
}};

constexpr std::uintmax_t kLargestFile = 32u << 20;

constexpr const char* kNoPage =
    "<!doctype html><meta charset=utf-8><title>CoLift</title><body style='font:16px "
    "sans-serif;max-width:40em;margin:3em'>"
    "<h1>CoLift is running</h1><p>The page that shows the run was not built with this program: Node.js and "
    "npm were not "
    "there. Run <code>tools/build</code> again with both installed.</p><p>Everything else works: Foxglove "
    "and Lichtblick "
    "can open a connection to this address.</p>";

int hex(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

}  // namespace

std::optional<std::string> clean_path(std::string_view target) {
  target = target.substr(0, target.find_first_of("?#"));
  if (target.empty() || target.front() != '/' || target.size() > 512) return std::nullopt;
  std::string path;
  for (std::size_t i = 0; i < target.size(); ++i) {
    char c = target[i];
    if (c == '%') {
      if (i + 2 >= target.size() || hex(target[i + 1]) < 0 || hex(target[i + 2]) < 0) return std::nullopt;
      c = static_cast<char>(hex(target[i + 1]) * 16 + hex(target[i + 2]));
      i += 2;
    }
    if (static_cast<unsigned char>(c) < 0x20 || c == '\\' || c == 0x7F) return std::nullopt;
    path.push_back(c);
  }
  // no step up, and nothing hidden
  if (path.find("/.") != std::string::npos || path.find("//") != std::string::npos) return std::nullopt;
  return path;
}

std::shared_ptr<const Document> PageFiles::find(std::string_view target) const {
  auto path = clean_path(target);
  if (!path) return nullptr;
  if (*path == "/") *path = "/index.html";
  if (const auto made = made_.find(*path); made != made_.end()) return made->second;
  for (const auto& [ending, type] : kTypes) {
    if (!path->ends_with(ending)) continue;
    const std::filesystem::path file = folder_ / path->substr(1);
    std::error_code error;
    if (std::filesystem::is_regular_file(file, error) &&
        std::filesystem::file_size(file, error) <= kLargestFile) {
      std::ifstream in(file, std::ios::binary);
      if (in)
        return std::make_shared<const Document>(
            Document{std::string(type), {std::istreambuf_iterator<char>(in), {}}});
    }
  }
  if (*path == "/index.html")
    return std::make_shared<const Document>(Document{"text/html; charset=utf-8", kNoPage});
  return nullptr;
}

std::filesystem::path PageFiles::beside_program() {
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) return "dashboard";
  const auto beside = program.parent_path() / "dashboard";
  if (std::filesystem::exists(beside / "index.html", error)) return beside;
  return program.parent_path().parent_path() / "share" / "colift" / "dashboard";
}

}  // namespace colift::live
