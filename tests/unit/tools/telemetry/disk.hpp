#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "tools/telemetry/mcap/byte_sink.hpp"

namespace colift::tests {

/// A disk in memory that can be full: writes what fits, then refuses, until room is made.
struct Disk {
  std::string bytes;
  std::uint64_t room = UINT64_MAX;  ///< Bytes that fit in all.
  int refused = 0;
  bool cuts = true;  ///< Can be cut back.
};

class DiskSink final : public telemetry::ByteSink {
 public:
  explicit DiskSink(Disk& disk) : disk_(disk) {}
  hal::Result<> write(std::string_view more) override {
    const std::uint64_t fits = disk_.room > disk_.bytes.size() ? disk_.room - disk_.bytes.size() : 0;
    if (more.size() <= fits) {
      disk_.bytes += more;
      return {};
    }
    disk_.bytes += more.substr(0, static_cast<std::size_t>(fits));
    ++disk_.refused;
    return hal::failure(hal::ErrorCode::BadInput, "disk", "No space left on device");
  }
  hal::Result<> cut_to(std::uint64_t length) override {
    if (!disk_.cuts) return hal::failure(hal::ErrorCode::BadInput, "disk", "cannot be cut");
    disk_.bytes.resize(static_cast<std::size_t>(length));
    return {};
  }
  hal::Result<> flush() override { return {}; }

 private:
  Disk& disk_;
};

}  // namespace colift::tests
