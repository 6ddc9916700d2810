#include <fmt/format.h>

#include <cstdio>
#include <limits>

#include "tools/colift/commands.hpp"
#include "tools/colift/look_json.hpp"
#include "tools/colift/numbers.hpp"
#include "tools/colift/show.hpp"
#include "tools/colift/words.hpp"

namespace colift::tools {
namespace {

hal::Result<> set_weights(const DecideOptions& options, const control::Look& look, control::Config& config) {
  // the thesis sets all weights to one (sections 4.3 and 5.3.4)
  if (look.method == control::Method::Thesis) {
    config.decision.weights = planner::SharingWeights::thesis();
    config.decision.max_sideways = std::numeric_limits<double>::infinity();
  }
  if (!options.share.empty() && !options.epsilon.empty())
    return hal::failure(hal::ErrorCode::BadInput, "--share",
                        "goes without --epsilon: either one says how the load is shared");
  if (!options.epsilon.empty()) {
    const auto n = parse_numbers(options.epsilon, 1, "--epsilon");
    if (!n) return tl::unexpected(n.error());
    if (n->front() <= 0.0)
      return hal::failure(hal::ErrorCode::BadInput, "--epsilon",
                          fmt::format("{} has to be greater than 0", n->front()));
    config.decision.weights.epsilon = n->front();
  }
  if (!options.share.empty()) {
    const auto n = parse_numbers(options.share, 1, "--share");
    if (!n) return tl::unexpected(n.error());
    const auto epsilon = planner::epsilon_for_share(n->front());
    if (!epsilon) return hal::failure(hal::ErrorCode::BadInput, "--share", epsilon.error().detail);
    config.decision.weights.epsilon = *epsilon;
  }
  return {};
}

hal::Result<control::PartnerInput> read_partner(const DecideOptions& options) {
  control::PartnerInput input;
  if (options.partner.empty() == !options.partner_cloud)
    return hal::failure(
        hal::ErrorCode::BadInput, "--partner",
        "say where the partner holds the object: either --partner X,Y,Z or --partner-cloud CLOUD2");
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
  auto setup = load_setup(common);
  if (!setup) return report_error("decide", setup.error());
  const auto partner = read_partner(options);
  if (!partner) return report_error("decide", partner.error());
  const auto seen = look_at_file(options.look, *setup);
  if (!seen) return report_error("decide", seen.error());
  if (auto set = set_weights(options, seen->look, setup->config); !set)
    return report_error("decide", set.error());
  const auto outcome = control::decide(seen->look, *partner, setup->config, hal::SteadyClock());
  if (!outcome) return report_error("decide", outcome.error());

  if (common.json)
    std::puts(decide_document(*seen, *outcome).c_str());
  else
    std::fputs(
        (common.quiet ? outcome->decision.because + "\n" : look_text(*seen) + decide_text(*outcome)).c_str(),
        stdout);
  std::fflush(stdout);
  if (auto shown = show(*seen, &*outcome, options.look, common, setup->hand); !shown)
    return report_error("decide", shown.error());
  return outcome->decision.chosen ? kDone : kNoGoal;
}

}  // namespace colift::tools
