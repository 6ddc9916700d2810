#include "tools/dds/serve/cmd_ros2.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "tools/cli/session.hpp"
#ifdef COLIFT_DDS
#include "control/session/scene_analysis.hpp"
#include "hal/dds/ros2_names.hpp"
#include "tools/cli/config_of.hpp"
#include "tools/cli/interrupt.hpp"
#include "tools/dds/decide_server.hpp"
#endif

namespace colift::tools {
#ifdef COLIFT_DDS
namespace {

hal::Result<ros2::DecideResult> decide(const ros2::DecideTask& task, const Setup& setup) {
  const control::Config& config = setup.config;
  control::SceneAnalysisInput input;
  input.frame = task.frame;
  const hal::SteadyClock clock;
  const auto analysis =
      control::analyse_scene(std::move(input), setup.method, config, setup.hand, clock, setup.hand_tables);
  if (!analysis) return tl::unexpected(analysis.error());
  control::PartnerInput partner;
  partner.position_W = task.partner_C;
  auto outcome = control::decide(*analysis, partner, config, clock);
  if (!outcome) return tl::unexpected(outcome.error());
  ros2::DecideResult result;
  result.outcome = std::move(*outcome);
  if (analysis->scene.target) result.cog_C = analysis->scene.target->cog;
  return result;
}

}  // namespace

int cmd_ros2(const CommonOptions& common, const Ros2ServeOptions& options) {
  const InterruptGuard signals;
  const auto setup = load_setup(config_of_decide(common, {}));
  if (!setup) return report_error("ros2", setup.error());
  hal::dds::DdsConfig dds;
  dds.node = "colift_decide";
  if (options.ros2.interface) dds.interface = *options.ros2.interface;
  const auto domain =
      options.ros2.domain ? hal::Result<int>(*options.ros2.domain) : hal::dds::domain_of_environment();
  if (!domain) return report_error("ros2", domain.error());
  dds.domain = *domain;
  const auto answer = [&](const ros2::DecideTask& task) -> hal::Result<ros2::DecideResult> {
    if (!task.share) return decide(task, *setup);
    DecideOptions asked;
    asked.share = fmt::format("{}", *task.share);
    const auto with_share = load_setup(config_of_decide(common, asked));
    if (!with_share) return tl::unexpected(with_share.error());
    return decide(task, *with_share);
  };
  auto server = ros2::DecideServer::open(dds, answer);
  if (!server) return report_error("ros2", server.error());
  if (!common.quiet)
    std::fprintf(stderr, "ROS 2: domain %d on interface %s; answers %s on %s\n", dds.domain,
                 dds.interface.c_str(), ros2::kDecideRequests, ros2::kDecideReplies);
  int answered = 0;
  while (!InterruptGuard::asked() && !(options.count && answered >= *options.count))
    answered += (*server)->serve(std::chrono::milliseconds(100));
  if (!common.quiet) std::fprintf(stderr, "ROS 2: %d answers\n", answered);
  return options.count && answered >= *options.count ? kDone : kInterrupted;
}
#else
int cmd_ros2(const CommonOptions&, const Ros2ServeOptions&) {
  return report_error("ros2", {hal::ErrorCode::BadInput, "ros2",
                               "this program was built without Cyclone DDS; install cyclonedds-dev and "
                               "cyclonedds-tools, then run tools/build"});
}
#endif

}  // namespace colift::tools
