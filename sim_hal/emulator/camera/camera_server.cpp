#include "sim_hal/emulator/camera/camera_server.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <utility>

#include "hal/types/units.hpp"
#include "sim_hal/synthetic/hash_random.hpp"

namespace colift::sim_hal {
namespace {

using namespace std::chrono_literals;
using Kind = CameraFault::Kind;

constexpr std::uint16_t kNothing = 2047;
constexpr std::size_t kWidth = 640, kPixels = 640UL * 480;
constexpr std::size_t kPacketPixels = 1271;  // 1748 bytes of 11 bits
constexpr std::size_t kBlot = 16;            // pixels of a side
constexpr std::size_t kMostEvents = 10000;
constexpr std::uint64_t kStream = 89;
constexpr int kLogInfo = 4;
constexpr hal::Duration kTick = 2ms;  // between two looks at the faults
constexpr std::size_t kMostWaiting = 64;

/// A part of the pixels, in blots, for `what`.
template <class Do>
void blots(double percent, std::uint64_t seed, const Do& what) {
  for (std::size_t i = 0; i < kPixels; ++i) {
    const std::size_t blot = (i / kWidth / kBlot) * (kWidth / kBlot) + (i % kWidth) / kBlot;
    if (static_cast<double>(hash(seed, kStream, blot) % 10000) < 100.0 * percent) what(i);
  }
}

/// Of the accelerometer in the device's axes (x right, y up, z backwards), and of the motor. The picture
/// stays: the simulated camera does not turn.
CameraTilt tilt_of(const Vec3& up_C, double motor_deg) {
  CameraTilt tilt;
  tilt.x = static_cast<std::int16_t>(std::lround(819.0 * up_C.x()));
  tilt.y = static_cast<std::int16_t>(std::lround(-819.0 * up_C.y()));
  tilt.z = static_cast<std::int16_t>(std::lround(-819.0 * up_C.z()));
  tilt.half_degrees = static_cast<decltype(tilt.half_degrees)>(std::lround(2.0 * motor_deg));
  return tilt;
}

std::string next_address() {
  static std::atomic<int> count{0};
  return fmt::format("@colift-kinect-{}-{}", ::getpid(), ++count);
}

}  // namespace

CameraServer::CameraServer(CameraServerConfig config, std::unique_ptr<CameraSource> eye)
    : config_(std::move(config)), eye_(std::move(eye)) {
  if (config_.address.empty()) config_.address = next_address();
  was_active_.resize(config_.faults.size(), 0);
}

CameraServer::~CameraServer() {
  stop();
}

hal::Result<> CameraServer::start() {
  const auto refuse = [&](const std::string& reason) {
    if (listener_ >= 0) ::close(std::exchange(listener_, -1));
    return hal::failure(hal::ErrorCode::BadConfig, "camera.start",
                        fmt::format("address {}: {}", config_.address, reason));
  };
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (config_.address[0] != '@' || config_.address.size() < 2 ||
      config_.address.size() >= sizeof address.sun_path)
    return refuse("expected @NAME");
  std::memcpy(address.sun_path + 1, config_.address.data() + 1, config_.address.size() - 1);
  const auto bytes = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + config_.address.size());
  listener_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (listener_ < 0 || ::bind(listener_, reinterpret_cast<const sockaddr*>(&address), bytes) != 0 ||
      ::listen(listener_, 4) != 0)
    return refuse(std::strerror(errno));
  stop_ = false;
  began_ = next_ = clock_.now();
  thread_ = std::thread([this] { run(); });
  return {};
}

void CameraServer::stop() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
  if (client_ >= 0) ::close(std::exchange(client_, -1));
  if (listener_ >= 0) ::close(std::exchange(listener_, -1));
}

