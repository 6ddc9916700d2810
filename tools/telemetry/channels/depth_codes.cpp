#include "tools/telemetry/channels/depth_codes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <vector>

#include "tools/telemetry/mcap/byte_io.hpp"

namespace colift::telemetry {
namespace {

constexpr std::uint32_t kMark = 0x31544443;  // "CDT1"
constexpr int kLargest = 8192;
constexpr std::size_t kMostDepths = 4096;

enum Form : std::uint8_t { kTable = 0, kFloats = 1 };

tl::unexpected<hal::Error> damaged(const char* what) {
  return hal::failure(hal::ErrorCode::BadInput, "depth frame", what);
}

void put(ByteWriter& w, double value) {
  w.u64(std::bit_cast<std::uint64_t>(value));
}

double take(ByteReader& r) {
  return std::bit_cast<double>(r.u64());
}

/// The distinct bit patterns, ascending; empty when there are too many.
std::vector<std::uint32_t> distinct(const std::vector<float>& depth_m) {
  std::vector<std::uint32_t> found;
  std::uint32_t last = 0;
  bool any = false;
  for (const float d : depth_m) {
    const auto bits = std::bit_cast<std::uint32_t>(d);
    if (any && bits == last) continue;
    last = bits;
    any = true;
    const auto place = std::lower_bound(found.begin(), found.end(), bits);
    if (place != found.end() && *place == bits) continue;
    if (found.size() == kMostDepths) return {};
    found.insert(place, bits);
  }
  return found;
}

/// What a pixel is likely to be: the middle of left, above, and the plane through both (the median predictor
/// of lossless JPEG: Weinberger, Seroussi and Sapiro 1996).
std::uint16_t predicted(const std::vector<std::uint16_t>& codes, std::size_t i, std::size_t x,
                        std::size_t width) {
  if (i < width) return x > 0 ? codes[i - 1] : std::uint16_t{0};
  const int above = codes[i - width];
  if (x == 0) return static_cast<std::uint16_t>(above);
  const int left = codes[i - 1], corner = codes[i - width - 1];
  const int low = std::min(left, above), high = std::max(left, above);
  return static_cast<std::uint16_t>(std::clamp(left + above - corner, low, high));
}

std::uint16_t zigzag(std::uint16_t difference) {
  const auto d = static_cast<std::int16_t>(difference);
  return static_cast<std::uint16_t>((static_cast<std::uint16_t>(d) << 1) ^ (d < 0 ? 0xffff : 0));
}

std::uint16_t unzigzag(std::uint16_t z) {
  return static_cast<std::uint16_t>((z >> 1) ^ (z & 1 ? 0xffff : 0));
}

void put_table(ByteWriter& w, const std::vector<float>& depth_m, std::size_t width,
               const std::vector<std::uint32_t>& table) {
  w.u8(kTable);
  w.u32(static_cast<std::uint32_t>(table.size()));
  for (const std::uint32_t bits : table) w.u32(bits);
  const std::size_t n = depth_m.size();
  std::vector<std::uint16_t> codes(n);
  std::string planes(2 * n, '\0');
  std::uint32_t last_bits = 0;
  std::uint16_t last_code = 0;
  bool any = false;
  std::size_t x = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const auto bits = std::bit_cast<std::uint32_t>(depth_m[i]);
    if (!any || bits != last_bits) {
      last_code =
          static_cast<std::uint16_t>(std::lower_bound(table.begin(), table.end(), bits) - table.begin());
      last_bits = bits;
      any = true;
    }
    codes[i] = last_code;
    const std::uint16_t z = zigzag(static_cast<std::uint16_t>(codes[i] - predicted(codes, i, x, width)));
    planes[i] = static_cast<char>(z & 0xff);
    planes[n + i] = static_cast<char>(z >> 8);
    if (++x == width) x = 0;
  }
  w.bytes(planes);
}

void put_floats(ByteWriter& w, const std::vector<float>& depth_m) {
  w.u8(kFloats);
  const std::size_t n = depth_m.size();
  std::string planes(4 * n, '\0');
  for (std::size_t i = 0; i < n; ++i) {
    const auto bits = std::bit_cast<std::uint32_t>(depth_m[i]);
    for (std::size_t b = 0; b < 4; ++b) planes[b * n + i] = static_cast<char>((bits >> (8 * b)) & 0xff);
  }
  w.bytes(planes);
}

}  // namespace

