#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hal/datagram_link.hpp"
#include "hal/types/result.hpp"
#include "sim_hal/emulator/camera/camera_server.hpp"
#include "sim_hal/emulator/hand/hand_server.hpp"
#include "sim_hal/emulator/krc/krc_server.hpp"
#include "sim_hal/emulator/served_camera.hpp"
#include "sim_hal/emulator/video/emulated_video.hpp"
#include "sim_hal/mujoco/sim_world.hpp"
#include "sim_hal/scenario/scenario.hpp"
#include "tools/rig/robot_file.hpp"

namespace colift::tools {

/// Where the far ends of a robot's wires are served. The arm's controller is always there: it moves the
/// world.
struct EmulatedRigConfig {
  hal::Endpoint arm_client{0x7f000001, 49938};  ///< Whom the controller sends its measurements to.
  std::string script = "colift";                ///< Of the controller.
  int cpu = -1;                                 ///< On which its client answers; -1: any.
  std::optional<std::string> can;               ///< As `barrett.can` names the bus; unset: no hand there.
  std::optional<std::string> camera;  ///< "@NAME", or empty for a name of its own; unset: no camera there.
  std::vector<std::string>
      more_cameras;  ///< The same of the scenario's others, where it has more than these.
  /// A video device that the kernel would serve, and its camera; unset: none there.
  std::optional<std::pair<sim_hal::EmulatedVideoConfig, hal::CameraIntrinsics>> video;
  /// Serves a camera of another kind in this world; unset: none there.
  std::function<hal::Result<std::unique_ptr<sim_hal::ServedCamera>>(const sim_hal::SimWorld&)> serve_camera;
  std::uint64_t seed = 1;
};

/// What the far ends of this robot's wires are.
[[nodiscard]] EmulatedRigConfig emulated_rig_of(const RobotFile& file, std::uint64_t seed);

/// KRC, four pucks and a camera on one simulated world, in real time, each in a thread of its own. The pucks
/// are asleep as after power-on.
class EmulatedRig {
 public:
  /// Errors: BadConfig (a fault of the scenario that is none, an address that is taken), what the servers
  /// say.
  [[nodiscard]] static hal::Result<std::shared_ptr<EmulatedRig>> start(
      const EmulatedRigConfig& config, const sim_hal::Scenario& scenario, const hal::RobotModel& model,
      std::shared_ptr<sim_hal::SimWorld> world);
  ~EmulatedRig();
  EmulatedRig(const EmulatedRig&) = delete;
  EmulatedRig& operator=(const EmulatedRig&) = delete;

  /// The partner sets out, and the faults of the scenario count from now on. Devices take seconds to start,
  /// so this is when they have.
  void begin();
  void stop();

  [[nodiscard]] sim_hal::KrcServer& krc() { return *krc_; }
  [[nodiscard]] sim_hal::HandServer* pucks() { return pucks_.get(); }      ///< nullptr: not served.
  [[nodiscard]] sim_hal::CameraServer* camera() { return camera_.get(); }  ///< nullptr: not served.
  /// The scenario's others, where the first one is served.
  [[nodiscard]] const std::vector<std::unique_ptr<sim_hal::CameraServer>>& more_cameras() const {
    return more_cameras_;
  }
  /// nullptr: not served. Lives no longer than the rig: its pictures are of the rig's world.
  [[nodiscard]] const std::shared_ptr<sim_hal::EmulatedVideo>& video() { return video_; }
  /// nullptr: not served.
  [[nodiscard]] sim_hal::ServedCamera* served_camera() { return served_camera_.get(); }

 private:
  struct Faults {
    std::vector<sim_hal::KrcFault> arm;
    std::vector<sim_hal::HandFault> hand;
    std::vector<std::vector<sim_hal::CameraFault>> cameras;  ///< The first one's, then of each other.
    std::vector<sim_hal::VideoFault> video;
  };

  EmulatedRig(std::shared_ptr<sim_hal::SimWorld> world, Faults faults);
  static hal::Result<Faults> faults_of(const sim_hal::Scenario& scenario, const EmulatedRigConfig& config);

  std::shared_ptr<sim_hal::SimWorld> world_;
  Faults faults_;
  std::unique_ptr<sim_hal::KrcServer> krc_;
  std::unique_ptr<sim_hal::HandServer> pucks_;
  std::unique_ptr<sim_hal::CameraServer> camera_;
  std::vector<std::unique_ptr<sim_hal::CameraServer>> more_cameras_;
  hal::SteadyClock clock_;
  std::shared_ptr<sim_hal::EmulatedVideo> video_;
  std::unique_ptr<sim_hal::ServedCamera> served_camera_;
};

/// Says to other programs on this machine that a rig is served for the arm's client on `port`; gone with the
/// program, however it ends.
class ServedRigSign {
 public:
  /// Errors: DeviceFault when somebody else serves one.
  [[nodiscard]] static hal::Result<ServedRigSign> put_up(std::uint16_t port);
  [[nodiscard]] static bool is_up(std::uint16_t port) { return !put_up(port); }

  ~ServedRigSign();
  ServedRigSign(ServedRigSign&& other) noexcept : socket_(std::exchange(other.socket_, -1)) {}
  ServedRigSign& operator=(ServedRigSign&&) = delete;

 private:
  explicit ServedRigSign(int socket) : socket_(socket) {}
  int socket_ = -1;
};

}  // namespace colift::tools
