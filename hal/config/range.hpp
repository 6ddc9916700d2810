#pragma once

#include <limits>

namespace colift::hal {

/// Smallest and largest value that a configuration entry may take (both included).
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
};

inline constexpr Range kAny{};
inline constexpr Range kPositive{std::numeric_limits<double>::min(), std::numeric_limits<double>::infinity()};
inline constexpr Range kNotNegative{0.0, std::numeric_limits<double>::infinity()};
inline constexpr Range kFraction{0.0, 1.0};

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
// Values may be bool, int, double, std::string, Vec3, std::vector<double>, or a struct with visit().

}  // namespace colift::hal