std::string encode_depth(const NumberedFrame& numbered) {
  const hal::DepthFrame& f = numbered.frame;
  std::string out;
  ByteWriter w(out);
  w.u32(kMark);
  w.u64(numbered.number);
  w.u64(static_cast<std::uint64_t>(f.exposed_at.count()));
  // a frame of the wrong size is recorded too: it explains why it was refused
  w.u32(static_cast<std::uint32_t>(f.intrinsics.width));
  w.u32(static_cast<std::uint32_t>(f.intrinsics.height));
  put(w, f.intrinsics.fx), put(w, f.intrinsics.fy), put(w, f.intrinsics.cx), put(w, f.intrinsics.cy);
  w.u8(f.up_C ? 1 : 0);
  const hal::Vec3 up = f.up_C.value_or(hal::Vec3::Zero());
  put(w, up.x()), put(w, up.y()), put(w, up.z());
  w.u32(static_cast<std::uint32_t>(f.rgb.size()));
  w.u32(static_cast<std::uint32_t>(f.depth_m.size()));
  const auto width = static_cast<std::size_t>(std::max(f.intrinsics.width, 1));
  if (const auto table = distinct(f.depth_m); !table.empty())
    put_table(w, f.depth_m, width, table);
  else
    put_floats(w, f.depth_m);
  w.bytes({reinterpret_cast<const char*>(f.rgb.data()), f.rgb.size()});
  return out;
}

hal::Result<std::uint64_t> depth_number(std::string_view bytes) {
  ByteReader r(bytes);
  const std::uint32_t mark = r.u32();
  const std::uint64_t number = r.u64();
  if (!r.ok() || mark != kMark) return damaged("does not begin as one does");
  return number;
}

hal::Result<NumberedFrame> decode_depth(std::string_view bytes) {
  ByteReader r(bytes);
  if (r.u32() != kMark) return damaged("does not begin as one does");
  NumberedFrame out;
  hal::DepthFrame& f = out.frame;
  out.number = r.u64();
  f.exposed_at = hal::Timestamp(static_cast<std::int64_t>(r.u64()));
  const std::uint32_t width = r.u32(), height = r.u32();
  if (!r.ok() || width == 0 || height == 0 || width > kLargest || height > kLargest)
    return damaged("has an impossible size");
  f.intrinsics.width = static_cast<int>(width);
  f.intrinsics.height = static_cast<int>(height);
  f.intrinsics.fx = take(r), f.intrinsics.fy = take(r), f.intrinsics.cx = take(r), f.intrinsics.cy = take(r);
  const bool has_up = r.u8() != 0;
  const double ux = take(r), uy = take(r), uz = take(r);
  if (has_up) f.up_C = hal::Vec3(ux, uy, uz);
  const std::uint32_t colours = r.u32(), pixels = r.u32();
  const std::uint8_t form = r.u8();
  const std::size_t n = pixels;
  if (form == kTable) {
    const std::uint32_t depths = r.u32();
    if (!r.ok() || depths == 0 || depths > kMostDepths) return damaged("has an impossible table");
    std::vector<float> table(depths);
    for (float& d : table) d = std::bit_cast<float>(r.u32());
    const std::string_view planes = r.bytes(std::uint64_t{2} * n);
    if (!r.ok()) return damaged("ends too early");
    std::vector<std::uint16_t> codes(n);
    f.depth_m.resize(n);
    std::size_t x = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const auto z = static_cast<std::uint16_t>(static_cast<unsigned char>(planes[i]) |
                                                (static_cast<unsigned char>(planes[n + i]) << 8));
      codes[i] = static_cast<std::uint16_t>(predicted(codes, i, x, width) + unzigzag(z));
      if (codes[i] >= depths) return damaged("names a depth that its table does not hold");
      f.depth_m[i] = table[codes[i]];
      if (++x == width) x = 0;
    }
  } else if (form == kFloats) {
    const std::string_view planes = r.bytes(std::uint64_t{4} * n);
    if (!r.ok()) return damaged("ends too early");
    f.depth_m.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      std::uint32_t bits = 0;
      for (std::size_t b = 0; b < 4; ++b)
        bits |= static_cast<std::uint32_t>(static_cast<unsigned char>(planes[b * n + i])) << (8 * b);
      f.depth_m[i] = std::bit_cast<float>(bits);
    }
  } else {
    return damaged("is of an unknown form");
  }
  const std::string_view rgb = r.bytes(colours);
  if (!r.ok()) return damaged("ends too early");
  f.rgb.assign(rgb.begin(), rgb.end());
  return out;
}

}  // namespace colift::telemetry
