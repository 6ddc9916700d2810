#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace colift::hal {

/// Fewest insertions, deletions, replacements and swaps of neighbours that turn one text into the other, no
/// letter touched twice (optimal string alignment). Case does not count.
[[nodiscard]] std::size_t edit_distance(std::string_view a, std::string_view b);

/// The dotted path that somebody most likely meant by `path`: by the whole path, or by the last name alone if
/// it only stands in the wrong group. A name without its last words (the unit) is one slip. Nothing when even
/// the best one is too different to be a slip. The first one wins a tie.
[[nodiscard]] std::optional<std::string> nearest_path(std::string_view path,
                                                      std::span<const std::string> known);

}  // namespace colift::hal
