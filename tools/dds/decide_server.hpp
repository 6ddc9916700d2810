#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>

#include "control/session/decide.hpp"
#include "hal/dds/participant.hpp"
#include "hal/depth_camera.hpp"

namespace colift::ros2 {

/// One request, checked. All in the camera's optical frame C.
struct DecideTask {
  hal::DepthFrame frame;
  hal::Vec3 partner_C = hal::Vec3::Zero();
  std::optional<double> share;  ///< Of the load for the robot, between 0 and 1; unset: as configured.
};
struct DecideResult {
  control::Outcome outcome;
  std::optional<hal::Vec3> cog_C;
};
using Decide = std::function<hal::Result<DecideResult>(const DecideTask&)>;

inline constexpr const char* kDecideRequests = "/colift/decide/request";
inline constexpr const char* kDecideReplies = "/colift/decide/reply";

/// Answers requests for decisions, one at a time: colift_msgs/DecideRequest to colift_msgs/DecideReply, on
/// two topics and not as a service, because services of different middlewares misread each other. A reply has
/// client and sequence number of its request. Of requests that come faster than they are answered the newest
/// ten are kept; a client that hears nothing asks again. A request that cannot be used is answered with the
/// reason; one without a client (1 to 64 characters) is dropped.
class DecideServer {
 public:
  /// Errors: BadConfig (domain, interface), DeviceFault (what Cyclone DDS reports).
  [[nodiscard]] static hal::Result<std::unique_ptr<DecideServer>> open(const hal::dds::DdsConfig& config,
                                                                       Decide decide);
  ~DecideServer();

  /// Waits for requests and answers what is there. How many were answered.
  int serve(std::chrono::milliseconds timeout);

 private:
  struct Impl;
  explicit DecideServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::ros2
