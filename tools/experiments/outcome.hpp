#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hal/types/result.hpp"
#include "tools/experiments/campaign.hpp"

namespace colift::experiments {

/// Figures of one method of a campaign.
struct MethodFigures {
  std::string method;
  std::vector<Figure> figures;
};
[[nodiscard]] std::vector<MethodFigures> figures_of(const Experiment& experiment, const Campaign& campaign);

/// Document colift.experiment/1, one line.
[[nodiscard]] std::string experiment_document(const Experiment& experiment, const Campaign& campaign);
/// The figures in words, the thesis's beside them.
[[nodiscard]] std::string experiment_text(const Experiment& experiment, const Campaign& campaign);

/// NAME.json, NAME.png (of the first method) and, where there is more than one method, NAME_METHOD.png.
/// Errors: BadInput (cannot be written).
[[nodiscard]] hal::Result<> write_outcome(const Experiment& experiment, const Campaign& campaign,
                                          const std::filesystem::path& folder);

/// One page over all experiments whose tables are in the folder: index.html. Errors: BadInput.
[[nodiscard]] hal::Result<> write_index(const std::filesystem::path& folder);

}  // namespace colift::experiments
