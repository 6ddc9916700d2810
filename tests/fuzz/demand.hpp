#pragma once

#include <cstdlib>

namespace colift::fuzz {

/// Ends the target, and shows the input, when what must hold does not.
inline void demand(bool fact) {
  if (!fact) std::abort();
}

}  // namespace colift::fuzz
