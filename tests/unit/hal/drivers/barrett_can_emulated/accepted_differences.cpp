#include "accepted_differences.hpp"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <cstddef>

namespace colift {
namespace {

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

bool matches(const AcceptedDifference& accepted, const std::string& words) {
  return fnmatch((accepted.words + "*").c_str(), words.c_str(), FNM_NOESCAPE) == 0;
}

}  // namespace

hal::Result<std::vector<AcceptedDifference>> read_accepted(std::string_view text, const std::string& name) {
  std::vector<AcceptedDifference> all;
  for (std::uint32_t number = 1; !text.empty(); ++number) {
    const std::string_view line = trimmed(text.substr(0, text.find('\n')));
    text.remove_prefix(
        std::min(text.size(), text.find('\n') == text.npos ? text.size() : text.find('\n') + 1));
    if (line.empty() || line.front() == '#') continue;
    const std::size_t space = line.find(' '), hash = line.find(" #");
    const std::string_view side = line.substr(0, space);
    const bool whole = space != line.npos && hash != line.npos && space < hash;
    const std::string_view words = whole ? trimmed(line.substr(space, hash - space)) : std::string_view{};
    if ((side != "driver" && side != "emulator") || words.empty() || trimmed(line.substr(hash + 2)).empty())
      return hal::failure(hal::ErrorCode::BadInput, fmt::format("{}:{}", name, number),
                          "expected \"driver WORDS # REASON\" or \"emulator WORDS # REASON\"");
    all.push_back({side == "driver", std::string(words), number});
  }
  return all;
}

std::string judge_kept(const std::vector<AcceptedDifference>& accepted,
                       const std::optional<hal::DriverReplay>& driver,
                       const tools::EmulatorReplay& emulator) {
  std::string remains;
  std::vector<bool> occurs(accepted.size(), false);
  const auto judge = [&](bool of_driver, const std::vector<hal::barrett::ReplayDifference>& differences,
                         std::uint64_t more) {
    const std::string_view side = of_driver ? "driver" : "emulator";
    for (const auto& d : differences) {
      bool is_accepted = false;
      for (std::size_t i = 0; i < accepted.size(); ++i) {
        if (accepted[i].of_driver != of_driver || !matches(accepted[i], d.words)) continue;
        occurs[i] = is_accepted = true;
      }
      if (!is_accepted) remains += fmt::format("line {}: {}: {}\n", d.line, side, d.words);
    }
    if (more > 0) remains += fmt::format("{}: {} differences more than can be listed\n", side, more);
  };
  if (driver) judge(true, driver->differences, driver->more);
  judge(false, emulator.differences, emulator.more);
  for (std::size_t i = 0; i < accepted.size(); ++i)
    if (!occurs[i])
      remains += fmt::format("accepted in line {}, occurs no more: {} {}\n", accepted[i].line,
                             accepted[i].of_driver ? "driver" : "emulator", accepted[i].words);
  return remains;
}

}  // namespace colift
