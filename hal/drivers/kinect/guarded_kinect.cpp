#include "hal/drivers/kinect/guarded_kinect.hpp"

#include "hal/drivers/kinect/kinect_camera.hpp"

namespace colift::hal {

GuardedKinect make_guarded_kinect(const KinectConfig& kinect, const CameraGuardConfig& guard,
                                  const Clock& clock, std::optional<Vec3> up_C) {
  auto driver = std::make_unique<KinectCamera>(kinect, clock);
  GuardedKinect made;
  made.infrared = std::shared_ptr<InfraredCamera>(std::shared_ptr<void>(), driver.get());  // owns nothing
  made.camera = std::make_unique<GuardedCamera>(std::move(driver), guard, clock, up_C);
  return made;
}

}  // namespace colift::hal
