#include "tools/visualization/animated_png.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string_view>

namespace colift::picture {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::array<std::uint8_t, 8> kSignature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
constexpr int kChannels = 4;  // the fourth says which pixels stay as they were
constexpr double kMaxDelay_s = 60.0;

void put32(Bytes& out, std::uint32_t x) {
  for (const int shift : {24, 16, 8, 0}) out.push_back(static_cast<std::uint8_t>(x >> shift));
}
void put16(Bytes& out, unsigned x) {
  for (const int shift : {8, 0}) out.push_back(static_cast<std::uint8_t>(x >> shift));
}

void put_chunk(Bytes& out, std::string_view type, const Bytes& data) {
  put32(out, static_cast<std::uint32_t>(data.size()));
  const std::size_t from = out.size();
  out.insert(out.end(), type.begin(), type.end());
  out.insert(out.end(), data.begin(), data.end());
  put32(out, static_cast<std::uint32_t>(crc32(0, out.data() + from, static_cast<uInt>(out.size() - from))));
}

struct Area {
  int x = 0, y = 0, width = 0, height = 0;
};

/// The rectangle in which two pictures differ; a pixel where they are the same.
Area changed(const Bytes& a, const Bytes& b, int width, int height) {
  int left = width, right = -1, top = height, bottom = -1;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::size_t at =
          3U * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
      if (std::memcmp(a.data() + at, b.data() + at, 3) == 0) continue;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
    }
  if (right < 0) return {0, 0, 1, 1};
  return {left, top, right - left + 1, bottom - top + 1};
}

/// The pixels of an area; those that are as in `before` (null: none) transparent.
Bytes pixels_of(const Bytes& frame, const Bytes* before, int width, const Area& area) {
  Bytes out;
  out.reserve(static_cast<std::size_t>(kChannels) * static_cast<std::size_t>(area.width) *
              static_cast<std::size_t>(area.height));
  for (int y = area.y; y < area.y + area.height; ++y)
    for (int x = area.x; x < area.x + area.width; ++x) {
      const std::size_t at =
          3U * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
      if (before && std::memcmp(frame.data() + at, before->data() + at, 3) == 0) {
        out.insert(out.end(), {0, 0, 0, 0});
        continue;
      }
      out.insert(out.end(), {frame[at], frame[at + 1], frame[at + 2], 255});
    }
  return out;
}

/// Rows, each with the filter (none, left, above) that leaves the smallest differences, deflated.
Bytes packed(const Bytes& pixels, int width) {
  const std::size_t row = static_cast<std::size_t>(kChannels) * static_cast<std::size_t>(width);
  Bytes raw, best, tried(row);
  for (std::size_t from = 0; from < pixels.size(); from += row) {
    long least = -1;
    int chosen = 0;
    for (const int filter : {0, 1, 2}) {
      long sum = 0;
      for (std::size_t k = 0; k < row; ++k) {
        const std::uint8_t left =
            filter == 1 && k >= kChannels ? pixels[from + k - kChannels] : std::uint8_t{0};
        const std::uint8_t above = filter == 2 && from >= row ? pixels[from + k - row] : std::uint8_t{0};
        tried[k] = static_cast<std::uint8_t>(pixels[from + k] - left - above);
        sum += std::abs(static_cast<int>(static_cast<std::int8_t>(tried[k])));
      }
      if (least >= 0 && sum >= least) continue;
      least = sum;
      chosen = filter;
      best = tried;
    }
    raw.push_back(static_cast<std::uint8_t>(chosen));
    raw.insert(raw.end(), best.begin(), best.end());
  }
  uLongf size = compressBound(static_cast<uLong>(raw.size()));
  Bytes out(size);
  if (compress2(out.data(), &size, raw.data(), static_cast<uLong>(raw.size()), Z_DEFAULT_COMPRESSION) != Z_OK)
    return {};
  out.resize(size);
  return out;
}

}  // namespace

std::vector<std::uint8_t> animated_png(int width, int height, std::span<const std::vector<std::uint8_t>> all,
                                       double frame_s, double last_s) {
  std::vector<const Bytes*> frames;
  const std::size_t size =
      3U * static_cast<std::size_t>(std::max(0, width)) * static_cast<std::size_t>(std::max(0, height));
  for (const Bytes& frame : all)
    if (frame.size() == size && size > 0) frames.push_back(&frame);
  if (frames.empty()) return {};

  Bytes out(kSignature.begin(), kSignature.end()), data;
  put32(data, static_cast<std::uint32_t>(width));
  put32(data, static_cast<std::uint32_t>(height));
  data.insert(data.end(), {8, 6, 0, 0, 0});  // 8 bits, RGB and alpha, deflate, filtered rows, not interlaced
  put_chunk(out, "IHDR", data);
  data.clear();
  put32(data, static_cast<std::uint32_t>(frames.size()));
  put32(data, 0);  // plays for ever
  put_chunk(out, "acTL", data);

  std::uint32_t number = 0;  // of fcTL and fdAT together
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Bytes* const before = i > 0 ? frames[i - 1] : nullptr;
    const Area area = before ? changed(*frames[i], *before, width, height) : Area{0, 0, width, height};
    const double delay_s = std::clamp(i + 1 < frames.size() ? frame_s : last_s, 0.0, kMaxDelay_s);
    data.clear();
    put32(data, number++);
    for (const int x : {area.width, area.height, area.x, area.y}) put32(data, static_cast<std::uint32_t>(x));
    put16(data, static_cast<unsigned>(std::lround(1e3 * delay_s)));
    put16(data, 1000);
    data.insert(data.end(), {0, static_cast<std::uint8_t>(before ? 1 : 0)});  // stays; over what is there
    put_chunk(out, "fcTL", data);
    const Bytes stream = packed(pixels_of(*frames[i], before, width, area), area.width);
    data.clear();
    if (before) put32(data, number++);
    data.insert(data.end(), stream.begin(), stream.end());
    put_chunk(out, before ? "fdAT" : "IDAT", data);
  }
  put_chunk(out, "IEND", {});
  return out;
}

}  // namespace colift::picture
