#include "tools/telemetry/channels/depth_cdt1.hpp"

#include <algorithm>
#include <bit>
#include <vector>

#include "tools/telemetry/mcap/byte_io.hpp"

namespace colift::telemetry {
namespace {

constexpr std::uint32_t kMark = 0x31544443;  // "CDT1"
constexpr int kMaxSide = 8192;
constexpr std::size_t kMaxDepths = 4096;

enum Form : std::uint8_t { kTable = 0, kFloats = 1 };

tl::unexpected<hal::Error> damaged(const char* what) {
  return hal::failure(hal::ErrorCode::BadInput, "depth frame", what);
}

double take(ByteReader& r) {
  return std::bit_cast<double>(r.u64());
}

/// What a pixel is likely to be: the median of left, above, and the plane through both (the predictor of
/// lossless JPEG: Weinberger, Seroussi and Sapiro 1996).
std::uint16_t predicted(const std::vector<std::uint16_t>& codes, std::size_t i, std::size_t x,
                        std::size_t width) {
  if (i < width) return x > 0 ? codes[i - 1] : std::uint16_t{0};
  const int above = codes[i - width];
  if (x == 0) return static_cast<std::uint16_t>(above);
  const int left = codes[i - 1], corner = codes[i - width - 1];
  const int low = std::min(left, above), high = std::max(left, above);
  return static_cast<std::uint16_t>(std::clamp(left + above - corner, low, high));
}

std::uint16_t unzigzag(std::uint16_t z) {
  return static_cast<std::uint16_t>((z >> 1) ^ (z & 1 ? 0xffff : 0));
}

}  // namespace

bool is_cdt1(std::string_view bytes) {
  ByteReader r(bytes);
  return r.u32() == kMark && r.ok();
}

hal::Result<std::uint64_t> cdt1_number(std::string_view bytes) {
  ByteReader r(bytes);
  const std::uint32_t mark = r.u32();
  const std::uint64_t number = r.u64();
  if (!r.ok() || mark != kMark) return damaged("does not begin as one does");
  return number;
}

hal::Result<NumberedFrame> decode_cdt1(std::string_view bytes) {
  ByteReader r(bytes);
  if (r.u32() != kMark) return damaged("does not begin as one does");
  NumberedFrame out;
  hal::DepthFrame& f = out.frame;
  out.number = r.u64();
  f.exposed_at = hal::Timestamp(static_cast<std::int64_t>(r.u64()));
  const std::uint32_t width = r.u32(), height = r.u32();
  if (!r.ok() || width == 0 || height == 0 || width > kMaxSide || height > kMaxSide)
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
    if (!r.ok() || depths == 0 || depths > kMaxDepths) return damaged("has an impossible table");
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
