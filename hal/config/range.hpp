#pragma once

#include <initializer_list>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace colift::hal {

/// Smallest and largest value that a configuration entry may take (both included). NaN is in no range.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
};

inline constexpr Range kAny{};
inline constexpr Range kPositive{std::numeric_limits<double>::min(), std::numeric_limits<double>::infinity()};
inline constexpr Range kNotNegative{0.0, std::numeric_limits<double>::infinity()};
inline constexpr Range kFraction{0.0, 1.0};

/// The texts that a configuration entry may take.
struct Choices {
  Choices(std::initializer_list<std::string_view> allowed) : names(allowed.begin(), allowed.end()) {}
  std::vector<std::string> names;
};

/// Whether a file may leave an entry out; the default then holds.
enum class Presence { Optional, Required };

// A configuration struct names its fields once, for reading, checking and printing alike:
//
//   struct GroundConfig {
//     double max_tilt_deg = 50.0;
//     template <class Visitor>
//     void visit(Visitor& v) {
//       v("max_tilt_deg", max_tilt_deg, Range{0, 90}, "Largest angle between the ground's normal and up.");
//     }
//   };
//
// A nested struct is a field too: v("ground", ground, "How the ground is found.").
// Values may be bool, int, double, std::string, Vec3, std::vector<double>, std::optional<double>,
// std::optional<Vec3>, a struct with visit(), or std::vector of such a struct. Numbers, also those in lists,
// take a Range before the help, texts take Choices{"box", "cylinder"}. Presence::Required as last argument: a
// file has to give it.
//
// Not finite is refused, except where the default is: a double that starts as NaN may be .nan (unset) in a
// file, one that starts as infinity may be .inf (no limit).

}  // namespace colift::hal