void CameraServer::run() {
  while (!stop_) {
    const hal::Timestamp now = clock_.now();
    t_s_ = hal::seconds(now - began_);
    follow_faults();
    if (now >= next_) frame_due(now);
    flush(now);
    const auto left = std::clamp<hal::Duration>(next_ - clock_.now(), 0ns, kTick);
    pollfd fds[2] = {{listener_, POLLIN, 0},
                     {client_, static_cast<short>(POLLIN | (queue_.empty() ? 0 : POLLOUT)), 0}};
    const timespec wait{0, left.count()};
    (void)::ppoll(fds, client_ >= 0 ? 2 : 1, &wait, nullptr);
    if ((fds[0].revents & POLLIN) != 0) accept_client();
    if (client_ >= 0 && (fds[1].revents & (POLLIN | POLLHUP | POLLERR)) != 0) hear();
    const std::lock_guard lock(mutex_);
    published_s_ = t_s_;
  }
}

void CameraServer::accept_client() {
  const int fd = ::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
  if (fd < 0) return;
  CameraHead head;
  if (client_ >= 0 || now_active(Kind::Unplug) != nullptr) {
    (void)!::send(fd, &head, sizeof head, MSG_NOSIGNAL);
    ::close(fd);
    const std::lock_guard lock(mutex_);
    ++report_.refused;
    return;
  }
  client_ = fd;
  const int big = 2 << 20;  // granted to some
  (void)::setsockopt(fd, SOL_SOCKET, SO_SNDBUFFORCE, &big, sizeof big);
  wants_ = 0;
  queue_.clear();
  written_ = 0;
  heard_.clear();
  CameraHello hello;
  std::strncpy(hello.serial, config_.serial.c_str(), sizeof hello.serial - 1);
  hello.tilt = tilt_of(eye_->up_C(), report_.tilt_deg);
  put(CameraMessage::Hello, 0, &hello, sizeof hello, hal::Timestamp(0));
  {
    const std::lock_guard lock(mutex_);
    ++report_.clients;
  }
  report("a client opens the camera");
}

void CameraServer::drop_client(const std::string& why) {
  if (client_ < 0) return;
  ::close(std::exchange(client_, -1));
  wants_ = 0;
  queue_.clear();
  written_ = 0;
  report(why);
}

void CameraServer::hear() {
  std::uint8_t bytes[256];
  const ssize_t n = ::recv(client_, bytes, sizeof bytes, MSG_DONTWAIT);
  if (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR)) {
    drop_client("the client is gone");
    return;
  }
  if (n < 0) return;
  heard_.insert(heard_.end(), bytes, bytes + n);
  CameraHead head;
  while (heard_.size() >= sizeof head) {
    std::memcpy(&head, heard_.data(), sizeof head);
    if (head.magic != kCameraWireMagic || head.bytes != 0) {
      drop_client("the client talks nonsense");
      return;
    }
    heard_.erase(heard_.begin(), heard_.begin() + sizeof head);
    if (head.what == CameraMessage::Want && head.value != wants_) {
      wants_ = head.value;
      report(fmt::format("the client wants {}{}{}", (wants_ & 1U) != 0 ? "depth" : "",
                         (wants_ & 2U) != 0 ? " infrared" : "", wants_ == 0 ? "nothing" : ""));
    } else if (head.what == CameraMessage::SetTilt) {
      const auto degrees = static_cast<std::int32_t>(head.value);
      if (std::abs(degrees) <= 31) {
        const std::lock_guard lock(mutex_);
        report_.tilt_deg = degrees;
      }
      report(fmt::format("the motor turns to {} deg", degrees));
    } else if (head.what == CameraMessage::Brightness) {
      const std::lock_guard lock(mutex_);
      report_.brightness = static_cast<int>(std::min<std::uint32_t>(head.value, 50));
    }
  }
}

const CameraFault* CameraServer::now_active(Kind kind) const {
  for (auto it = config_.faults.rbegin(); it != config_.faults.rend(); ++it)
    if (it->kind == kind && it->active(t_s_)) return &*it;
  return nullptr;
}

