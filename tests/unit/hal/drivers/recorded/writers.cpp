#include "writers.hpp"

#include <fmt/format.h>
#include <liblzf/lzf.h>
#include <png.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <stdexcept>

namespace colift::hal::test {
namespace {

template <class T>
void put(std::string& out, T value, bool big = false) {
  std::array<char, sizeof(T)> raw{};
  std::memcpy(raw.data(), &value, sizeof(T));
  if (big) std::reverse(raw.begin(), raw.end());
  out.append(raw.data(), raw.size());
}

std::uint32_t packed(const PointFile& p, std::size_t i) {
  return (std::uint32_t{p.rgb[3 * i]} << 16) | (std::uint32_t{p.rgb[3 * i + 1]} << 8) | p.rgb[3 * i + 2];
}

void put_typed(std::string& out, const Column& column, double value) {
  if (column.type == 'F') return column.size == 4 ? put(out, static_cast<float>(value)) : put(out, value);
  const bool whole = std::isfinite(value);
  const auto number = whole ? static_cast<std::int64_t>(std::llround(value)) : 0;
  if (column.size == 1) return put(out, static_cast<std::int8_t>(number));
  if (column.size == 2) return put(out, static_cast<std::int16_t>(number));
  if (column.size == 4) return put(out, static_cast<std::int32_t>(number));
  put(out, number);
}

void put_column(std::string& out, const PointFile& p, std::size_t i, const Column& column, bool ascii) {
  const bool colour = column.name == "rgb" || column.name == "rgba";
  if (colour && !p.rgb.empty()) {
    const std::uint32_t bits = packed(p, i);
    if (!ascii) return put(out, bits);
    out += column.type == 'F' ? fmt::format("{} ", std::bit_cast<float>(bits)) : fmt::format("{} ", bits);
    return;
  }
  const double value = column.name == "x"   ? p.x[i]
                       : column.name == "y" ? p.y[i]
                       : column.name == "z" ? p.z[i]
                                            : 7.0;
  for (int c = 0; c < column.count; ++c) {
    if (ascii) {
      out += column.type == 'F' ? fmt::format("{} ", value) : fmt::format("{} ", std::llround(value));
    } else {
      put_typed(out, column, value);
    }
  }
}

void write_to(png_structp png, png_bytep data, png_size_t count) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(data), count);
}

}  // namespace

std::vector<Column> plain_columns(const PointFile& points) {
  std::vector<Column> out = {{"x"}, {"y"}, {"z"}};
  if (!points.rgb.empty()) out.push_back({"rgb", 'U'});
  return out;
}

std::string pcd(const PointFile& points, PcdData data) {
  return pcd(points, data, plain_columns(points));
}

std::string pcd(const PointFile& points, PcdData data, const std::vector<Column>& columns) {
  std::string fields, sizes, types, counts;
  for (const Column& c : columns) {
    fields += " " + c.name;
    sizes += fmt::format(" {}", c.size);
    types += fmt::format(" {}", c.type);
    counts += fmt::format(" {}", c.count);
  }
  const auto t = points.viewpoint.translation();
  const Eigen::Quaterniond q(points.viewpoint.linear());
  std::string out = fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS{}\nSIZE{}\nTYPE{}\nCOUNT{}\nWIDTH "
      "{}\nHEIGHT {}\n"
      "VIEWPOINT {} {} {} {} {} {} {}\nPOINTS {}\nDATA {}\n",
      fields, sizes, types, counts, points.width, points.height, t.x(), t.y(), t.z(), q.w(), q.x(), q.y(),
      q.z(), points.size(),
      data == PcdData::Ascii    ? "ascii"
      : data == PcdData::Binary ? "binary"
                                : "binary_compressed");
  std::string body;
  if (data == PcdData::Compressed) {
    for (const Column& c : columns) {
      for (std::size_t i = 0; i < points.size(); ++i) put_column(body, points, i, c, false);
    }
    std::string small(body.size() + body.size() / 16 + 64, '\0');
    small.resize(lzf_compress(body.data(), static_cast<unsigned>(body.size()), small.data(),
                              static_cast<unsigned>(small.size())));
    put(out, static_cast<std::uint32_t>(small.size()));
    put(out, static_cast<std::uint32_t>(body.size()));
    return out + small;
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (const Column& c : columns) put_column(body, points, i, c, data == PcdData::Ascii);
    if (data == PcdData::Ascii) body.back() = '\n';
  }
  return out + body;
}

