#include "hal/drivers/kinect/fakenect_writer.hpp"

#include <fmt/format.h>

#include <cstring>
#include <fstream>
#include <string_view>
#include <system_error>

namespace colift::hal::kinect {
namespace {

namespace fs = std::filesystem;

tl::unexpected<Error> cannot(const fs::path& file, const std::string& why) {
  return failure(ErrorCode::BadInput, file.string(), why);
}

bool write_file(const fs::path& file, std::string_view bytes, std::ios::openmode how = std::ios::trunc) {
  std::ofstream out(file, std::ios::binary | how);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return static_cast<bool>(out.flush());
}

}  // namespace

Result<FakenectWriter> FakenectWriter::open(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder, error)) return cannot(folder, "cannot be made a folder");
  if (!fs::is_empty(folder, error))
    return cannot(folder, "holds something already; expected a new or empty folder");
  if (!write_file(folder / "INDEX.txt", "")) return cannot(folder, "cannot be written");
  return FakenectWriter(folder);
}

Result<> FakenectWriter::write(const capture::RawFrame& depth, Timestamp at) {
  const std::string stem = fmt::format("{:.6f}-{}", seconds(at), depth.stamp.ticks);
  std::string image = "P5 640 480 65535\n";
  image.append(reinterpret_cast<const char*>(depth.pixels.data()), 2 * depth.pixels.size());
  std::string index = fmt::format("d-{}.pgm\n", stem);
  const fs::path file = folder_ / fmt::format("d-{}.pgm", stem);
  if (!write_file(file, image)) return cannot(file, "cannot be written: is the disk full?");
  bytes_ += image.size();
  if (depth.stamp.has_accel != 0) {
    // as the library's own struct lies in memory
    std::string dump(12, '\0');
    for (std::size_t i = 0; i < 3; ++i) {
      const auto counts = static_cast<std::int16_t>(depth.stamp.accel[i]);
      std::memcpy(dump.data() + 2 * i, &counts, 2);
    }
    dump[6] = static_cast<char>(depth.stamp.tilt_half_deg);
    if (!write_file(folder_ / fmt::format("a-{}.dump", stem), dump)) return cannot(file, "cannot be written");
    index += fmt::format("a-{}.dump\n", stem);
    bytes_ += dump.size();
  }
  if (!write_file(folder_ / "INDEX.txt", index, std::ios::app)) return cannot(folder_, "cannot be written");
  ++frames_;
  return {};
}

}  // namespace colift::hal::kinect
