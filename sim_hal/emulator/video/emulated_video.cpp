#include "sim_hal/emulator/video/emulated_video.hpp"

#include <fmt/format.h>
#include <linux/videodev2.h>
#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <thread>
#include <utility>

namespace colift::sim_hal {
namespace {

using namespace std::chrono_literals;
using Kind = VideoFault::Kind;

constexpr hal::Duration kTick = 1ms;  // between two looks of a call that waits
constexpr int kMostBehind = 3;        // images that a client who came late still gets
constexpr std::uint32_t kMostBuffers = 32;
constexpr std::size_t kPage = 4096;

template <class Structure>
Structure& as(void* argument) {
  return *static_cast<Structure*>(argument);
}

void copy_text(std::uint8_t* to, std::size_t room, const char* text) {
  std::strncpy(reinterpret_cast<char*>(to), text, room - 1);
}

}  // namespace

EmulatedVideo::EmulatedVideo(EmulatedVideoConfig config, std::unique_ptr<VideoSource> source,
                             const hal::Clock& clock, Sleep sleep)
    : config_(std::move(config)),
      source_(std::move(source)),
      clock_(clock),
      sleep_(sleep ? std::move(sleep) : [](hal::Duration d) { std::this_thread::sleep_for(d); }),
      began_(clock.now()),
      rate_hz_(config_.rate_hz) {}

int EmulatedVideo::broken(const char* rule, int error_number) {
  report_.broken_rules.emplace_back(rule);
  return -error_number;
}

std::size_t EmulatedVideo::stride() const {
  return 2 * static_cast<std::size_t>(source_->camera().width) + config_.padding;
}

const VideoFault* EmulatedVideo::now_active(Kind kind) const {
  const double t_s = hal::seconds(clock_.now() - began_);
  for (auto it = config_.faults.rbegin(); it != config_.faults.rend(); ++it)
    if (it->kind == kind && it->active(t_s)) return &*it;
  return nullptr;
}

bool EmulatedVideo::gone(int descriptor) {
  const bool plugged = !ended_ && now_active(Kind::Unplug) == nullptr;
  if (!plugged && plugged_) drop_buffers();
  plugged_ = plugged;
  // a device that came back is another one: descriptors of the old one stay dead
  if (!plugged) descriptor_ = -1;
  return descriptor != descriptor_;
}

void EmulatedVideo::drop_buffers() {
  for (Buffer& b : buffers_)
    if (b.mapped) orphans_.push_back(std::move(b));
  buffers_.clear();
  queued_.clear();
  filled_.clear();
  streams_ = false;
}

int EmulatedVideo::open(const std::string& path) {
  const std::lock_guard lock(mutex_);
  (void)gone(-1);
  if (!plugged_ || path != config_.path) return -ENOENT;
  if (descriptor_ >= 0) return broken("opened twice", EBUSY);
  ++report_.opened;
  ++report_.descriptors;
  format_set_ = false;
  return descriptor_ = ++last_descriptor_;
}

int EmulatedVideo::close(int descriptor) {
  const std::lock_guard lock(mutex_);
  if (descriptor < 3 || descriptor > last_descriptor_) return broken("closed what was not open", EBADF);
  --report_.descriptors;
  if (gone(descriptor)) return 0;
  drop_buffers();
  descriptor_ = -1;
  return 0;
}

int EmulatedVideo::control(int descriptor, unsigned long request, void* argument) {
  for (;;) {
    {
      const std::lock_guard lock(mutex_);
      if (ended_ || now_active(Kind::Hang) == nullptr) break;
    }
    sleep_(kTick);
  }
  const std::lock_guard lock(mutex_);
  if (gone(descriptor)) return -ENODEV;
  const int own = answer(request, argument);
  if (lie_)
    if (const auto other = lie_(request, argument)) return *other;
  return own;
}

int EmulatedVideo::answer(unsigned long request, void* argument) {
  const hal::CameraIntrinsics& k = source_->camera();
  const auto size = static_cast<std::uint32_t>(stride() * static_cast<std::size_t>(k.height));
  switch (request) {
    case VIDIOC_QUERYCAP: {
      auto& can = as<v4l2_capability>(argument);
      copy_text(can.driver, sizeof can.driver, "emulated");
      copy_text(can.card, sizeof can.card, "Emulated depth camera");
      can.device_caps = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
      can.capabilities = can.device_caps | V4L2_CAP_META_CAPTURE | V4L2_CAP_DEVICE_CAPS;
      return 0;
    }
    case VIDIOC_ENUM_FMT: {
      auto& format = as<v4l2_fmtdesc>(argument);
      if (format.type != V4L2_BUF_TYPE_VIDEO_CAPTURE || format.index > 1) return -EINVAL;
      format.pixelformat = format.index == 0 ? V4L2_PIX_FMT_YUYV : V4L2_PIX_FMT_Z16;
      return 0;
    }
    case VIDIOC_S_FMT: {
      if (!buffers_.empty()) return broken("another format while there are buffers", EBUSY);
      v4l2_pix_format& pix = as<v4l2_format>(argument).fmt.pix;
      pix.width = static_cast<std::uint32_t>(k.width);
      pix.height = static_cast<std::uint32_t>(k.height);
      pix.pixelformat = V4L2_PIX_FMT_Z16;
      pix.field = V4L2_FIELD_NONE;
      pix.bytesperline = static_cast<std::uint32_t>(stride());
      pix.sizeimage = size;
      format_set_ = true;
      return 0;
    }
    case VIDIOC_S_PARM: {
      v4l2_fract& per = as<v4l2_streamparm>(argument).parm.capture.timeperframe;
      if (per.numerator > 0 && per.denominator > 0)
        rate_hz_ = std::min(config_.rate_hz, static_cast<double>(per.denominator) / per.numerator);
      per = {1000, static_cast<std::uint32_t>(std::lround(1000.0 * rate_hz_))};
      return 0;
    }
    case VIDIOC_REQBUFS: {
      auto& wanted = as<v4l2_requestbuffers>(argument);
      if (wanted.memory != V4L2_MEMORY_MMAP) return -EINVAL;
      if (!format_set_) return broken("buffers before a format", EINVAL);
      drop_buffers();
      wanted.count = std::min(wanted.count, kMostBuffers);
      buffers_.resize(wanted.count);
      for (Buffer& b : buffers_) b.bytes.resize(size);
      return 0;
    }
    case VIDIOC_QUERYBUF:
    case VIDIOC_QBUF: {
      auto& b = as<v4l2_buffer>(argument);
      if (b.index >= buffers_.size()) return broken("a buffer that there is not", EINVAL);
      Buffer& ours = buffers_[b.index];
      b.length = static_cast<std::uint32_t>(ours.bytes.size());
      b.m.offset = static_cast<std::uint32_t>(b.index * kPage);
      if (request == VIDIOC_QUERYBUF) return 0;
      if (ours.state != State::Client) return broken("a buffer queued twice", EINVAL);
      ours.state = State::Queued;
      queued_.push_back(b.index);
      return 0;
    }
    case VIDIOC_DQBUF: {
      if (!streams_) return broken("dequeued while it does not stream", EINVAL);
      expose_what_is_due();
      if (filled_.empty() || buffers_[filled_.front()].ready_at > clock_.now()) return -EAGAIN;
      auto& b = as<v4l2_buffer>(argument);
      Buffer& ours = buffers_[filled_.front()];
      b.index = static_cast<std::uint32_t>(filled_.front());
      filled_.pop_front();
      ours.state = State::Client;
      b.bytesused = ours.used;
      b.flags = ours.flags;
      b.sequence = ours.sequence;
      const auto whole = std::chrono::floor<std::chrono::seconds>(ours.stamp);
      b.timestamp = {whole.count(),
                     std::chrono::duration_cast<std::chrono::microseconds>(ours.stamp - whole).count()};
      ++report_.handed_over;
      return 0;
    }
    case VIDIOC_STREAMON:
      if (queued_.size() < 2) return broken("streams with less than two buffers", EINVAL);
      streams_ = true;
      sequence_ = 0;
      next_ = clock_.now() + hal::duration_of(1.0 / rate_hz_);
      return 0;
    case VIDIOC_STREAMOFF:
      streams_ = false;
      for (Buffer& b : buffers_) b.state = State::Client;
      queued_.clear();
      filled_.clear();
      return 0;
    default:
      return -ENOTTY;
  }
}

int EmulatedVideo::map(int descriptor, std::size_t bytes, std::int64_t offset, const void*& to) {
  const std::lock_guard lock(mutex_);
  if (gone(descriptor)) return -ENODEV;
  const auto index = static_cast<std::size_t>(offset) / kPage;
  if (index >= buffers_.size() || bytes > buffers_[index].bytes.size())
    return broken("mapped what is no buffer", EINVAL);
  buffers_[index].mapped = true;
  ++report_.mapped;
  to = buffers_[index].bytes.data();
  return 0;
}

int EmulatedVideo::unmap(const void* at, std::size_t) {
  const std::lock_guard lock(mutex_);
  for (auto* all : {&buffers_, &orphans_})
    for (Buffer& b : *all)
      if (b.mapped && b.bytes.data() == at) {
        b.mapped = false;
        --report_.mapped;
        std::erase_if(orphans_, [](const Buffer& o) { return !o.mapped; });
        return 0;
      }
  return broken("unmapped what was not mapped", EINVAL);
}

int EmulatedVideo::wait(int descriptor, hal::Duration timeout) {
  std::optional<hal::Timestamp> end;
  for (;;) {
    hal::Duration left{0};
    {
      const std::lock_guard lock(mutex_);
      if (gone(descriptor)) return POLLERR | POLLHUP;
      if (!streams_) return POLLERR;
      expose_what_is_due();
      const hal::Timestamp now = clock_.now();
      if (!end) end = now + timeout;
      if (!filled_.empty() && buffers_[filled_.front()].ready_at <= now) return POLLIN;
      left = std::min(*end - now, kTick);
    }
    if (left <= 0ns) return 0;
    sleep_(left);
  }
}

void EmulatedVideo::expose_what_is_due() {
  const hal::Timestamp now = clock_.now();
  fresh_ = false;  // what is due in one call shows one moment: it costs one rendering
  double rate_hz = rate_hz_;
  if (const VideoFault* slow = now_active(Kind::Slow)) rate_hz = std::min(rate_hz, slow->value);
  const hal::Duration period = hal::duration_of(1.0 / rate_hz);
  if (now - next_ > kMostBehind * period) next_ = now;
  for (; next_ <= now; next_ += period)
    if (now_active(Kind::Silent) == nullptr) expose(next_);
  // a rendering that took longer than a period makes the device slower, and not its client busy for ever
  if (const hal::Timestamp after = clock_.now(); next_ <= after) next_ = after + kTick;
}

void EmulatedVideo::expose(hal::Timestamp at) {
  ++report_.exposed;
  ++sequence_;
  if (queued_.empty()) {
    ++report_.not_taken;
    return;
  }
  const std::size_t index = queued_.front();
  queued_.pop_front();
  fill(buffers_[index], at);
  filled_.push_back(index);
}

void EmulatedVideo::take_picture() {
  const auto& k = source_->camera();
  const auto width = static_cast<std::size_t>(k.width), height = static_cast<std::size_t>(k.height);
  const std::vector<float> depth_m = source_->look(sequence_);
  picture_.assign(stride() * height, 0xee);
  for (std::size_t v = 0; v < height; ++v)
    for (std::size_t u = 0; u < width; ++u) {
      const double units = std::round(depth_m[v * width + u] / config_.unit_m);
      const auto word = units > 0.0 && units < 65535.0 ? static_cast<unsigned>(units) : 0U;
      picture_[v * stride() + 2 * u] = static_cast<std::uint8_t>(word & 0xffU);
      picture_[v * stride() + 2 * u + 1] = static_cast<std::uint8_t>(word >> 8U);
    }
  fresh_ = true;
}

void EmulatedVideo::fill(Buffer& b, hal::Timestamp at) {
  if (!fresh_ && (picture_.empty() || now_active(Kind::Freeze) == nullptr)) take_picture();
  if (now_active(Kind::Blind) != nullptr)
    std::fill(b.bytes.begin(), b.bytes.end(), std::uint8_t{0});
  else
    std::copy(picture_.begin(), picture_.end(), b.bytes.begin());
  b.state = State::Filled;
  b.sequence = sequence_;
  b.used = static_cast<std::uint32_t>(b.bytes.size());
  b.flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  b.stamp = b.ready_at = at;
  if (const VideoFault* late = now_active(Kind::Late)) b.ready_at += hal::duration_of(1e-3 * late->value);
  if (const VideoFault* cut = now_active(Kind::Short))
    b.used = static_cast<std::uint32_t>(0.01 * cut->value * static_cast<double>(b.bytes.size()));
  if (now_active(Kind::Damaged) != nullptr) {
    b.flags |= V4L2_BUF_FLAG_ERROR;
    std::fill(b.bytes.begin() + static_cast<std::ptrdiff_t>(b.bytes.size() / 2), b.bytes.end(),
              std::uint8_t{0x11});
  }
  if (const VideoFault* jump = now_active(Kind::Jump))
    b.stamp += std::chrono::microseconds(std::llround(1e3 * jump->value));
  if (now_active(Kind::Restamp) != nullptr) {
    if (!same_stamp_) same_stamp_ = b.stamp;
    b.stamp = *same_stamp_;
  } else {
    same_stamp_.reset();
  }
  if (now_active(Kind::Foreign) != nullptr)
    b.flags &= ~static_cast<std::uint32_t>(V4L2_BUF_FLAG_TIMESTAMP_MASK);
}

void EmulatedVideo::inject(VideoFault fault) {
  const std::lock_guard lock(mutex_);
  fault.at_s += hal::seconds(clock_.now() - began_);
  config_.faults.push_back(std::move(fault));
}

void EmulatedVideo::lie(Lie lie) {
  const std::lock_guard lock(mutex_);
  lie_ = std::move(lie);
}

void EmulatedVideo::end() {
  const std::lock_guard lock(mutex_);
  ended_ = true;
  lie_ = {};
}

EmulatedVideoReport EmulatedVideo::report() const {
  const std::lock_guard lock(mutex_);
  return report_;
}

}  // namespace colift::sim_hal