std::string ply(const PointFile& points, PlyData data) {
  const bool ascii = data == PlyData::Ascii, big = data == PlyData::Big, coloured = !points.rgb.empty();
  std::string out = fmt::format(
      "ply\nformat {} 1.0\ncomment a list before, a list after\nelement polyline 2\nproperty float "
      "width\nproperty list uchar "
      "short indices\nelement vertex {}\nproperty float x\nproperty list ushort double echoes\nproperty "
      "float y\nproperty "
      "float z\n{}element face 1\nproperty list uchar int vertex_indices\nend_header\n",
      ascii ? "ascii"
      : big ? "binary_big_endian"
            : "binary_little_endian",
      points.size(), coloured ? "property uchar red\nproperty uchar green\nproperty uchar blue\n" : "");
  const auto value = [&](auto v) {
    if (ascii) {
      out += fmt::format("{} ", +v);
    } else {
      put(out, v, big);
    }
  };
  const auto end_line = [&] {
    if (ascii) out += '\n';
  };
  for (int line = 0; line < 2; ++line) {
    value(1.5f);
    value(std::uint8_t{3});
    for (std::int16_t k = 0; k < 3; ++k) value(k);
    end_line();
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    value(points.x[i]);
    const auto echoes = static_cast<std::uint16_t>(i % 3);
    value(echoes);
    for (int k = 0; k < echoes; ++k) value(0.25);
    value(points.y[i]);
    value(points.z[i]);
    for (std::size_t c = 0; coloured && c < 3; ++c) value(points.rgb[3 * i + c]);
    end_line();
  }
  value(std::uint8_t{0});
  end_line();
  return out;
}

std::string png(int width, int height, int bits, bool colour, bool interlaced,
                const std::vector<std::uint16_t>& values) {
  std::string out;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(png, &out, write_to, nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width), static_cast<png_uint_32>(height), bits,
               colour ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_GRAY,
               interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  std::vector<png_byte> bytes;
  for (const std::uint16_t v : values) {
    if (bits == 16) bytes.push_back(static_cast<png_byte>(v >> 8));
    bytes.push_back(static_cast<png_byte>(v & 255));
  }
  const std::size_t row = bytes.size() / static_cast<std::size_t>(height);
  const int passes = png_set_interlace_handling(png);
  for (int pass = 0; pass < passes; ++pass) {
    for (int v = 0; v < height; ++v) png_write_row(png, bytes.data() + static_cast<std::size_t>(v) * row);
  }
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return out;
}

PointFile random_points(std::uint32_t seed, int width, int height, bool coloured) {
  std::mt19937 random(seed);
  const auto unit = [&] { return static_cast<float>(random()) / 4294967296.0f; };
  PointFile out;
  out.width = width;
  out.height = height;
  const auto n = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  for (std::size_t i = 0; i < n; ++i) {
    const bool hole = random() % 10 == 0;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    out.x.push_back(hole ? nan : 4.0f * unit() - 2.0f);
    out.y.push_back(hole ? nan : 4.0f * unit() - 2.0f);
    out.z.push_back(hole ? nan : 4.0f * unit() - 2.0f);
    for (int c = 0; coloured && c < 3; ++c) out.rgb.push_back(static_cast<std::uint8_t>(random()));
  }
  return out;
}

std::filesystem::path data(const std::string& name) {
  return std::filesystem::path(COLIFT_TEST_DATA) / name;
}

bool same(float a, float b) {
  return a == b || (!std::isfinite(a) && !std::isfinite(b));
}

bool same(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() &&
         std::equal(a.begin(), a.end(), b.begin(), [](float p, float q) { return same(p, q); });
}

}  // namespace colift::hal::test
