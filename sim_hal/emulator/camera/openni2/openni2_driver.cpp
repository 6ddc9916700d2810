// A driver module of OpenNI2 (2.2) whose one device is a CameraServer: OpenNI2's own library loads it from
// its folder of drivers, and any program for OpenNI2 runs on it unchanged. Depth in millimetres or tenths of
// them; unplugging, hanging and crashing on request.

#include <Driver/OniDriverAPI.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "sim_hal/emulator/camera/client/camera_socket.hpp"
#include "sim_hal/emulator/camera/openni2/emulated_stream.hpp"

// the macro that exports a driver names these, and a development package has them no more
#define XN_NEW(type, argument) new type(argument)
#define XN_DELETE(pointer) delete (pointer)

namespace {

using colift::sim_hal::CameraHead;
using colift::sim_hal::CameraMessage;
using colift::sim_hal::CameraSocket;
using colift::sim_hal::EmulatedStream;

constexpr int kTurn_ms = 5;

class Device final : public oni::driver::DeviceBase {
 public:
  /// `gone` is called once, from the device's thread, when it is unplugged.
  Device(CameraSocket& socket, std::function<void()> gone)
      : socket_(socket), gone_(std::move(gone)), thread_([this] { run(); }) {}
  ~Device() override {
    ends_ = true;
    thread_.join();
  }

  OniStatus getSensorInfoList(OniSensorInfo** sensors, int* count) override {
    *sensors = &sensor_;
    *count = 1;
    return ONI_STATUS_OK;
  }
  oni::driver::StreamBase* createStream(OniSensorType type) override {
    const std::lock_guard lock(mutex_);
    if (type != ONI_SENSOR_DEPTH || stream_) return nullptr;
    stream_ = std::make_shared<EmulatedStream>();
    return stream_.get();
  }
  void destroyStream(oni::driver::StreamBase*) override {
    const std::lock_guard lock(mutex_);
    stream_.reset();
  }
  OniBool isPropertySupported(int property) override {
    return property == ONI_DEVICE_PROPERTY_SERIAL_NUMBER ||
           property == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION;
  }
  OniStatus getProperty(int property, void* data, int* size) override {
    if (property == ONI_DEVICE_PROPERTY_SERIAL_NUMBER) {
      const char* const serial = socket_.hello().serial;
      const int bytes = static_cast<int>(std::strlen(serial)) + 1;
      if (*size < bytes) return ONI_STATUS_BAD_PARAMETER;
      std::memcpy(data, serial, static_cast<std::size_t>(bytes));
      *size = bytes;
      return ONI_STATUS_OK;
    }
    if (property != ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION || *size != sizeof(int))
      return ONI_STATUS_NOT_SUPPORTED;
    const int mode = registration_;
    std::memcpy(data, &mode, sizeof mode);
    return ONI_STATUS_OK;
  }
  OniStatus setProperty(int property, const void* data, int size) override {
    if (property != ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION || size != sizeof(int))
      return ONI_STATUS_NOT_SUPPORTED;
    int mode = 0;
    std::memcpy(&mode, data, sizeof mode);
    registration_ = mode;
    return ONI_STATUS_OK;
  }
  OniBool isImageRegistrationModeSupported(OniImageRegistrationMode) override { return TRUE; }

 private:
  void run() {
    CameraHead head;
    std::vector<std::uint8_t> bytes;
    bool wanted = false;
    while (!ends_) {
      {
        const std::lock_guard lock(mutex_);
        const bool wants = stream_ && stream_->runs();
        if (wants != wanted) socket_.send(CameraMessage::Want, wants ? 1U : 0U);
        wanted = wants;
      }
      const auto got = socket_.receive(kTurn_ms, head, bytes);
      if (got == CameraSocket::Got::Nothing) continue;
      if (got == CameraSocket::Got::Gone || head.what == CameraMessage::Unplug) {
        gone_();
        return;
      }
      handle(head, bytes);
    }
  }

  void handle(const CameraHead& head, const std::vector<std::uint8_t>& bytes) {
    if (head.what == CameraMessage::Hang) std::this_thread::sleep_for(std::chrono::milliseconds(head.value));
    if (head.what == CameraMessage::Crash) std::raise(SIGSEGV);
    if (head.what != CameraMessage::Depth) return;
    codes_.resize(bytes.size() / 2);
    std::memcpy(codes_.data(), bytes.data(), 2 * codes_.size());
    std::shared_ptr<EmulatedStream> stream;
    {
      const std::lock_guard lock(mutex_);
      stream = stream_;
    }
    if (stream) stream->deliver(codes_, head.value, registration_ != ONI_IMAGE_REGISTRATION_OFF);
  }

  CameraSocket& socket_;
  std::function<void()> gone_;
  std::array<OniVideoMode, EmulatedStream::kModes.size()> modes_ = EmulatedStream::kModes;
  OniSensorInfo sensor_{ONI_SENSOR_DEPTH, static_cast<int>(modes_.size()), modes_.data()};
  std::mutex mutex_;
  std::shared_ptr<EmulatedStream> stream_;
  /// As a program before may have left it.
  std::atomic<int> registration_ = ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR;
  std::vector<std::uint16_t> codes_;
  std::atomic<bool> ends_{false};
  std::thread thread_;  // last: it uses the rest
};

class Driver final : public oni::driver::DriverBase {
 public:
  explicit Driver(OniDriverServices* services) : DriverBase(services) {}

  OniStatus initialize(oni::driver::DeviceConnectedCallback connected,
                       oni::driver::DeviceDisconnectedCallback disconnected,
                       oni::driver::DeviceStateChangedCallback changed, void* cookie) override {
    (void)DriverBase::initialize(connected, disconnected, changed, cookie);
    if (!socket_.open()) return ONI_STATUS_OK;  // there is no device
    std::strncpy(info_.uri, (std::string("colift/") + socket_.hello().serial).c_str(), sizeof info_.uri - 1);
    std::strncpy(info_.vendor, "CoLift", sizeof info_.vendor - 1);
    std::strncpy(info_.name, "emulated depth camera", sizeof info_.name - 1);
    deviceConnected(&info_);
    return ONI_STATUS_OK;
  }
  oni::driver::DeviceBase* deviceOpen(const char* uri, const char*) override {
    if (device_ || !socket_.is_open() || std::strcmp(uri, info_.uri) != 0) return nullptr;
    device_ = std::make_unique<Device>(socket_, [this] { deviceDisconnected(&info_); });
    return device_.get();
  }
  void deviceClose(oni::driver::DeviceBase*) override { device_.reset(); }
  void shutdown() override {
    device_.reset();
    socket_.close();
  }

 private:
  CameraSocket socket_;
  OniDeviceInfo info_{};
  std::unique_ptr<Device> device_;
};

}  // namespace

ONI_EXPORT_DRIVER(Driver)
