#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "tools/run/run_view.hpp"

namespace colift::tools {

/// The run as an animated PNG, from the approach to the end; and its last picture for who wants nothing to
/// move.
struct RunFilm {
  std::vector<std::uint8_t> film, still;  ///< PNG; `still` is the last picture.
  double from_s = 0.0, to_s = 0.0;        ///< Time of the run that it shows.
};

/// nullopt without scenes of the simulation.
[[nodiscard]] std::optional<RunFilm> run_film(const RunView& view);

}  // namespace colift::tools
