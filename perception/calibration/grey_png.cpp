#include "perception/calibration/grey_png.hpp"

#include <png.h>

#include <cstring>
#include <fstream>
#include <vector>

namespace colift::perception {

hal::Result<> write_grey_png(const std::filesystem::path& file, int width, int height,
                             std::span<const std::uint16_t> values) {
  const auto refuse = [&](const char* why) {
    return hal::failure(hal::ErrorCode::BadInput, file.string(), why);
  };
  if (width <= 0 || height <= 0 ||
      values.size() != static_cast<std::size_t>(width) * static_cast<std::size_t>(height))
    return refuse("the image has another size than it says");
  png_image image;
  std::memset(&image, 0, sizeof image);
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = PNG_FORMAT_LINEAR_Y;  // 16 bits, written without any conversion
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::vector<char> bytes(size);
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, values.data(), 0, nullptr) == 0)
    return refuse(image.message);
  std::ofstream out(file, std::ios::binary | std::ios::trunc);
  out.write(bytes.data(), static_cast<std::streamsize>(size));
  out.close();
  if (!out) return refuse("the file cannot be written");
  return {};
}

}  // namespace colift::perception
