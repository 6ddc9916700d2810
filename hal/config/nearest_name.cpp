#include "hal/config/nearest_name.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace colift::hal {
namespace {

// names of configuration entries are short; a longer one is no slip and would cost quadratic time
constexpr std::size_t kLongestName = 200;

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

/// "ground.max_tilt_deg" -> "ground", "max_tilt_deg"; "seed" -> "", "seed".
std::pair<std::string_view, std::string_view> split_leaf(std::string_view path) {
  const std::size_t dot = path.rfind('.');
  if (dot == std::string_view::npos) return {{}, path};
  return {path.substr(0, dot), path.substr(dot + 1)};
}

/// "yaw" for "yaw_deg": whole words left out at the end, most often the unit.
bool is_beginning(std::string_view name, std::string_view of) {
  return of.size() > name.size() && of.starts_with(name) && of[name.size()] == '_';
}

}  // namespace

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before_last(b.size() + 1);
  std::vector<std::size_t> last(b.size() + 1);
  std::vector<std::size_t> now(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    now[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = lower(a[i - 1]) == lower(b[j - 1]) ? 0 : 1;
      now[j] = std::min({last[j] + 1, now[j - 1] + 1, last[j - 1] + change});
      const bool swapped =
          i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) && lower(a[i - 2]) == lower(b[j - 1]);
      if (swapped) now[j] = std::min(now[j], before_last[j - 2] + 1);
    }
    std::swap(before_last, last);
    std::swap(last, now);
  }
  return last[b.size()];
}

std::optional<std::string> nearest_path(std::string_view path, std::span<const std::string> known) {
  if (path.size() > kLongestName) return std::nullopt;
  const auto [group, leaf] = split_leaf(path);
  const std::string* best = nullptr;
  std::size_t least = 0;
  for (const std::string& candidate : known) {
    const auto [known_group, known_leaf] = split_leaf(candidate);
    const std::size_t leaf_distance = is_beginning(leaf, known_leaf) || is_beginning(known_leaf, leaf)
                                          ? 1
                                          : edit_distance(leaf, known_leaf);
    const std::size_t by_leaf = leaf_distance + (group == known_group ? 0 : 1);
    const std::size_t distance = std::min(by_leaf, edit_distance(path, candidate));
    if (!best || distance < least) {
      best = &candidate;
      least = distance;
    }
  }
  // a third of the letters wrong is still a slip, more is another word
  const std::size_t tolerable = leaf.size() < 4 ? 1 : std::max<std::size_t>(2, leaf.size() / 3);
  if (!best || least > tolerable || least >= leaf.size()) return std::nullopt;
  return *best;
}

}  // namespace colift::hal
