#include "tools/cli/config_of.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "tools/cli/numbers.hpp"
#include "tools/rig/back_ends.hpp"

namespace colift::tools {
namespace {

using control::ConfigRequest;

ConfigRequest request_of(const CommonOptions& common, control::Command command) {
  ConfigRequest request;
  request.command = command;
  request.files = common.config_files;
  request.settings = common.settings;
  return request;
}

hal::Result<> add_method(ConfigRequest& request, const std::string& method) {
  if (method.empty()) return {};
  if (!control::method_named(method))
    return hal::failure(hal::ErrorCode::BadInput, "--method",
                        fmt::format("\"{}\" is not known, expected fast or thesis", method));
  request.options.push_back({"method", method, "--method"});
  return {};
}

hal::Result<> add_support(ConfigRequest& request, const LookOptions& options) {
  if (options.support.empty()) return {};
  if (options.support != "auto" && options.support != "floor" && options.support != "table")
    return hal::failure(hal::ErrorCode::BadInput, "--support",
                        fmt::format("\"{}\" is not known, expected auto, floor or table", options.support));
  request.options.push_back({"support", options.support, "--support"});
  return {};
}

hal::Result<> add_sharing(ConfigRequest& request, const std::string& share, const std::string& epsilon) {
  if (!share.empty() && !epsilon.empty())
    return hal::failure(hal::ErrorCode::BadInput, "--share",
                        "goes without --epsilon: either one says how the load is shared");
  if (!epsilon.empty()) {
    const auto n = parse_numbers(epsilon, 1, "--epsilon");
    if (!n) return tl::unexpected(n.error());
    if (n->front() <= 0.0)
      return hal::failure(hal::ErrorCode::BadInput, "--epsilon",
                          fmt::format("{} has to be greater than 0", n->front()));
    request.options.push_back({"decision.weights.epsilon", epsilon, "--epsilon"});
  }
  if (!share.empty()) {
    const auto n = parse_numbers(share, 1, "--share");
    if (!n) return tl::unexpected(n.error());
    if (const auto possible = planner::epsilon_for_share(n->front()); !possible)
      return hal::failure(hal::ErrorCode::BadInput, "--share", possible.error().detail);
    request.options.push_back({"decision.share", share, "--share"});
  }
  return {};
}

hal::Result<> add_strict(ConfigRequest& request, const std::string& strict) {
  if (strict.empty()) return {};
  const auto n = parse_numbers(strict, 1, "--share-strict");
  if (!n) return tl::unexpected(n.error());
  request.options.push_back({"decision.share_strict", strict, "--share-strict"});
  return {};
}

// a deviation from nothing cannot be judged, and must not look as if it were
hal::Result<control::ResolvedConfig> resolve_share(const ConfigRequest& request) {
  auto resolved = control::resolve_config(request);
  if (resolved && resolved->config.decision.share_strict && !resolved->config.decision.share)
    return hal::failure(hal::ErrorCode::BadInput, "--share-strict",
                        "needs a wanted share: --share S, or decision.share");
  return resolved;
}

}  // namespace

hal::Result<control::ResolvedConfig> config_of_run(const CommonOptions& common, const RunOptions& options) {
  ConfigRequest request = request_of(common, control::Command::Run);
  const auto task = read_task(options.scenario);
  if (!task) return tl::unexpected(task.error());
  request.task = {fmt::format("scenario {}", task->scenario), task->lift_height_m, task->hold_s};
  if (auto added = add_method(request, options.method); !added) return tl::unexpected(added.error());
  if (auto added = add_sharing(request, options.share, ""); !added) return tl::unexpected(added.error());
  if (auto added = add_strict(request, options.share_strict); !added) return tl::unexpected(added.error());
  return resolve_share(request);
}

hal::Result<control::ResolvedConfig> config_of_look(const CommonOptions& common, const LookOptions& options) {
  ConfigRequest request = request_of(common, control::Command::SceneAnalysis);
  if (auto added = add_method(request, options.method); !added) return tl::unexpected(added.error());
  if (auto added = add_support(request, options); !added) return tl::unexpected(added.error());
  return control::resolve_config(request);
}

hal::Result<control::ResolvedConfig> config_of_decide(const CommonOptions& common,
                                                      const DecideOptions& options) {
  ConfigRequest request = request_of(common, control::Command::Decide);
  if (auto added = add_method(request, options.look.method); !added) return tl::unexpected(added.error());
  if (auto added = add_support(request, options.look); !added) return tl::unexpected(added.error());
  if (auto added = add_sharing(request, options.share, options.epsilon); !added)
    return tl::unexpected(added.error());
  if (auto added = add_strict(request, options.share_strict); !added) return tl::unexpected(added.error());
  return resolve_share(request);
}

hal::Result<control::ResolvedConfig> config_of(const CommonOptions& common, control::Command command) {
  return control::resolve_config(request_of(common, command));
}

void show_warnings(const char* command, const CommonOptions& common,
                   const control::ResolvedConfig& resolved) {
  if (common.quiet) return;
  for (const std::string& warning : resolved.warnings)
    std::fputs(fmt::format("colift {}: {}\n", command, warning).c_str(), stderr);
}

}  // namespace colift::tools
