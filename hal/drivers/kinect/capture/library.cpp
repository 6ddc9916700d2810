#include "hal/drivers/kinect/capture/library.hpp"

#include <dlfcn.h>

namespace colift::capture {
namespace {

template <class Function>
Function* find(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_DEFAULT, name));
}

}  // namespace

std::string first_serial(freenect_context* context) {
  const auto list = find<decltype(freenect_list_device_attributes)>("freenect_list_device_attributes");
  const auto give_back = find<decltype(freenect_free_device_attributes)>("freenect_free_device_attributes");
  if (list == nullptr || give_back == nullptr) return {};
  freenect_device_attributes* all = nullptr;
  if (list(context, &all) <= 0 || all == nullptr) return {};
  std::string serial = all->camera_serial != nullptr ? all->camera_serial : "";
  give_back(all);
  return serial;
}

std::optional<hal::kinect::DepthConstants> constants_of(freenect_device* device) {
  const auto copy = find<decltype(freenect_copy_registration)>("freenect_copy_registration");
  const auto destroy = find<decltype(freenect_destroy_registration)>("freenect_destroy_registration");
  if (copy == nullptr || destroy == nullptr) return std::nullopt;
  freenect_registration r = copy(device);
  hal::kinect::DepthConstants c;
  c.emitter_cm = static_cast<double>(r.zero_plane_info.dcmos_emitter_dist);
  c.reference_cm = static_cast<double>(r.zero_plane_info.reference_distance);
  c.pixel_cm = static_cast<double>(r.zero_plane_info.reference_pixel_size);
  c.shift = r.const_shift;
  (void)destroy(&r);
  return c;
}

bool set_ir_brightness(freenect_device* device, int brightness) {
  const auto set = find<decltype(freenect_set_ir_brightness)>("freenect_set_ir_brightness");
  return set != nullptr && set(device, static_cast<std::uint16_t>(brightness)) >= 0;
}

std::optional<freenect_frame_mode> depth_mode() {
  for (int i = 0; i < freenect_get_depth_mode_count(); ++i) {
    const freenect_frame_mode m = freenect_get_depth_mode(i);
    if (m.is_valid != 0 && m.resolution == FREENECT_RESOLUTION_MEDIUM &&
        m.depth_format == FREENECT_DEPTH_11BIT)
      return m;
  }
  return std::nullopt;
}

std::optional<freenect_frame_mode> infrared_mode() {
  for (int i = 0; i < freenect_get_video_mode_count(); ++i) {
    const freenect_frame_mode m = freenect_get_video_mode(i);
    if (m.is_valid != 0 && m.resolution == FREENECT_RESOLUTION_MEDIUM &&
        m.video_format == FREENECT_VIDEO_IR_10BIT)
      return m;
  }
  return std::nullopt;
}

}  // namespace colift::capture
