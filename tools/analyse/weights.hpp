#pragma once

#include <string>

#include "control/config/config.hpp"
#include "control/session/look.hpp"
#include "hal/types/result.hpp"

namespace colift::tools {

/// "fast" or "thesis"; empty: as configured. Errors: BadInput.
[[nodiscard]] hal::Result<control::Method> parse_method(const std::string& text,
                                                        const control::Config& config);

/// Sets how the load is to be shared: by --share or --epsilon (texts as typed, empty: unset), else as
/// configured; the thesis's method takes the thesis's weights. Errors: BadInput.
[[nodiscard]] hal::Result<> set_weights(control::Method method, const std::string& share,
                                        const std::string& epsilon, control::Config& config);

}  // namespace colift::tools
