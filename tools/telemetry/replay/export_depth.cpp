// Depth frames as files that other programs read.

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csetjmp>
#include <cstring>
#include <fstream>

#include "tools/telemetry/channels/channels.hpp"
#include "tools/telemetry/channels/json_parts.hpp"
#include "tools/telemetry/mcap/byte_io.hpp"
#include "tools/telemetry/replay/export.hpp"
#include "tools/telemetry/replay/export_files.hpp"

namespace colift::telemetry {
namespace {

constexpr double kUnit_m = 0.001;
constexpr int kKinectWidth = 640, kKinectHeight = 480;
constexpr double kTicksPerSecond = 60e6;  // of a Kinect's own counter, 32 bits

void append(png_structp png, png_bytep data, png_size_t size) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(data), size);
}
void no_flush(png_structp) {}

/// 16-bit grey; empty when libpng has no memory.
std::string grey_png(int width, int height, std::string& big_endian) {
  std::string out;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  if (!info || setjmp(png_jmpbuf(png))) {
    png_destroy_write_struct(&png, &info);
    return {};
  }
  png_set_write_fn(png, &out, append, no_flush);
  // the noise of a depth camera leaves a filter nothing to predict: without one the file is smaller, in half
  // the time
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_NONE);
  png_set_compression_level(png, 2);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), 16,
               PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  for (int v = 0; v < height; ++v)
    png_write_row(png, reinterpret_cast<png_bytep>(big_endian.data()) +
                           static_cast<std::size_t>(v) * static_cast<std::size_t>(width) * 2);
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return out;
}

std::string camera_json(const hal::CameraIntrinsics& c) {
  return dumped({{"fx", c.fx},
                 {"fy", c.fy},
                 {"cx", c.cx},
                 {"cy", c.cy},
                 {"depth_scale_m", kUnit_m},
                 {"width", c.width},
                 {"height", c.height}}) +
         "\n";
}

bool same_camera(const hal::CameraIntrinsics& a, const hal::CameraIntrinsics& b) {
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy && a.cx == b.cx &&
         a.cy == b.cy;
}

}  // namespace

std::uint16_t kinect_code(float depth_m) {
  constexpr double kK_mm = 345489.4, kInfinity = 1089.408;
  if (!(depth_m > 0.0f)) return 2047;
  // recorded depths are whole millimetres, cut off: the code in the middle of the millimetre is the code
  const double z_mm = 1000.0 * static_cast<double>(depth_m);
  const double code = std::round(kInfinity - kK_mm / (z_mm + 0.5));
  return code < 0.0 || code > 1088.0 ? std::uint16_t{2047} : static_cast<std::uint16_t>(code);
}

tl::unexpected<hal::Error> cannot_write(const std::filesystem::path& file) {
  const int reason = errno;
  return hal::failure(hal::ErrorCode::BadInput, file.string(),
                      fmt::format("cannot be written: {}", std::strerror(reason ? reason : EIO)));
}

hal::Result<> make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder))
    return hal::failure(hal::ErrorCode::BadInput, folder.string(),
                        fmt::format("cannot be made a folder: {}", error ? error.message() : "it is a file"));
  return {};
}

hal::Result<> write_whole(const std::filesystem::path& file, std::string_view bytes) {
  errno = 0;
  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!out.flush()) return cannot_write(file);
  return {};
}

hal::Result<> for_each_frame(const McapReader& file, Exported& out,
                             const std::function<hal::Result<>(const NumberedFrame&)>& take) {
  std::uint64_t good = 0, bad = 0;
  const std::string depth = channel_of(Topic::Depth).topic;
  auto cursor = file.messages({channel_of(Topic::Frame).topic, channel_of(Topic::Colour).topic, depth});
  FrameJoiner joiner;
  while (const auto message = cursor.next()) {
    const auto channel = file.info().channels.find(message->channel_id);
    if (channel == file.info().channels.end()) continue;
    const auto encoded = joiner.add(channel->second.topic, message->data);
    if (!encoded) {
      if (channel->second.topic == depth) ++bad;
      continue;
    }
    const auto frame = decode_frame(*encoded);
    const auto& c = frame ? frame->frame.intrinsics : hal::CameraIntrinsics{};
    if (!frame || frame->frame.depth_m.size() !=
                      static_cast<std::size_t>(c.width) * static_cast<std::size_t>(c.height)) {
      ++bad;
      continue;
    }
    ++good;
    if (auto done = take(*frame); !done) return done;
  }
  if (bad > 0) out.notes.push_back(fmt::format("{} frames are damaged and left out", bad));
  if (good == 0)
    return hal::failure(hal::ErrorCode::BadInput, "export", "the recording holds no depth frames");
  return {};
}

