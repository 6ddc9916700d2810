// A library with libfreenect's own functions (0.5), whose Kinect is a CameraServer. The capture process, or
// any other program for libfreenect, runs on it unchanged: LD_PRELOAD=libcolift-freenect.so. Depth of 11
// bits, infrared of ten, motor and accelerometer; lost packets, unplugging, hanging and crashing on request.
// Errors and their order are those of the real library: a device that is gone answers -1 for ever.

#include <libfreenect.h>
#include <libfreenect_registration.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <thread>

#include "sim_hal/emulator/camera/client/camera_socket.hpp"

using colift::sim_hal::CameraHead;
using colift::sim_hal::CameraMessage;
using colift::sim_hal::CameraSocket;
using colift::sim_hal::CameraTilt;

struct _freenect_device {
  freenect_context* context = nullptr;
  void* user = nullptr;
  freenect_depth_cb on_depth = nullptr;
  freenect_video_cb on_video = nullptr;
  void* depth_buffer = nullptr;
  void* video_buffer = nullptr;
  bool depth_runs = false, video_runs = false;
  freenect_frame_mode depth_mode{}, video_mode{};
  freenect_raw_tilt_state tilt{};
  int brightness = 10;
};

struct _freenect_context {
  CameraSocket socket;
  freenect_log_cb on_log = nullptr;
  freenect_loglevel level = FREENECT_LOG_NOTICE;
  freenect_device_flags subdevices =
      static_cast<freenect_device_flags>(FREENECT_DEVICE_CAMERA | FREENECT_DEVICE_MOTOR);
  freenect_device* device = nullptr;
  bool dead = false;
  std::vector<std::uint8_t> bytes;
};

namespace {

constexpr int kDepthBytes = 640 * 480 * 2, kInfraredBytes = 640 * 488 * 2;

freenect_frame_mode depth_mode() {
  freenect_frame_mode m{};
  m.reserved = 1;
  m.resolution = FREENECT_RESOLUTION_MEDIUM;
  m.depth_format = FREENECT_DEPTH_11BIT;
  m.bytes = kDepthBytes;
  m.width = 640;
  m.height = 480;
  m.data_bits_per_pixel = 11;
  m.padding_bits_per_pixel = 5;
  m.framerate = 30;
  m.is_valid = 1;
  return m;
}

freenect_frame_mode infrared_mode() {
  freenect_frame_mode m{};
  m.reserved = 2;
  m.resolution = FREENECT_RESOLUTION_MEDIUM;
  m.video_format = FREENECT_VIDEO_IR_10BIT;
  m.bytes = kInfraredBytes;
  m.width = 640;
  m.height = 488;
  m.data_bits_per_pixel = 10;
  m.padding_bits_per_pixel = 6;
  m.framerate = 30;
  m.is_valid = 1;
  return m;
}

void log(freenect_context* c, int level, const char* text) {
  if (level > c->level) return;
  if (c->on_log != nullptr)
    c->on_log(c, static_cast<freenect_loglevel>(level), text);
  else
    std::fputs(text, stderr);
}

void tell_requests(freenect_device* d) {
  d->context->socket.send(CameraMessage::Want, (d->depth_runs ? 1U : 0U) | (d->video_runs ? 2U : 0U));
}

void set_tilt(freenect_device* d, const CameraTilt& t) {
  d->tilt.accelerometer_x = t.x;
  d->tilt.accelerometer_y = t.y;
  d->tilt.accelerometer_z = t.z;
  d->tilt.tilt_angle = t.half_degrees;
}

/// What one message of the server brings about.
void handle(freenect_context* c, const CameraHead& head) {
  freenect_device* d = c->device;
  switch (head.what) {
    case CameraMessage::Depth:
      if (d == nullptr || !d->depth_runs || c->bytes.size() != kDepthBytes) return;
      if (d->depth_buffer != nullptr) std::memcpy(d->depth_buffer, c->bytes.data(), c->bytes.size());
      if (d->on_depth != nullptr)
        d->on_depth(d, d->depth_buffer != nullptr ? d->depth_buffer : c->bytes.data(), head.value);
      return;
    case CameraMessage::Infrared:
      if (d == nullptr || !d->video_runs || c->bytes.size() != kInfraredBytes) return;
      if (d->video_buffer != nullptr) std::memcpy(d->video_buffer, c->bytes.data(), c->bytes.size());
      if (d->on_video != nullptr)
        d->on_video(d, d->video_buffer != nullptr ? d->video_buffer : c->bytes.data(), head.value);
      return;
    case CameraMessage::Tilt: {
      CameraTilt t;
      if (d == nullptr || c->bytes.size() != sizeof t) return;
      std::memcpy(&t, c->bytes.data(), sizeof t);
      set_tilt(d, t);
      return;
    }
    case CameraMessage::Log:
      c->bytes.push_back('\0');
      log(c, static_cast<int>(head.value), reinterpret_cast<const char*>(c->bytes.data()));
      return;
    case CameraMessage::Unplug:
      c->dead = true;
      return;
    case CameraMessage::Hang:
      std::this_thread::sleep_for(std::chrono::milliseconds(head.value));
      return;
    case CameraMessage::Crash:
      std::raise(SIGSEGV);
      return;
    default:
      return;
  }
}

}  // namespace

