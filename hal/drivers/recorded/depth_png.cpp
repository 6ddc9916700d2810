#include "hal/drivers/recorded/depth_png.hpp"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <csetjmp>
#include <cstring>
#include <limits>

namespace colift::hal {
namespace {

constexpr png_uint_32 kLargestSide = 8192;

struct Source {
  Bytes bytes;
  std::size_t offset = 0;
  char reason[160] = "";  // plain array: nothing may be destroyed when libpng jumps out
};

void read_bytes(png_structp png, png_bytep out, png_size_t count) {
  auto* const source = static_cast<Source*>(png_get_io_ptr(png));
  if (count > source->bytes.size() - source->offset) png_error(png, "the file ends too early");
  std::memcpy(out, source->bytes.data() + source->offset, count);
  source->offset += count;
}

void keep_reason(png_structp png, png_const_charp reason) {
  auto* const source = static_cast<Source*>(png_get_error_ptr(png));
  std::strncpy(source->reason, reason, sizeof(source->reason) - 1);
  std::longjmp(png_jmpbuf(png), 1);
}

void ignore_warning(png_structp, png_const_charp) {}

const char* kind_of(int colour_type) {
  switch (colour_type) {
    case PNG_COLOR_TYPE_GRAY:
      return "grey";
    case PNG_COLOR_TYPE_GRAY_ALPHA:
      return "grey with transparency";
    case PNG_COLOR_TYPE_PALETTE:
      return "palette colour";
    case PNG_COLOR_TYPE_RGB:
      return "colour";
    case PNG_COLOR_TYPE_RGB_ALPHA:
      return "colour with transparency";
    default:
      return "of unknown colour";
  }
}

std::uint32_t big_endian(Bytes four) {
  std::uint32_t value = 0;
  for (const std::byte b : four) value = (value << 8) | std::to_integer<std::uint32_t>(b);
  return value;
}

struct Image {
  png_structp png = nullptr;
  png_infop info = nullptr;
  png_uint_32 width = 0, height = 0;
  int bit_depth = 0, colour_type = 0;

  explicit Image(Source& source)
      : png(png_create_read_struct(PNG_LIBPNG_VER_STRING, &source, keep_reason, ignore_warning)) {
    if (png != nullptr) info = png_create_info_struct(png);
  }
  ~Image() { png_destroy_read_struct(&png, &info, nullptr); }
  Image(const Image&) = delete;
  Image& operator=(const Image&) = delete;
};

// The two functions that libpng may jump out of hold no object with a destructor.
bool read_header(Image& image, Source& source) {
  if (setjmp(png_jmpbuf(image.png)) != 0) return false;
  png_set_read_fn(image.png, &source, read_bytes);
  png_set_user_limits(image.png, kLargestSide, kLargestSide);
#ifdef FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION
  png_set_crc_action(image.png, PNG_CRC_QUIET_USE,
                     PNG_CRC_QUIET_USE);  // else every mutation ends at a checksum
#endif
  png_read_info(image.png, image.info);
  png_get_IHDR(image.png, image.info, &image.width, &image.height, &image.bit_depth, &image.colour_type,
               nullptr, nullptr, nullptr);
  return true;
}

bool read_pixels(Image& image, png_bytep data, std::size_t row_bytes) {
  if (setjmp(png_jmpbuf(image.png)) != 0) return false;
  const int passes = png_set_interlace_handling(image.png);
  png_read_update_info(image.png, image.info);
  if (png_get_rowbytes(image.png, image.info) != row_bytes)
    png_error(image.png, "rows have an unexpected length");
  for (int pass = 0; pass < passes; ++pass) {
    for (png_uint_32 row = 0; row < image.height; ++row)
      png_read_row(image.png, data + row * row_bytes, nullptr);
  }
  png_read_end(image.png, nullptr);
  return true;
}

}  // namespace

Result<DepthImage> parse_depth_png(Bytes bytes, const std::string& name, double depth_scale_m) {
  constexpr std::size_t kSignature = 8;
  if (bytes.size() < kSignature ||
      png_sig_cmp(reinterpret_cast<png_const_bytep>(bytes.data()), 0, kSignature) != 0) {
    return failure(ErrorCode::BadInput, name + ": byte 0",
                   fmt::format("found {}; expected the signature of a PNG image",
                               shown(as_text(bytes.first(std::min(kSignature, bytes.size()))))));
  }
  // libpng calls an impossible size "invalid data" only
  if (bytes.size() >= 24) {
    const std::uint32_t width = big_endian(bytes.subspan(16, 4)), height = big_endian(bytes.subspan(20, 4));
    if (width == 0 || height == 0 || width > kLargestSide || height > kLargestSide) {
      return failure(ErrorCode::BadInput, name + ": header",
                     fmt::format("the header says {} x {} pixels; expected 1 x 1 to {} x {}", width, height,
                                 kLargestSide, kLargestSide));
    }
  }
  Source source{bytes};
  const auto damaged = [&] {
    return failure(ErrorCode::BadInput, fmt::format("{}: byte {}", name, source.offset),
                   fmt::format("the PNG image is damaged: {}", source.reason));
  };
  Image image(source);
  if (image.png == nullptr || image.info == nullptr) {
    return failure(ErrorCode::BadInput, name,
                   "libpng could not be started (out of memory or another version)");
  }
  if (!read_header(image, source)) return damaged();
  if (image.bit_depth != 16 || image.colour_type != PNG_COLOR_TYPE_GRAY) {
    return failure(ErrorCode::BadInput, name + ": header",
                   fmt::format("the image is {}-bit {}; a depth image is 16-bit grey", image.bit_depth,
                               kind_of(image.colour_type)));
  }
  // deflate packs at most 1032 to 1, so a small file cannot hold a huge image
  const std::size_t row_bytes = std::size_t{image.width} * 2;
  if (row_bytes * image.height / 1040 > bytes.size()) {
    return failure(ErrorCode::BadInput, name + ": header",
                   fmt::format("the header says {} x {} pixels, more than {} bytes can hold", image.width,
                               image.height, bytes.size()));
  }
  std::vector<png_byte> pixels(row_bytes * image.height);
  if (!read_pixels(image, pixels.data(), row_bytes)) return damaged();

  DepthImage out;
  out.width = static_cast<int>(image.width);
  out.height = static_cast<int>(image.height);
  out.depth_m.resize(pixels.size() / 2);
  for (std::size_t i = 0; i < out.depth_m.size(); ++i) {
    const int units = (pixels[2 * i] << 8) | pixels[2 * i + 1];
    out.depth_m[i] =
        units == 0 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(units * depth_scale_m);
  }
  return out;
}

}  // namespace colift::hal
