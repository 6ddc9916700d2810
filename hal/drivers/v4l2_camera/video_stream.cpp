#include "hal/drivers/v4l2_camera/video_stream.hpp"

#include <fmt/format.h>
#include <linux/videodev2.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <utility>

#include "hal/drivers/v4l2_camera/video_words.hpp"

namespace colift::hal::v4l2 {
namespace {

constexpr auto kWhere = "v4l2.camera";
constexpr auto kCapture = V4L2_BUF_TYPE_VIDEO_CAPTURE;
constexpr std::uint32_t kMaxFormats = 64;       // that a device may list
constexpr std::size_t kMaxBytes = 64UL << 20U;  // of one picture
constexpr std::uint32_t kMinBuffers = 2, kMaxBuffers = 32;
constexpr int kMaxInterrupted = 100;  // signals during one call

tl::unexpected<Error> cannot(std::string what) {
  return failure(ErrorCode::BadConfig, kWhere, std::move(what));
}
tl::unexpected<Error> lies(std::string what) {
  return failure(ErrorCode::DeviceFault, kWhere, std::move(what));
}

/// A call that a signal may interrupt.
int undisturbed(VideoCalls& calls, int descriptor, unsigned long request, void* argument) {
  int done = -EINTR;
  for (int i = 0; done == -EINTR && i < kMaxInterrupted; ++i)
    done = calls.control(descriptor, request, argument);
  return done;
}

v4l2_buffer buffer_of(std::uint32_t index) {
  v4l2_buffer b{};
  b.type = kCapture;
  b.memory = V4L2_MEMORY_MMAP;
  b.index = index;
  return b;
}

}  // namespace

Result<std::unique_ptr<VideoStream>> VideoStream::open(VideoCalls& calls, const V4l2CameraConfig& config,
                                                       int width, int height) {
  std::unique_ptr<VideoStream> stream(new VideoStream(calls, config, width, height));
  stream->descriptor_ = calls.open(config.device);
  if (stream->descriptor_ < 0) return tl::unexpected(open_error(config.device, -stream->descriptor_));
  if (auto done = stream->negotiate(); !done) return tl::unexpected(done.error());
  return stream;
}

VideoStream::~VideoStream() {
  if (descriptor_ < 0) return;
  int type = kCapture;
  if (streams_) (void)calls_.control(descriptor_, VIDIOC_STREAMOFF, &type);
  for (const Buffer& b : buffers_) (void)calls_.unmap(b.at, b.bytes);
  (void)calls_.close(descriptor_);
}

Result<> VideoStream::ask(unsigned long request, void* argument) {
  const int done = undisturbed(calls_, descriptor_, request, argument);
  if (done < 0) return tl::unexpected(call_error(config_.device, request, -done));
  return {};
}

Result<> VideoStream::negotiate() {
  for (const auto step : {&VideoStream::check_capabilities, &VideoStream::find_z16, &VideoStream::set_format,
                          &VideoStream::set_rate, &VideoStream::map_buffers})
    if (auto done = (this->*step)(); !done) return done;
  int type = kCapture;
  if (auto done = ask(VIDIOC_STREAMON, &type); !done) return done;
  streams_ = true;
  return {};
}

Result<> VideoStream::check_capabilities() {
  v4l2_capability can{};
  if (auto done = ask(VIDIOC_QUERYCAP, &can); !done) return done;
  const std::uint32_t caps =
      (can.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? can.device_caps : can.capabilities;
  if ((caps & V4L2_CAP_META_CAPTURE) != 0)
    return cannot(fmt::format("{} carries a camera's metadata; its images are another device beside it",
                              config_.device));
  if ((caps & V4L2_CAP_VIDEO_CAPTURE) == 0)
    return cannot(
        fmt::format("{} captures no video; v4l2-ctl --list-devices shows which do", config_.device));
  if ((caps & V4L2_CAP_STREAMING) == 0)
    return cannot(fmt::format("{} cannot stream into mapped buffers", config_.device));
  return {};
}

Result<> VideoStream::find_z16() {
  std::string others;
  for (std::uint32_t i = 0; i < kMaxFormats; ++i) {
    v4l2_fmtdesc format{};
    format.index = i;
    format.type = kCapture;
    const int done = undisturbed(calls_, descriptor_, VIDIOC_ENUM_FMT, &format);
    if (done == -EINVAL) break;
    if (done < 0) return tl::unexpected(call_error(config_.device, VIDIOC_ENUM_FMT, -done));
    if (format.pixelformat == V4L2_PIX_FMT_Z16) return {};
    others += fmt::format("{}{}", others.empty() ? "" : ", ", text_of(format.pixelformat));
  }
  return cannot(
      fmt::format("{} has no format Z16, only {}; a depth camera's depth is one of several devices (v4l2-ctl "
                  "--list-devices), and an older kernel may not know its format",
                  config_.device, others.empty() ? "none" : others));
}

Result<> VideoStream::set_format() {
  v4l2_format format{};
  format.type = kCapture;
  format.fmt.pix.width = static_cast<std::uint32_t>(width_);
  format.fmt.pix.height = static_cast<std::uint32_t>(height_);
  format.fmt.pix.pixelformat = V4L2_PIX_FMT_Z16;
  format.fmt.pix.field = V4L2_FIELD_NONE;
  if (auto done = ask(VIDIOC_S_FMT, &format); !done) return done;
  const v4l2_pix_format& pix = format.fmt.pix;
  if (pix.pixelformat != V4L2_PIX_FMT_Z16)
    return lies(
        fmt::format("{} gives {} where it was asked for Z16", config_.device, text_of(pix.pixelformat)));
  if (pix.width != static_cast<std::uint32_t>(width_) || pix.height != static_cast<std::uint32_t>(height_))
    return cannot(
        fmt::format("{} gives {} x {} pixels, the intrinsics are for {} x {}; v4l2-ctl -d {} "
                    "--list-formats-ext shows its "
                    "sizes, each of which has intrinsics of its own",
                    config_.device, pix.width, pix.height, width_, height_, config_.device));
  if (pix.field != V4L2_FIELD_NONE && pix.field != V4L2_FIELD_ANY)
    return lies(fmt::format("{} gives interlaced images (field {})", config_.device, pix.field));
  const std::size_t row = 2 * static_cast<std::size_t>(width_);
  stride_ = pix.bytesperline;
  if (stride_ < row || stride_ > 4 * row)
    return lies(fmt::format("{} says rows of {} bytes; {} pixels of Z16 have {}", config_.device, stride_,
                            width_, row));
  bytes_ = stride_ * (static_cast<std::size_t>(height_) - 1) + row;
  if (pix.sizeimage < bytes_ || pix.sizeimage > kMaxBytes)
    return lies(fmt::format("{} says images of {} bytes; {} rows of {} have {}", config_.device,
                            pix.sizeimage, height_, stride_, bytes_));
  return {};
}

Result<> VideoStream::set_rate() {
  if (config_.rate_hz <= 0.0) return {};
  v4l2_streamparm parm{};
  parm.type = kCapture;
  parm.parm.capture.timeperframe = {1000, static_cast<std::uint32_t>(std::lround(1000.0 * config_.rate_hz))};
  const int done = undisturbed(calls_, descriptor_, VIDIOC_S_PARM, &parm);
  if (done == -ENOTTY) return {};  // it has one rate
  if (done < 0) return tl::unexpected(call_error(config_.device, VIDIOC_S_PARM, -done));
  const v4l2_fract& per = parm.parm.capture.timeperframe;
  if (per.numerator == 0 || per.denominator == 0) return {};  // it does not say
  const double rate_hz = static_cast<double>(per.denominator) / per.numerator;
  if (std::abs(rate_hz / config_.rate_hz - 1.0) > 0.02)
    return cannot(
        fmt::format("{} gives {:.4g} images a second, asked for {:.4g}; rate_hz: {:.4g}, or 0 for "
                    "the device's own",
                    config_.device, rate_hz, config_.rate_hz, rate_hz));
  return {};
}

Result<> VideoStream::map_buffers() {
  v4l2_requestbuffers request{};
  request.count = static_cast<std::uint32_t>(config_.buffers);
  request.type = kCapture;
  request.memory = V4L2_MEMORY_MMAP;
  if (auto done = ask(VIDIOC_REQBUFS, &request); !done) return done;
  if (request.count < kMinBuffers || request.count > kMaxBuffers)
    return lies(
        fmt::format("{} has {} buffers, asked for {}", config_.device, request.count, config_.buffers));
  for (std::uint32_t i = 0; i < request.count; ++i) {
    v4l2_buffer b = buffer_of(i);
    if (auto done = ask(VIDIOC_QUERYBUF, &b); !done) return done;
    if (b.index != i || b.length < bytes_ || b.length > kMaxBytes)
      return lies(
          fmt::format("buffer {} of {} has {} bytes; an image has {}", i, config_.device, b.length, bytes_));
    Buffer mapped{nullptr, b.length};
    const int done = calls_.map(descriptor_, mapped.bytes, b.m.offset, mapped.at);
    if (done < 0) return tl::unexpected(call_error(config_.device, VIDIOC_QUERYBUF, -done));
    buffers_.push_back(mapped);
    if (auto given = give_back(i); !given) return given;
  }
  return {};
}

Result<> VideoStream::give_back(std::uint32_t index) {
  v4l2_buffer b = buffer_of(index);
  return ask(VIDIOC_QBUF, &b);
}

Result<VideoPicture> VideoStream::next(Duration timeout) {
  const int events = calls_.wait(descriptor_, timeout);
  const auto none = [] { return failure(ErrorCode::Timeout, kWhere, "no image"); };
  if (events == 0 || events == -EINTR) return none();
  if (events < 0) return lies(fmt::format("{} cannot be waited for: error {}", config_.device, -events));
  v4l2_buffer b = buffer_of(0);
  const int done = undisturbed(calls_, descriptor_, VIDIOC_DQBUF, &b);
  const bool over = (events & (POLLERR | POLLHUP | POLLNVAL)) != 0;
  if (done == -EAGAIN && !over) return none();
  if (done == -EAGAIN || done == -EINVAL || (done == -EIO && over))
    return lies(fmt::format("{} streams no more", config_.device));
  if (done == -EIO)
    return failure(ErrorCode::BadReply, kWhere,
                   fmt::format("{} lost an image on its way (EIO)", config_.device));
  if (done < 0) return tl::unexpected(call_error(config_.device, VIDIOC_DQBUF, -done));
  if (b.index >= buffers_.size())
    return lies(fmt::format("{} filled buffer {} of {}", config_.device, b.index, buffers_.size()));
  const Buffer& from = buffers_[b.index];
  const bool broken = (b.flags & V4L2_BUF_FLAG_ERROR) != 0;
  const bool whole = b.bytesused >= bytes_ && b.bytesused <= from.bytes;
  VideoPicture picture;
  if (!broken && whole) {
    // the device may write while it is read: what is checked is the copy
    const auto* const first = static_cast<const std::uint8_t*>(from.at);
    picture.bytes.assign(first, first + bytes_);
  }
  if ((b.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC &&
      b.timestamp.tv_sec >= 0 && b.timestamp.tv_sec < (1LL << 32) && b.timestamp.tv_usec >= 0 &&
      b.timestamp.tv_usec < 1'000'000)
    picture.stamp = std::chrono::seconds(b.timestamp.tv_sec) + std::chrono::microseconds(b.timestamp.tv_usec);
  if (auto given = give_back(b.index); !given) return tl::unexpected(given.error());
  if (broken)
    return failure(ErrorCode::BadReply, kWhere,
                   fmt::format("the kernel marked an image of {} as damaged", config_.device));
  if (!whole)
    return failure(
        ErrorCode::BadReply, kWhere,
        fmt::format("an image of {} bytes; {} rows of {} have {}", b.bytesused, height_, stride_, bytes_));
  return picture;
}

Result<VideoPicture> VideoStream::newest(Duration timeout, std::vector<std::string>& dropped) {
  auto best = next(timeout);
  for (std::size_t i = 0; best && i < buffers_.size(); ++i) {
    auto later = next(Duration{0});
    if (later)
      best = std::move(later);
    else if (later.error().code == ErrorCode::BadReply)
      dropped.push_back(later.error().detail);
    else if (later.error().code == ErrorCode::Timeout)
      break;
    else
      return later;
  }
  if (!best && best.error().code == ErrorCode::BadReply) dropped.push_back(best.error().detail);
  return best;
}

}  // namespace colift::hal::v4l2
