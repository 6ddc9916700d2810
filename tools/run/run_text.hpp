#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "hal/types/geometry.hpp"

namespace colift::control {
struct LiftSummary;
}

namespace colift::tools {

/// Columns that a text takes on a terminal: its UTF-8 characters.
[[nodiscard]] std::size_t columns_of(std::string_view text);

/// One line without control characters; with `ascii`, other characters become their nearest relative or '?'.
[[nodiscard]] std::string one_line(const std::string& text, bool ascii);

/// The text, or as much of it as fits with "..." at its end.
[[nodiscard]] std::string cut(const std::string& text, std::size_t columns);

/// Lines of at most `columns`, broken at spaces, inside of words only where one alone is too wide.
[[nodiscard]] std::vector<std::string> wrapped(const std::string& text, std::size_t columns);

/// A heading of fixed width and its text, broken with the text's lines beneath each other; ends in a line
/// end.
[[nodiscard]] std::string entry(const std::string& heading, const std::string& text,
                                std::size_t heading_width, std::size_t columns);

// Figures as a person reads them; "unknown" for NaN.
[[nodiscard]] std::string metres_text(double m);  ///< "5.0 cm", "8 mm", "1.20 m".
[[nodiscard]] std::string degrees_text(double rad);
[[nodiscard]] std::string percent_text(double part);
/// ", 45 to 53 %"; empty where it is not known.
[[nodiscard]] std::string share_95_text(const control::LiftSummary& lift);
/// "3.97 kg, 3.7 to 4.3 kg, by the shape's centre of gravity", or why it is not known.
[[nodiscard]] std::string mass_95_text(const control::LiftSummary& lift);
[[nodiscard]] std::string place_text(const hal::Vec3& p);

}  // namespace colift::tools
