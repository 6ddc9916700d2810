#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "hal/types/result.hpp"
#include "tools/cli/options.hpp"
#include "tools/live/live_server.hpp"
#include "tools/run/run_parts.hpp"

namespace colift::tools {

/// The live view of one run, or of a recording that is played: the server, and who may do what there.
class RunLive final : public LiveView {
 public:
  /// Null where no view was asked for. Errors: BadInput for a wrong port or address; NotReady where the port
  /// is taken.
  /// `urdf` is the robot's description for the page, `documents` are further ones by path.
  [[nodiscard]] static hal::Result<std::unique_ptr<RunLive>> open(
      const ViewOptions& options, const std::string& title, std::string urdf,
      std::map<std::string, live::Document> documents = {});

  [[nodiscard]] telemetry::TelemetrySink& sink() override { return *server_; }
  [[nodiscard]] std::string url() const override { return server_->url(); }
  [[nodiscard]] bool stopped() const override { return stopped_; }
  [[nodiscard]] bool take_lower_confirmed() override { return lower_confirmed_.exchange(false); }
  [[nodiscard]] bool take_continue_confirmed() override { return continue_confirmed_.exchange(false); }
  void stay(const std::function<bool()>& enough) const override;

 private:
  RunLive() = default;
  std::atomic<bool> stopped_{false}, lower_confirmed_{false}, continue_confirmed_{false};
  std::unique_ptr<live::LiveServer> server_;
};

}  // namespace colift::tools
