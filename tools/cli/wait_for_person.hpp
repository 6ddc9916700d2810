#pragma once

#include <optional>

#include "hal/types/result.hpp"

namespace colift::tools {

/// Returns when a person has pressed Enter at the terminal; with `pause_s` by itself, so long after. An
/// InterruptGuard has to be there. Errors: NotReady (interrupted), BadInput (standard input has ended).
[[nodiscard]] hal::Result<> wait_for_person(std::optional<double> pause_s);

}  // namespace colift::tools
