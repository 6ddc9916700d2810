#include "tools/check/cmd_shipped.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tools/cli/options.hpp"

namespace colift::tools {
namespace {

constexpr std::size_t kColumns = 100;  // of a terminal

/// Words of `text` in lines, each but the first behind `indent` spaces.
std::string wrapped(const std::string& text, std::size_t indent) {
  std::string out;
  std::size_t column = indent;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    if (column > indent && column + 1 + (end - at) > kColumns) {
      out += '\n' + std::string(indent, ' ');
      column = indent;
    } else if (column > indent) {
      out += ' ';
      ++column;
    }
    out.append(text, at, end - at);
    column += end - at;
    at = end + 1;
  }
  return out;
}

}  // namespace

int cmd_shipped(ShippedKind kind, bool json) {
  const auto files = shipped_files(kind);
  if (files.empty()) {
    fmt::print(stderr, "colift: no {} is beside this program; install CoLift anew\n", word_of(kind));
    return kBadInput;
  }
  if (json) {
    nlohmann::ordered_json out = {
        {"schema", "colift.shipped/1"}, {"kind", word_of(kind)}, {"files", nlohmann::ordered_json::array()}};
    for (const ShippedFile& f : files)
      out["files"].push_back({{"name", f.name}, {"file", f.file.string()}, {"about", f.about}});
    fmt::print("{}\n", out.dump());
    return kDone;
  }
  std::size_t width = 0;
  for (const ShippedFile& f : files) width = std::max(width, f.name.size());
  for (const ShippedFile& f : files) fmt::print("{:<{}}  {}\n", f.name, width, wrapped(f.about, width + 2));
  return kDone;
}

}  // namespace colift::tools