extern "C" {

int freenect_init(freenect_context** ctx, freenect_usb_context*) {
  *ctx = new _freenect_context();
  return 0;
}

int freenect_shutdown(freenect_context* ctx) {
  if (ctx->device != nullptr) (void)freenect_close_device(ctx->device);
  delete ctx;
  return 0;
}

void freenect_set_log_level(freenect_context* ctx, freenect_loglevel level) {
  ctx->level = level;
}
void freenect_set_log_callback(freenect_context* ctx, freenect_log_cb cb) {
  ctx->on_log = cb;
}

int freenect_process_events_timeout(freenect_context* ctx, struct timeval* timeout) {
  const auto ms = timeout->tv_sec * 1000 + timeout->tv_usec / 1000;
  CameraHead head;
  int wait = static_cast<int>(ms);
  // all that has come, and at least one wait
  for (int i = 0; i < 8 && !ctx->dead; ++i) {
    const auto got = ctx->socket.receive(wait, head, ctx->bytes);
    if (got == CameraSocket::Got::Nothing) break;
    if (got == CameraSocket::Got::Gone) {
      ctx->dead = true;
      break;
    }
    handle(ctx, head);
    wait = 0;
  }
  if (!ctx->dead) return 0;
  // as the real library: both streams are stopped, and the flag is never cleared
  if (ctx->device != nullptr) ctx->device->depth_runs = ctx->device->video_runs = false;
  return -1;
}

int freenect_process_events(freenect_context* ctx) {
  timeval timeout{60, 0};
  return freenect_process_events_timeout(ctx, &timeout);
}

int freenect_num_devices(freenect_context* ctx) {
  return ctx->socket.open() ? 1 : 0;
}

int freenect_list_device_attributes(freenect_context* ctx, struct freenect_device_attributes** list) {
  *list = nullptr;
  if (!ctx->socket.open()) return 0;
  *list = new freenect_device_attributes();
  (*list)->camera_serial = ::strdup(ctx->socket.hello().serial);
  return 1;
}

void freenect_free_device_attributes(struct freenect_device_attributes* list) {
  while (list != nullptr) {
    freenect_device_attributes* next = list->next;
    std::free(const_cast<char*>(list->camera_serial));
    delete list;
    list = next;
  }
}

int freenect_supported_subdevices(void) {
  return FREENECT_DEVICE_CAMERA | FREENECT_DEVICE_MOTOR;
}
void freenect_select_subdevices(freenect_context* ctx, freenect_device_flags flags) {
  ctx->subdevices = flags;
}
freenect_device_flags freenect_enabled_subdevices(freenect_context* ctx) {
  return ctx->subdevices;
}

int freenect_open_device(freenect_context* ctx, freenect_device** dev, int index) {
  if (index != 0 || ctx->device != nullptr || !ctx->socket.open()) return -1;
  auto* d = new _freenect_device();
  d->context = ctx;
  set_tilt(d, ctx->socket.hello().tilt);
  ctx->device = d;
  *dev = d;
  return 0;
}

int freenect_open_device_by_camera_serial(freenect_context* ctx, freenect_device** dev, const char* serial) {
  if (!ctx->socket.open() || std::strcmp(serial, ctx->socket.hello().serial) != 0) return -1;
  return freenect_open_device(ctx, dev, 0);
}

int freenect_close_device(freenect_device* dev) {
  dev->depth_runs = dev->video_runs = false;
  tell_requests(dev);
  dev->context->socket.close();
  dev->context->device = nullptr;
  delete dev;
  return 0;
}

void freenect_set_user(freenect_device* dev, void* user) {
  dev->user = user;
}
void* freenect_get_user(freenect_device* dev) {
  return dev->user;
}
void freenect_set_depth_callback(freenect_device* dev, freenect_depth_cb cb) {
  dev->on_depth = cb;
}
void freenect_set_video_callback(freenect_device* dev, freenect_video_cb cb) {
  dev->on_video = cb;
}
void freenect_set_depth_chunk_callback(freenect_device*, freenect_chunk_cb) {}
void freenect_set_video_chunk_callback(freenect_device*, freenect_chunk_cb) {}

int freenect_set_depth_buffer(freenect_device* dev, void* buffer) {
  dev->depth_buffer = buffer;
  return 0;
}
int freenect_set_video_buffer(freenect_device* dev, void* buffer) {
  dev->video_buffer = buffer;
  return 0;
}

int freenect_start_depth(freenect_device* dev) {
  if (dev->depth_runs || dev->context->dead) return -1;
  dev->depth_runs = true;
  tell_requests(dev);
  return 0;
}
int freenect_start_video(freenect_device* dev) {
  if (dev->video_runs || dev->context->dead || dev->video_mode.is_valid == 0) return -1;
  dev->video_runs = true;
  tell_requests(dev);
  return 0;
}
int freenect_stop_depth(freenect_device* dev) {
  if (!dev->depth_runs) return -1;
  dev->depth_runs = false;
  tell_requests(dev);
  return 0;
}
int freenect_stop_video(freenect_device* dev) {
  if (!dev->video_runs) return -1;
  dev->video_runs = false;
  tell_requests(dev);
  return 0;
}

int freenect_update_tilt_state(freenect_device* dev) {
  return (dev->context->subdevices & FREENECT_DEVICE_MOTOR) != 0 && !dev->context->dead ? 0 : -1;
}
freenect_raw_tilt_state* freenect_get_tilt_state(freenect_device* dev) {
  return &dev->tilt;
}
double freenect_get_tilt_degs(freenect_raw_tilt_state* state) {
  return state->tilt_angle / 2.0;
}
freenect_tilt_status_code freenect_get_tilt_status(freenect_raw_tilt_state* state) {
  return state->tilt_status;
}
int freenect_set_tilt_degs(freenect_device* dev, double angle) {
  if ((dev->context->subdevices & FREENECT_DEVICE_MOTOR) == 0 || dev->context->dead) return -1;
  const double within = angle < -31.0 ? -31.0 : angle > 31.0 ? 31.0 : angle;
  dev->context->socket.send(CameraMessage::SetTilt,
                            static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(within))));
  return 0;
}
int freenect_set_led(freenect_device*, freenect_led_options) {
  return 0;
}
void freenect_get_mks_accel(freenect_raw_tilt_state* state, double* x, double* y, double* z) {
  constexpr double kScale = 9.80665 / FREENECT_COUNTS_PER_G;
  *x = kScale * state->accelerometer_x;
  *y = kScale * state->accelerometer_y;
  *z = kScale * state->accelerometer_z;
}

