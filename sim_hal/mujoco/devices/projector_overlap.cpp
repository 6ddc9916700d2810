#include "sim_hal/mujoco/devices/projector_overlap.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim_hal/mujoco/devices/sim_devices.hpp"
#include "sim_hal/synthetic/hash_random.hpp"

namespace colift::sim_hal {
namespace {

constexpr double kLost = 0.0357;    // 1 - (1 - 0.166)^(1/5)
constexpr int kBlot_px = 8;         // about a window of the Kinect's correlation
constexpr double kOfBlot = 0.9;     // of its pixels in a frame
constexpr float kShadow_m = 0.04F;  // behind what the projector meets first is its shadow
constexpr std::uint64_t kStream = 73;
constexpr int kCoarse = 4;  // the projector's view of the scene: every fourth pixel

hal::CameraIntrinsics coarse() {
  hal::CameraIntrinsics k;
  k.width /= kCoarse, k.height /= kCoarse;
  k.fx /= kCoarse, k.fy /= kCoarse, k.cx /= kCoarse, k.cy /= kCoarse;
  return k;
}

}  // namespace

ProjectorOverlap::ProjectorOverlap(const SimWorld& world, std::size_t number) : world_(world) {
  const Scenario& scenario = world.scenario();
  for (std::size_t n = 0; n <= scenario.more_cameras.size(); ++n) {
    const ScenarioCamera& camera = n == 0 ? scenario.camera : scenario.more_cameras[n - 1];
    const Pose X_WP = camera_pose(camera);
    if (n == number)
      X_WC_ = X_WP;
    else if (camera.noise != "none")
      others_.push_back({X_WP.inverse(), RayCaster(coarse(), X_WP), n});
  }
}

void ProjectorOverlap::apply(hal::DepthFrame& image, std::uint64_t frame) {
  const hal::CameraIntrinsics &k = image.intrinsics, p = coarse();
  for (Projector& other : others_) {
    const Rendering& met = other.caster.cast(world_.shapes());
    const Pose X_PC = other.X_PW * X_WC_;
    const auto illuminated = [&](int u, int v) {
      const float z = image.depth_m[static_cast<std::size_t>(v) * static_cast<std::size_t>(k.width) +
                                    static_cast<std::size_t>(u)];
      if (!(z > 0.0F)) return false;
      const Vec3 at = X_PC * Vec3(z * (u - k.cx) / k.fx, z * (v - k.cy) / k.fy, z);
      if (at.z() < 0.1) return false;
      const long pu = std::lround(p.fx * at.x() / at.z() + p.cx),
                 pv = std::lround(p.fy * at.y() / at.z() + p.cy);
      if (pu < 0 || pv < 0 || pu >= p.width || pv >= p.height) return false;
      const float first_m = met.depth_m[static_cast<std::size_t>(pv) * static_cast<std::size_t>(p.width) +
                                        static_cast<std::size_t>(pu)];
      return static_cast<float>(at.z()) < first_m + kShadow_m;
    };
    for (int v = 0; v < k.height; v += kBlot_px)
      for (int u = 0; u < k.width; u += kBlot_px) {
        const auto blot = static_cast<std::uint64_t>(v) * static_cast<std::uint64_t>(k.width) +
                          static_cast<std::uint64_t>(u);
        if (unit(hash(world_.seed() + other.number, kStream, blot)) >= kLost / kOfBlot) continue;
        const int middle_u = std::min(u + kBlot_px / 2, k.width - 1),
                  middle_v = std::min(v + kBlot_px / 2, k.height - 1);
        if (!illuminated(middle_u, middle_v)) continue;
        for (int y = v; y < std::min(v + kBlot_px, k.height); ++y)
          for (int x = u; x < std::min(u + kBlot_px, k.width); ++x) {
            const auto pixel =
                static_cast<std::size_t>(y) * static_cast<std::size_t>(k.width) + static_cast<std::size_t>(x);
            if (unit(hash(world_.seed() + frame, kStream + other.number, pixel)) < kOfBlot)
              image.depth_m[pixel] = std::numeric_limits<float>::quiet_NaN();
          }
      }
  }
}

}  // namespace colift::sim_hal
