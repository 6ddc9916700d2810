#include "tools/check/cmd_schema.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "hal/config/nearest_name.hpp"
#include "tools/cli/options.hpp"

namespace colift::tools {
namespace {

struct Schema {
  std::string_view name, text;
};

// the shipped files themselves, compiled in
constexpr Schema kSchemas[] = {
#include "schemas.inc"
};

std::string title(const Schema& schema) {
  return nlohmann::json::parse(schema.text).value("title", "");
}

}  // namespace

int cmd_schema(const std::string& name, bool json) {
  if (name.empty()) {
    nlohmann::ordered_json names = nlohmann::ordered_json::array();
    for (const Schema& s : kSchemas) names.push_back(s.name);
    if (json)
      std::puts(names.dump().c_str());
    else
      for (const Schema& s : kSchemas) fmt::print("{:<16} {}\n", s.name, title(s));
    return kDone;
  }
  const auto* found =
      std::find_if(std::begin(kSchemas), std::end(kSchemas), [&](const Schema& s) { return s.name == name; });
  if (found == std::end(kSchemas)) {
    std::vector<std::string> names;
    for (const Schema& s : kSchemas) names.emplace_back(s.name);
    const auto meant = hal::nearest_path(name, names);
    fmt::print(stderr, "colift schema: there is no schema \"{}\"; {}\n", name,
               meant ? fmt::format("did you mean {}?", *meant) : "colift schema lists them");
    return kBadInput;
  }
  std::fwrite(found->text.data(), 1, found->text.size(), stdout);
  return kDone;
}

}  // namespace colift::tools
