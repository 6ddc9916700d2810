#include <fmt/format.h>

#include "tools/run/run_recording.hpp"
#ifdef COLIFT_DDS
#include "hal/dds/ros2_names.hpp"
#include "tools/dds/ros2_publisher.hpp"
#endif

namespace colift::tools {
namespace {

hal::Result<> check_belongs(const Ros2Options& options) {
  if (!options.on && (options.domain || options.interface))
    return hal::failure(hal::ErrorCode::BadInput, options.domain ? "--ros2-domain" : "--ros2-interface",
                        "belongs to --ros2");
  return {};
}

#ifdef COLIFT_DDS
class Published final : public Ros2View {
 public:
  Published(std::unique_ptr<ros2::Ros2Publisher> publisher, hal::dds::DdsConfig dds)
      : publisher_(std::move(publisher)), dds_(std::move(dds)) {}
  telemetry::TelemetrySink& sink() override { return *publisher_; }
  [[nodiscard]] std::string place() const override {
    return fmt::format("domain {} on interface {}", dds_.domain, dds_.interface);
  }
  std::string finish() override {
    const bool all = publisher_->flush(std::chrono::seconds(1));
    const auto counts = publisher_->counts();
    std::string text = fmt::format("ROS 2: {} messages", counts.written);
    if (counts.dropped > 0) text += fmt::format(", {} dropped before they were sent", counts.dropped);
    if (counts.failed > 0) text += fmt::format(", {} not sent", counts.failed);
    if (!all) text += "; a subscriber did not acknowledge the last ones within 1 s";
    return text;
  }

 private:
  std::unique_ptr<ros2::Ros2Publisher> publisher_;
  hal::dds::DdsConfig dds_;
};
#endif

}  // namespace

hal::Result<std::unique_ptr<Ros2View>> open_ros2(const RunOptions& options) {
  if (auto ok = check_belongs(options.ros2); !ok) return tl::unexpected(ok.error());
  if (!options.ros2.on) return std::unique_ptr<Ros2View>();
#ifdef COLIFT_DDS
  ros2::PublisherConfig config;
  if (options.ros2.domain) {
    config.dds.domain = *options.ros2.domain;
  } else {
    const auto domain = hal::dds::domain_of_environment();
    if (!domain) return tl::unexpected(domain.error());
    config.dds.domain = *domain;
  }
  if (options.ros2.interface) config.dds.interface = *options.ros2.interface;
  auto publisher = ros2::Ros2Publisher::open(config);
  if (!publisher) return tl::unexpected(publisher.error());
  return std::make_unique<Published>(std::move(*publisher), config.dds);
#else
  return hal::failure(
      hal::ErrorCode::BadInput, "--ros2",
      "this program was built without Cyclone DDS; install cyclonedds-dev and cyclonedds-tools, "
      "then run tools/build");
#endif
}

}  // namespace colift::tools
