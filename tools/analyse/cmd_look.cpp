#include <cstdio>
#include <string>

#include "tools/analyse/look_json.hpp"
#include "tools/analyse/show.hpp"
#include "tools/analyse/words.hpp"
#include "tools/cli/commands.hpp"
#include "tools/cli/config_of.hpp"

namespace colift::tools {

int cmd_look(const CommonOptions& common, const LookOptions& options) {
  const auto setup = load_setup(config_of_look(common, options));
  if (!setup) return report_error("look", setup.error());
  show_warnings("look", common, *setup);
  const auto seen = look_at_file(options, *setup);
  if (!seen) return report_error("look", seen.error());
  if (common.json)
    std::puts(look_document(*seen).c_str());
  else
    std::fputs((common.quiet ? seen->analysis.reason + "\n" : look_text(*seen)).c_str(), stdout);
  std::fflush(stdout);
  if (auto shown = show(*seen, nullptr, options, common, *setup); !shown)
    return report_error("look", shown.error());
  return seen->analysis.scene.target ? kDone : kNoGoal;
}

}  // namespace colift::tools