hal::Result<Exported> export_png(const McapReader& file, const std::filesystem::path& folder) {
  if (auto made = make_folder(folder); !made) return tl::unexpected(made.error());
  Exported out;
  std::optional<hal::CameraIntrinsics> camera;
  std::string table = "file,number,exposed_at_s\n";
  std::uint64_t rounded = 0, beyond = 0, others = 0;
  double worst_m = 0.0;
  const auto done = for_each_frame(file, out, [&](const NumberedFrame& n) -> hal::Result<> {
    const hal::DepthFrame& f = n.frame;
    if (!camera) camera = f.intrinsics;
    if (!same_camera(*camera, f.intrinsics)) {
      ++others;
      return {};
    }
    std::string pixels;
    pixels.reserve(2 * f.depth_m.size());
    for (const float d : f.depth_m) {
      double units = d > 0.0f ? std::round(static_cast<double>(d) / kUnit_m) : 0.0;
      if (units > 65535.0) units = 0.0, ++beyond;
      const auto value = static_cast<std::uint16_t>(units);
      // read back as a float it has to be the same one
      if (value > 0 && static_cast<float>(value * kUnit_m) != d) {
        ++rounded;
        worst_m = std::max(worst_m, std::abs(value * kUnit_m - static_cast<double>(d)));
      }
      pixels.push_back(static_cast<char>(value >> 8));
      pixels.push_back(static_cast<char>(value & 0xff));
    }
    const std::string name = fmt::format("depth_{:06}.png", out.count);
    const std::string png = grey_png(f.intrinsics.width, f.intrinsics.height, pixels);
    if (auto written = write_whole(folder / name, png); !written) return written;
    if (out.files.size() < 3) out.files.push_back(folder / name);
    ++out.count;
    table += fmt::format("{},{},{:.9f}\n", name, n.number, hal::seconds(f.exposed_at));
    return {};
  });
  if (!done) return tl::unexpected(done.error());
  if (auto written = write_whole(folder / "camera.json", camera_json(*camera)); !written)
    return tl::unexpected(written.error());
  if (auto written = write_whole(folder / "frames.csv", table); !written)
    return tl::unexpected(written.error());
  if (rounded > 0)
    out.notes.push_back(fmt::format("{} pixels were rounded to whole millimetres, by at most {:.2g} mm",
                                    rounded, 1e3 * worst_m));
  if (beyond > 0) out.notes.push_back(fmt::format("{} pixels beyond 65.5 m are left out", beyond));
  if (others > 0) out.notes.push_back(fmt::format("{} frames of another camera are left out", others));
  return out;
}

hal::Result<Exported> export_fakenect(const McapReader& file, const std::filesystem::path& folder) {
  if (auto made = make_folder(folder); !made) return tl::unexpected(made.error());
  Exported out;
  std::string index;
  std::uint64_t others = 0, moved = 0;
  double worst_m = 0.0;
  const auto done = for_each_frame(file, out, [&](const NumberedFrame& n) -> hal::Result<> {
    const hal::DepthFrame& f = n.frame;
    if (f.intrinsics.width != kKinectWidth || f.intrinsics.height != kKinectHeight) {
      ++others;
      return {};
    }
    std::string bytes = "P5 640 480 65535\n";
    ByteWriter w(bytes);
    for (const float d : f.depth_m) {
      const std::uint16_t code = kinect_code(d);
      w.u16(code);
      if (!(d > 0.0f)) continue;
      const double back_m = code == 2047 ? 0.0 : std::trunc(345489.4 / (1089.408 - code)) / 1000.0;
      if (static_cast<float>(back_m) == d) continue;
      ++moved;
      worst_m = std::max(worst_m, std::abs(back_m - static_cast<double>(d)));
    }
    const double t_s = std::max(0.0, hal::seconds(f.exposed_at));
    const auto ticks = static_cast<std::uint32_t>(
        static_cast<std::uint64_t>(std::llround(t_s * kTicksPerSecond)) & 0xffffffffu);
    const std::string name = fmt::format("d-{:.6f}-{}.pgm", t_s, ticks);
    if (auto written = write_whole(folder / name, bytes); !written) return written;
    if (out.files.size() < 3) out.files.push_back(folder / name);
    ++out.count;
    index += name + "\n";
    return {};
  });
  if (!done) return tl::unexpected(done.error());
  if (auto written = write_whole(folder / "INDEX.txt", index); !written)
    return tl::unexpected(written.error());
  if (moved > 0)
    out.notes.push_back(
        fmt::format("{} pixels are no depths of a Kinect v1 with nominal constants; the nearest "
                    "code is off by at most {:.2g} mm",
                    moved, 1e3 * worst_m));
  if (others > 0) out.notes.push_back(fmt::format("{} frames are not 640 x 480 and are left out", others));
  return out;
}

}  // namespace colift::telemetry
