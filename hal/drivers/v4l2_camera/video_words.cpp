#include "hal/drivers/v4l2_camera/video_words.hpp"

#include <fmt/format.h>
#include <linux/videodev2.h>

#include <cerrno>
#include <cstring>

namespace colift::hal::v4l2 {
namespace {

constexpr auto kWhere = "v4l2.camera";
constexpr auto kList = "v4l2-ctl --list-devices shows which there are";

bool is_gone(int error_number) {
  return error_number == ENODEV || error_number == ENXIO || error_number == ENOENT ||
         error_number == ESHUTDOWN;
}

}  // namespace

const char* name_of(unsigned long request) {
  switch (request) {
    case VIDIOC_QUERYCAP:
      return "VIDIOC_QUERYCAP";
    case VIDIOC_ENUM_FMT:
      return "VIDIOC_ENUM_FMT";
    case VIDIOC_S_FMT:
      return "VIDIOC_S_FMT";
    case VIDIOC_S_PARM:
      return "VIDIOC_S_PARM";
    case VIDIOC_REQBUFS:
      return "VIDIOC_REQBUFS";
    case VIDIOC_QUERYBUF:
      return "VIDIOC_QUERYBUF";
    case VIDIOC_QBUF:
      return "VIDIOC_QBUF";
    case VIDIOC_DQBUF:
      return "VIDIOC_DQBUF";
    case VIDIOC_STREAMON:
      return "VIDIOC_STREAMON";
    case VIDIOC_STREAMOFF:
      return "VIDIOC_STREAMOFF";
    default:
      return "an ioctl";
  }
}

std::string text_of(std::uint32_t four_characters) {
  std::string text;
  for (unsigned i = 0; i < 4; ++i) {
    const auto c = static_cast<char>((four_characters >> (8 * i)) & 0x7fU);
    text.push_back(c >= 0x20 && c < 0x7f ? c : '?');
  }
  return text;
}

Error open_error(const std::string& path, int error_number) {
  if (is_gone(error_number) || error_number == ENOTDIR)
    return {ErrorCode::LinkLost, kWhere, fmt::format("there is no {}; {}", path, kList)};
  if (error_number == EACCES || error_number == EPERM)
    return {ErrorCode::DeviceFault, kWhere,
            fmt::format("no permission to open {}; add yourself to its group: sudo usermod -aG video $USER, "
                        "then log in again",
                        path)};
  if (error_number == EBUSY)
    return {ErrorCode::DeviceFault, kWhere,
            fmt::format("another program has {}; fuser -v {} shows which", path, path)};
  if (error_number == EISDIR || error_number == ELOOP || error_number == ENAMETOOLONG)
    return {ErrorCode::BadConfig, kWhere, fmt::format("{} is no device; {}", path, kList)};
  return {ErrorCode::DeviceFault, kWhere,
          fmt::format("{} cannot be opened: {}", path, std::strerror(error_number))};
}

Error call_error(const std::string& path, unsigned long request, int error_number) {
  if (is_gone(error_number))
    return {ErrorCode::LinkLost, kWhere,
            fmt::format("{} is gone: unplugged, or reset by the kernel (dmesg says which)", path)};
  if (error_number == EBUSY)
    return {ErrorCode::DeviceFault, kWhere,
            fmt::format("another program streams from {}; fuser -v {} shows which", path, path)};
  if (error_number == ENOTTY && request == VIDIOC_QUERYCAP)
    return {ErrorCode::BadConfig, kWhere, fmt::format("{} is no video device; {}", path, kList)};
  if (error_number == ENOSPC && request == VIDIOC_STREAMON)
    return {ErrorCode::DeviceFault, kWhere,
            fmt::format("the USB controller has no bandwidth left for {}; another port, or a lower rate_hz",
                        path)};
  if (error_number == ENOMEM)
    return {ErrorCode::DeviceFault, kWhere,
            fmt::format("the kernel has no memory for the buffers of {}; fewer buffers, or a smaller image",
                        path)};
  if (error_number == EIO || error_number == EPROTO || error_number == ETIMEDOUT || error_number == EPIPE)
    return {ErrorCode::DeviceFault, kWhere,
            fmt::format("{} does not answer {} ({}); unplug it, then another cable or port", path,
                        name_of(request), std::strerror(error_number))};
  return {ErrorCode::DeviceFault, kWhere,
          fmt::format("{} refuses {}: {}", path, name_of(request), std::strerror(error_number))};
}

}  // namespace colift::hal::v4l2