int freenect_get_depth_mode_count() {
  return 1;
}
freenect_frame_mode freenect_get_depth_mode(int mode) {
  return mode == 0 ? depth_mode() : freenect_frame_mode{};
}
int freenect_get_video_mode_count() {
  return 1;
}
freenect_frame_mode freenect_get_video_mode(int mode) {
  return mode == 0 ? infrared_mode() : freenect_frame_mode{};
}
freenect_frame_mode freenect_get_current_depth_mode(freenect_device* dev) {
  return dev->depth_mode;
}
freenect_frame_mode freenect_get_current_video_mode(freenect_device* dev) {
  return dev->video_mode;
}
freenect_frame_mode freenect_find_depth_mode(freenect_resolution r, freenect_depth_format f) {
  return r == FREENECT_RESOLUTION_MEDIUM && f == FREENECT_DEPTH_11BIT ? depth_mode() : freenect_frame_mode{};
}
freenect_frame_mode freenect_find_video_mode(freenect_resolution r, freenect_video_format f) {
  return r == FREENECT_RESOLUTION_MEDIUM && f == FREENECT_VIDEO_IR_10BIT ? infrared_mode()
                                                                         : freenect_frame_mode{};
}
int freenect_set_depth_mode(freenect_device* dev, const freenect_frame_mode mode) {
  if (mode.reserved != 1 || dev->depth_runs) return -1;
  dev->depth_mode = mode;
  return 0;
}
int freenect_set_video_mode(freenect_device* dev, const freenect_frame_mode mode) {
  if (mode.reserved != 2 || dev->video_runs) return -1;
  dev->video_mode = mode;
  return 0;
}
int freenect_set_flag(freenect_device*, freenect_flag, freenect_flag_value) {
  return 0;
}
int freenect_get_ir_brightness(freenect_device* dev) {
  return dev->brightness;
}
int freenect_set_ir_brightness(freenect_device* dev, uint16_t brightness) {
  dev->brightness = brightness < 1 ? 1 : brightness > 50 ? 50 : brightness;
  dev->context->socket.send(CameraMessage::Brightness, static_cast<std::uint32_t>(dev->brightness));
  return 0;
}
void freenect_set_fw_address_nui(freenect_context*, unsigned char*, unsigned int) {}
void freenect_set_fw_address_k4w(freenect_context*, unsigned char*, unsigned int) {}

freenect_registration freenect_copy_registration(freenect_device* dev) {
  freenect_registration r{};
  const auto& hello = dev->context->socket.hello();
  r.zero_plane_info.dcmos_emitter_dist = static_cast<float>(hello.emitter_cm);
  r.zero_plane_info.reference_distance = static_cast<float>(hello.reference_cm);
  r.zero_plane_info.reference_pixel_size = static_cast<float>(hello.pixel_cm);
  r.const_shift = hello.shift;
  return r;
}
int freenect_destroy_registration(freenect_registration*) {
  return 0;
}

}  // extern "C"
