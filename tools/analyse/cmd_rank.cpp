#include "tools/analyse/cmd_rank.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>

#include "planner/load_sharing/rank.hpp"
#include "tools/analyse/rank_json.hpp"

namespace colift::tools {
namespace {

// About a million candidates. A device or a wrong file must end here, not in swap.
constexpr std::size_t kMaxBytes = 64u << 20;

hal::Result<std::string> read_all(const std::filesystem::path& path, const std::string& name) {
  const auto refuse = [&](std::string why) {
    return hal::failure(hal::ErrorCode::BadInput, name, std::move(why));
  };
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> opened(nullptr, &std::fclose);
  std::FILE* file = stdin;
  if (path != "-") {
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored)) return refuse("is a directory, expected a JSON file");
    opened.reset(std::fopen(path.c_str(), "rb"));
    if (!opened) return refuse(fmt::format("cannot be opened: {}", std::strerror(errno)));
    file = opened.get();
  }
  std::string text;
  char block[1 << 16];
  while (const std::size_t n = std::fread(block, 1, sizeof block, file)) {
    text.append(block, n);
    if (text.size() > kMaxBytes)
      return refuse(fmt::format("is longer than {} MiB, the most that is read", kMaxBytes >> 20));
  }
  if (std::ferror(file)) return refuse(fmt::format("cannot be read: {}", std::strerror(errno)));
  return text;
}

}  // namespace

int cmd_rank(const std::filesystem::path& problem, bool json) {
  const std::string name = problem == "-" ? "<stdin>" : problem.string();
  const auto refuse = [](const hal::Error& error) {
    std::fputs(fmt::format("colift rank: {}\n", error.text()).c_str(), stderr);
    return 2;
  };
  const auto text = read_all(problem, name);
  if (!text) return refuse(text.error());
  const auto parsed = parse_rank_problem(*text, name);
  if (!parsed) return refuse(parsed.error());
  auto ranked = planner::rank(*parsed);
  if (!ranked) {
    hal::Error error = ranked.error();
    error.where = name + ": " + error.where;
    return refuse(error);
  }
  const std::string out = json ? rank_to_json(*ranked) + "\n" : rank_to_table(*parsed, *ranked);
  if (std::fwrite(out.data(), 1, out.size(), stdout) != out.size() || std::fflush(stdout) != 0) {
    std::fputs(fmt::format("colift rank: the output cannot be written: {}\n", std::strerror(errno)).c_str(),
               stderr);
    return 4;
  }
  return 0;
}

}  // namespace colift::tools
