#include "tools/telemetry/channels/image_message.hpp"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <limits>
#include <optional>

#include "tools/telemetry/channels/messages.hpp"
#include "tools/telemetry/mcap/byte_io.hpp"

namespace colift::telemetry {
namespace {

constexpr std::uint32_t kLittleEndianCdr = 0x00000100;  // bytes 00 01 00 00
constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::size_t kHead = 4;  // alignment counts from behind the encapsulation

tl::unexpected<hal::Error> damaged(std::string what) {
  return hal::failure(hal::ErrorCode::BadInput, "image", std::move(what));
}

void align(std::string& out) {
  while ((out.size() - kHead) % 4 != 0) out.push_back('\0');
}

/// A text of CDR: its length counts the zero at its end.
void put_text(std::string& out, std::string_view text) {
  align(out);
  ByteWriter(out).u32(static_cast<std::uint32_t>(text.size() + 1));
  out.append(text).push_back('\0');
}

struct Size {
  std::size_t width = 0, height = 0;
};

Size size_of(const hal::CameraIntrinsics& c, std::size_t elements, std::size_t per_pixel) {
  if (c.width > 0 && c.height > 0) {
    const Size whole{static_cast<std::size_t>(c.width), static_cast<std::size_t>(c.height)};
    if (per_pixel * whole.width * whole.height == elements) return whole;
  }
  return {elements, 1};
}

std::string image(hal::Timestamp at, std::string_view frame_id, Size size, std::size_t pixel_bytes,
                  std::string_view encoding, std::string_view data) {
  std::string out;
  out.reserve(data.size() + 96);
  ByteWriter w(out);
  w.u32(kLittleEndianCdr);
  std::int64_t seconds = at.count() / kSecond_ns, rest = at.count() % kSecond_ns;
  if (rest < 0) --seconds, rest += kSecond_ns;
  w.u32(static_cast<std::uint32_t>(seconds)), w.u32(static_cast<std::uint32_t>(rest));
  put_text(out, frame_id);
  align(out);
  w.u32(static_cast<std::uint32_t>(size.height)), w.u32(static_cast<std::uint32_t>(size.width));
  put_text(out, encoding);
  w.u8(0);  // little endian
  align(out);
  w.u32(static_cast<std::uint32_t>(pixel_bytes * size.width));
  w.text(data);
  return out;
}

float metres(std::uint16_t millimetres) {
  return static_cast<float>(millimetres / 1000.0);
}

/// Every depth in whole millimetres, or nothing when that would change one.
std::optional<std::string> millimetres(const std::vector<float>& depth_m) {
  std::string data(2 * depth_m.size(), '\0');
  for (std::size_t i = 0; i < depth_m.size(); ++i) {
    const float d = depth_m[i];
    if (std::isnan(d)) continue;
    if (!(d > 0.0f) || d > 65.535f) return std::nullopt;
    const auto mm = static_cast<std::uint16_t>(1000.0f * d + 0.5f);
    if (mm == 0 || metres(mm) != d) return std::nullopt;
    data[2 * i] = static_cast<char>(mm & 0xff);
    data[2 * i + 1] = static_cast<char>(mm >> 8);
  }
  return data;
}

std::string floats(const std::vector<float>& depth_m) {
  std::string data;
  data.reserve(4 * depth_m.size());
  ByteWriter w(data);
  for (const float d : depth_m) w.u32(std::bit_cast<std::uint32_t>(d));
  return data;
}

/// Reads CDR: numbers of four bytes lie at multiples of four behind the encapsulation.
class CdrReader {
 public:
  explicit CdrReader(std::string_view bytes) : r_(bytes) {}
  std::uint32_t u32() {
    while (r_.ok() && (r_.at() - kHead) % 4 != 0) (void)r_.u8();
    return r_.u32();
  }
  std::uint8_t u8() { return r_.u8(); }
  std::string_view text() {
    const std::uint32_t length = u32();
    const std::string_view all = r_.bytes(length);
    return all.substr(0, all.empty() ? 0 : all.size() - 1);
  }
  std::string_view bytes() {
    const std::uint32_t length = u32();
    return r_.bytes(length);
  }
  std::uint32_t head() { return r_.u32(); }
  [[nodiscard]] bool ok() const { return r_.ok(); }

 private:
  ByteReader r_;
};

}  // namespace

std::string image_definition() {
  // the fields alone; types that it names follow behind lines of 80 equal signs, as in MCAP's "ros2msg"
  const std::string line(80, '=');
  return "std_msgs/Header header\n"
         "uint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\nuint8[] data\n" +
         line + "\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n" + line +
         "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
}

std::string depth_image(const hal::DepthFrame& f) {
  return depth_image(f, kCameraFrame);
}

std::string depth_image(const hal::DepthFrame& f, std::string_view frame_id) {
  const Size size = size_of(f.intrinsics, f.depth_m.size(), 1);
  if (const auto data = millimetres(f.depth_m)) return image(f.exposed_at, frame_id, size, 2, "16UC1", *data);
  return image(f.exposed_at, frame_id, size, 4, "32FC1", floats(f.depth_m));
}

std::string colour_image(const hal::DepthFrame& f) {
  const std::string_view data(reinterpret_cast<const char*>(f.rgb.data()), f.rgb.size());
  const Size size = size_of(f.intrinsics, f.rgb.size(), 3);
  const bool whole = 3 * size.width * size.height == f.rgb.size();
  return image(f.exposed_at, kCameraFrame, size, whole ? 3 : 1, whole ? "rgb8" : "8UC1", data);
}

hal::Result<ImageView> parse_image(std::string_view bytes) {
  CdrReader r(bytes);
  ImageView image;
  if (r.head() != kLittleEndianCdr) return damaged("is not in little-endian CDR");
  const auto seconds = static_cast<std::int32_t>(r.u32());
  image.stamp = hal::Timestamp(seconds * kSecond_ns + r.u32());
  image.frame_id = r.text();
  image.height = r.u32(), image.width = r.u32();
  image.encoding = r.text();
  if (r.u8() != 0) return damaged("holds big-endian pixels");
  image.step = r.u32();
  image.data = r.bytes();
  if (!r.ok()) return damaged("ends too early");
  return image;
}

hal::Result<std::vector<float>> depth_of(const ImageView& image) {
  std::vector<float> depth_m;
  ByteReader r(image.data);
  if (image.encoding == "16UC1") {
    depth_m.resize(image.data.size() / 2);
    for (float& d : depth_m) {
      const std::uint16_t mm = r.u16();
      d = mm == 0 ? std::numeric_limits<float>::quiet_NaN() : metres(mm);
    }
  } else if (image.encoding == "32FC1") {
    depth_m.resize(image.data.size() / 4);
    for (float& d : depth_m) d = std::bit_cast<float>(r.u32());
  } else {
    return damaged(fmt::format("has encoding '{}', not 16UC1 or 32FC1", image.encoding));
  }
  return depth_m;
}

}  // namespace colift::telemetry
