#include "sim_hal/emulator/video/video_source.hpp"

#include <utility>

#include "sim_hal/synthetic/hash_random.hpp"

namespace colift::sim_hal {
namespace {

constexpr std::uint64_t kStream = 97;

}  // namespace

ScriptedVideoSource::ScriptedVideoSource(std::function<World(double t_s)> world,
                                         const hal::CameraIntrinsics& camera, const Pose& X_WC,
                                         std::optional<KinectNoise> noise, std::uint64_t seed,
                                         const hal::Clock& clock)
    : world_(std::move(world)),
      camera_(camera),
      noise_(noise),
      seed_(seed),
      clock_(clock),
      caster_(camera, X_WC) {}

std::vector<float> ScriptedVideoSource::look(std::uint64_t frame) {
  const hal::Timestamp now = clock_.now();
  if (!began_) began_ = now;
  const Rendering& truth = caster_.cast(world_(hal::seconds(now - *began_)));
  return (noise_ ? measure(truth, *noise_, hash(seed_, kStream, frame)) : measure_ideal(truth)).depth_m;
}

}  // namespace colift::sim_hal
