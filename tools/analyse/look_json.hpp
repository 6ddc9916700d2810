#pragma once

#include <optional>
#include <string>

#include "control/session/suggest.hpp"
#include "tools/analyse/recorded_scene.hpp"

namespace colift::tools {

/// The document colift.look/1, one line, without a line end. Numbers are printed so that they read back to
/// the same bits.
[[nodiscard]] std::string look_document(const Seen& seen);

/// The document colift.decide/1: all of look's, and partner, decision and a verdict in every candidate.
[[nodiscard]] std::string decide_document(const Seen& seen, const control::Outcome& outcome,
                                          const std::optional<control::Suggestion>& suggestion);

}  // namespace colift::tools
