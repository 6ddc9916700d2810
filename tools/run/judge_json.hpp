#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "sim_hal/judge/verdict.hpp"

namespace colift::tools {

/// `judge` of the document colift.run/1; null without a verdict (real devices, a replay).
[[nodiscard]] nlohmann::ordered_json judge_json(const std::optional<sim_hal::Verdict>& verdict);

}  // namespace colift::tools
