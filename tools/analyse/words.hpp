#pragma once

#include <optional>
#include <string>

#include "control/session/suggest.hpp"
#include "tools/analyse/recorded_scene.hpp"

namespace colift::tools {

/// The words of the JSON documents, the tables and the pictures alike.
[[nodiscard]] const char* word(planner::Verdict verdict);
[[nodiscard]] const char* word(perception::RejectedObject::Kind kind);

/// One line on a surface.
[[nodiscard]] std::string surface_line(const perception::Surface& surface);

/// What a look found, for a person.
[[nodiscard]] std::string look_text(const Seen& seen);

/// What was decided, for a person.
[[nodiscard]] std::string decide_text(const control::Outcome& outcome,
                                      const std::optional<control::Suggestion>& suggestion);

}  // namespace colift::tools