void CameraServer::follow_faults() {
  {
    const std::lock_guard lock(mutex_);
    for (CameraFault& f : wished_) {
      f.at_s += t_s_;
      config_.faults.push_back(std::move(f));
    }
    wished_.clear();
  }
  was_active_.resize(config_.faults.size(), 0);
  for (std::size_t i = 0; i < config_.faults.size(); ++i) {
    const CameraFault& f = config_.faults[i];
    const bool active = f.active(t_s_);
    if (active == (was_active_[i] != 0)) continue;
    was_active_[i] = active ? 1 : 0;
    report(fmt::format("{} {}", f.text, active ? "begins" : "is over"));
    if (f.kind == Kind::Freeze) frozen_ = last_codes_;
    if (f.kind == Kind::Restamp) same_ticks_.reset();
    if (f.kind == Kind::Moved && active) {
      eye_->turn(hal::deg_to_rad(f.value));
      turned_deg_ = f.value;
    }
    if (!active) continue;
    if (f.kind == Kind::Clock) clock_set_s_ += f.value;
    const hal::Timestamp now = clock_.now();
    if (f.kind == Kind::Unplug && client_ >= 0) {
      put(CameraMessage::Unplug, 0, nullptr, 0, now);
      flush(now);
      drop_client("the camera is unplugged");
    }
    if (f.kind == Kind::Hang)
      put(CameraMessage::Hang, static_cast<std::uint32_t>(1e3 * f.for_s), nullptr, 0, now);
    if (f.kind == Kind::Crash) put(CameraMessage::Crash, 0, nullptr, 0, now);
  }
}

std::uint32_t CameraServer::ticks_at(hal::Timestamp at) const {
  const auto since = at - first_at_.value_or(at);
  const std::int64_t ticks = since.count() * 3 / 50 + std::llround(60e6 * clock_set_s_);  // 60 MHz
  return config_.first_ticks + static_cast<std::uint32_t>(ticks);                         // wraps
}

void CameraServer::frame_due(hal::Timestamp now) {
  const CameraFault* slow = now_active(Kind::Slow);
  const double hz = slow != nullptr ? slow->value : config_.rate_hz;
  const auto period = std::chrono::duration_cast<hal::Duration>(std::chrono::duration<double>(1.0 / hz));
  next_ += period;
  if (next_ < now) next_ = now + period;  // what could not be rendered in time was never exposed
  if (client_ < 0 || wants_ == 0 || now_active(Kind::Silent) != nullptr) return;
  const hal::Timestamp began = clock_.now();
  CameraExposure e = eye_->look(++frame_);
  e.at = began;  // the device's counter never stands still, whatever a simulated world's time does
  if (!first_at_) first_at_ = e.at;
  spoil(e);
  {
    const std::lock_guard lock(mutex_);
    ++report_.exposed;
    report_.worst_render_ms = std::max(report_.worst_render_ms, 1e3 * hal::seconds(clock_.now() - began));
  }
  if (queue_.size() > kMostWaiting || (!queue_.empty() && queue_.front().due <= began && written_ > 0)) {
    const std::lock_guard lock(mutex_);
    ++report_.not_taken;
    return;
  }
  if (now_active(Kind::Swap) != nullptr && !held_back_) {
    held_back_ = std::move(e);
    return;
  }
  send_exposure(e, clock_.now());
  if (held_back_) send_exposure(*std::exchange(held_back_, std::nullopt), clock_.now());
}

void CameraServer::spoil(CameraExposure& e) {
  const std::vector<std::uint16_t> whole = e.codes;
  const auto fill = [&](std::uint16_t code) { std::fill(e.codes.begin(), e.codes.end(), code); };
  if (now_active(Kind::Blind) != nullptr) fill(kNothing);
  if (now_active(Kind::Zeros) != nullptr) fill(0);
  if (const auto* f = now_active(Kind::Half))
    blots(f->value, hash(config_.seed, frame_, 1), [&](std::size_t i) { e.codes[i] = kNothing; });
  if (const auto* f = now_active(Kind::Corrupt))
    blots(f->value, hash(config_.seed, frame_, 2), [&](std::size_t i) {
      e.codes[i] = static_cast<std::uint16_t>(hash(config_.seed, frame_, i) & 2047U);
    });
  if (now_active(Kind::Freeze) != nullptr && frozen_.size() == e.codes.size()) e.codes = frozen_;
  if (const auto* f = now_active(Kind::Packets); f != nullptr && last_codes_.size() == e.codes.size()) {
    // what is lost holds the bytes of the frame before
    const auto runs = static_cast<std::uint64_t>(kPixels / kPacketPixels);
    for (int p = 0; p < static_cast<int>(f->value); ++p) {
      const std::size_t from =
          hash(config_.seed, frame_, 100 + static_cast<std::uint64_t>(p)) % runs * kPacketPixels;
      std::copy_n(last_codes_.begin() + static_cast<std::ptrdiff_t>(from), kPacketPixels,
                  e.codes.begin() + static_cast<std::ptrdiff_t>(from));
    }
    const std::string line = fmt::format("[Stream 70] Lost {} packets\n", static_cast<int>(f->value));
    put(CameraMessage::Log, kLogInfo, line.data(), line.size(), clock_.now());
  }
  last_codes_ = whole;
}

