#include <fmt/format.h>

#include <cstdio>

#include "tools/analyse/decide_why.hpp"
#include "tools/analyse/look_json.hpp"
#include "tools/analyse/show.hpp"
#include "tools/analyse/words.hpp"
#include "tools/cli/commands.hpp"
#include "tools/cli/config_of.hpp"
#include "tools/cli/numbers.hpp"

namespace colift::tools {
namespace {

hal::Result<control::PartnerInput> read_partner(const DecideOptions& options) {
  control::PartnerInput input;
  if (options.partner.empty() == !options.partner_cloud)
    return hal::failure(
        hal::ErrorCode::BadInput, "--partner",
        "say where the partner grasps the object: either --partner X,Y,Z or --partner-cloud CLOUD2");
  if (!options.partner.empty()) {
    const auto p = parse_point(options.partner, "--partner");
    if (!p) return tl::unexpected(p.error());
    input.position_W = *p;
    return input;
  }
  auto file = hal::read_frame(*options.partner_cloud, options.look.camera);
  if (!file) return tl::unexpected(file.error());
  input.frame = std::move(file->frame);
  return input;
}

}  // namespace

int cmd_decide(const CommonOptions& common, const DecideOptions& options) {
  const auto setup = load_setup(config_of_decide(common, options));
  if (!setup) return report_error("decide", setup.error());
  show_warnings("decide", common, *setup);
  const auto partner = read_partner(options);
  if (!partner) return report_error("decide", partner.error());
  const auto seen = look_at_file(options.look, *setup);
  if (!seen) return report_error("decide", seen.error());
  const auto outcome = control::decide(seen->analysis, *partner, setup->config, hal::SteadyClock());
  if (!outcome) return report_error("decide", outcome.error());

  std::optional<control::Suggestion> suggestion;
  if (seen->analysis.scene.target && seen->analysis.scene.ground)
    suggestion =
        control::suggest_to_partner(*outcome, seen->analysis.candidates, seen->analysis.scene.target->cog,
                                    seen->analysis.scene.ground->plane.normal, setup->config.decision);
  std::optional<WhyCandidate> why;
  if (options.why) {
    auto explained = explain_candidate(*outcome, setup->config, *options.why);
    if (!explained) return report_error("decide", explained.error());
    why = std::move(*explained);
  }

  if (common.json) {
    const std::string document = decide_document(*seen, *outcome, suggestion);
    std::puts((why ? with_why(document, *outcome, *why) : document).c_str());
  } else {
    const std::string text =
        common.quiet ? outcome->decision.reason + "\n" : look_text(*seen) + decide_text(*outcome, suggestion);
    std::fputs((why ? text + "\n" + why->text : text).c_str(), stdout);
  }
  std::fflush(stdout);
  if (auto shown = show(*seen, &*outcome, options.look, common, *setup); !shown)
    return report_error("decide", shown.error());
  return outcome->decision.chosen ? kDone : kNoGoal;
}

}  // namespace colift::tools