void CameraServer::send_exposure(const CameraExposure& e, hal::Timestamp now) {
  std::uint32_t ticks = ticks_at(e.at);
  if (now_active(Kind::Restamp) != nullptr) {
    if (!same_ticks_) same_ticks_ = ticks;
    ticks = *same_ticks_;
  }
  hal::Timestamp due = now;
  if (const auto* late = now_active(Kind::Late))
    due += std::chrono::duration_cast<hal::Duration>(std::chrono::duration<double>(late->value / 1e3));
  const CameraTilt tilt = tilt_of(e.up_C, report_.tilt_deg);
  put(CameraMessage::Tilt, 0, &tilt, sizeof tilt, due);
  const int copies = now_active(Kind::Double) != nullptr ? 2 : 1;
  const std::size_t pixels = now_active(Kind::Short) != nullptr ? e.codes.size() / 2 : e.codes.size();
  if ((wants_ & 1U) != 0)
    for (int i = 0; i < copies; ++i) put(CameraMessage::Depth, ticks, e.codes.data(), 2 * pixels, due);
  if ((wants_ & 2U) != 0) {
    const auto image = eye_->infrared(e);
    put(CameraMessage::Infrared, ticks, image.data(), 2 * image.size(), due);
    const std::lock_guard lock(mutex_);
    ++report_.infrared;
  }
}

void CameraServer::put(CameraMessage what, std::uint32_t value, const void* bytes, std::size_t count,
                       hal::Timestamp due) {
  if (client_ < 0) return;
  CameraHead head;
  head.what = what;
  head.bytes = static_cast<std::uint32_t>(count);
  head.value = value;
  Waiting w;
  w.due = due;
  w.bytes.resize(sizeof head + count);
  std::memcpy(w.bytes.data(), &head, sizeof head);
  if (count > 0) std::memcpy(w.bytes.data() + sizeof head, bytes, count);
  queue_.push_back(std::move(w));
}

void CameraServer::flush(hal::Timestamp now) {
  while (client_ >= 0 && !queue_.empty() && queue_.front().due <= std::max(now, clock_.now())) {
    const auto& bytes = queue_.front().bytes;
    const ssize_t n =
        ::send(client_, bytes.data() + written_, bytes.size() - written_, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (n < 0) {
      if (errno != EAGAIN && errno != EINTR) drop_client("the client is gone");
      return;
    }
    written_ += static_cast<std::size_t>(n);
    if (written_ < bytes.size()) return;
    if (bytes.size() >= kPixels) {
      const std::lock_guard lock(mutex_);
      ++report_.sent;
    }
    queue_.pop_front();
    written_ = 0;
  }
}

void CameraServer::report(std::string text) {
  const std::lock_guard lock(mutex_);
  if (events_.size() < kMostEvents) events_.push_back({t_s_, std::move(text)});
}

void CameraServer::inject(CameraFault fault) {
  const std::lock_guard lock(mutex_);
  wished_.push_back(std::move(fault));
}

CameraServerReport CameraServer::report() const {
  const std::lock_guard lock(mutex_);
  return report_;
}

std::vector<CameraServer::Event> CameraServer::take_events() {
  const std::lock_guard lock(mutex_);
  return std::exchange(events_, {});
}

double CameraServer::elapsed_s() const {
  const std::lock_guard lock(mutex_);
  return published_s_;
}

}  // namespace colift::sim_hal
