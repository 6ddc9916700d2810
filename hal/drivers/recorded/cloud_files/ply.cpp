#include "hal/drivers/recorded/cloud_files/ply.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <map>

#include "hal/drivers/recorded/cloud_files/ply_header.hpp"

namespace colift::hal {
namespace {

static_assert(std::endian::native == std::endian::little);

// Values one after the other, whatever the encoding.
class Values {
 public:
  Values(Bytes bytes, std::size_t offset, std::size_t line, PlyEncoding encoding)
      : bytes_(bytes), offset_(offset), line_(line), encoding_(encoding) {}

  // Nothing at the end of the file, and where a word is no number.
  std::optional<double> next(PlyType type) {
    if (encoding_ == PlyEncoding::Ascii) {
      const std::string_view found = word();
      if (found.empty()) return std::nullopt;
      const auto number = to_number(found);
      if (!number) wrong_ = found;
      return number;
    }
    const std::size_t size = bytes_of(type);
    if (left() < size) return std::nullopt;
    std::array<std::byte, 8> raw{};
    std::memcpy(raw.data(), bytes_.data() + offset_, size);
    if (encoding_ == PlyEncoding::Big)
      std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(size));
    offset_ += size;
    switch (type) {
      case PlyType::Int8:
        return as<std::int8_t>(raw);
      case PlyType::Uint8:
        return as<std::uint8_t>(raw);
      case PlyType::Int16:
        return as<std::int16_t>(raw);
      case PlyType::Uint16:
        return as<std::uint16_t>(raw);
      case PlyType::Int32:
        return as<std::int32_t>(raw);
      case PlyType::Uint32:
        return as<std::uint32_t>(raw);
      case PlyType::Float32:
        return as<float>(raw);
      case PlyType::Float64:
        return as<double>(raw);
    }
    return std::nullopt;
  }

  // Passes over values that nobody needs; false when the file ends first.
  bool skip(PlyType type, std::uint64_t count) {
    if (encoding_ == PlyEncoding::Ascii) {
      for (; count > 0; --count) {
        if (word().empty()) return false;
      }
      return true;
    }
    if (count > left() / bytes_of(type)) return false;
    offset_ += static_cast<std::size_t>(count) * bytes_of(type);
    return true;
  }

  [[nodiscard]] std::size_t left() const { return bytes_.size() - offset_; }
  [[nodiscard]] std::string place() const {
    return encoding_ == PlyEncoding::Ascii ? fmt::format("{}", line_) : fmt::format(" byte {}", offset_);
  }
  [[nodiscard]] const std::optional<std::string_view>& wrong() const { return wrong_; }

 private:
  template <class T>
  static double as(const std::array<std::byte, 8>& raw) {
    T value;
    std::memcpy(&value, raw.data(), sizeof(T));
    return static_cast<double>(value);
  }

  std::string_view word() {
    const std::string_view text = as_text(bytes_);
    while (offset_ < text.size() && static_cast<unsigned char>(text[offset_]) <= ' ') {
      if (text[offset_++] == '\n') ++line_;
    }
    const std::size_t begin = offset_;
    while (offset_ < text.size() && static_cast<unsigned char>(text[offset_]) > ' ') ++offset_;
    return text.substr(begin, offset_ - begin);
  }

  Bytes bytes_;
  std::size_t offset_;
  std::size_t line_;
  PlyEncoding encoding_;
  std::optional<std::string_view> wrong_;
};

class Parser {
 public:
  Parser(Bytes bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  Result<PointFile> run() {
    auto header = parse_ply_header(bytes_, name_);
    if (!header) return tl::unexpected(header.error());
    encoding_ = header->encoding;
    elements_ = std::move(header->elements);
    columns_ = header->columns;
    rows_ = header->rows;
    const auto vertex = std::find_if(elements_.begin(), elements_.end(),
                                     [](const PlyElement& e) { return e.name == "vertex"; });
    if (vertex == elements_.end()) return header_error("the header has no element vertex");
    for (const char* axis : {"x", "y", "z"}) {
      if (!vertex->find(axis))
        return header_error(fmt::format("element vertex has no property {}; expected x, y and z", axis));
    }
    if (vertex->count == 0) return header_error("element vertex is 0: the file holds no points");

    Values values(bytes_, header->data_offset, header->data_line, encoding_);
    PointFile out;
    for (const PlyElement& element : elements_) {
      const bool is_vertex = &element == &*vertex;
      Result<> ok;
      if (is_vertex) {
        ok = read_vertices(element, values, out);
      } else if (element.name == "camera" && element.count == 1 && !element.has_lists()) {
        ok = read_camera(element, values);
      } else {
        ok = skip(element, values);
      }
      // what is broken behind the vertices does not matter
      if (!ok && out.x.empty()) return tl::unexpected(ok.error());
      if (!ok) break;
    }
    if (columns_ && rows_ && *columns_ * *rows_ == out.size()) {
      out.width = static_cast<int>(*columns_);
      out.height = static_cast<int>(*rows_);
    }
    out.viewpoint = viewpoint_;
    return out;
  }

 private:
  [[nodiscard]] tl::unexpected<Error> header_error(std::string detail) const {
    return failure(ErrorCode::BadInput, name_ + ": header", std::move(detail));
  }
  [[nodiscard]] tl::unexpected<Error> data_error(const Values& values, const PlyElement& element,
                                                 std::uint64_t i) const {
    if (values.wrong()) {
      return failure(
          ErrorCode::BadInput, name_ + ":" + values.place(),
          fmt::format("found {} in {} {}; expected a number", shown(*values.wrong()), element.name, i));
    }
    return failure(ErrorCode::BadInput, name_ + ":" + values.place(),
                   fmt::format("the file ends after {} of {} entries of element {}", i, element.count,
                               shown(element.name)));
  }

  // One record; `sink` is handed the index and the value of every scalar.
  template <class Sink>
  static bool read_record(const PlyElement& element, Values& values, Sink&& sink) {
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      if (property.length) {
        const auto length = values.next(*property.length);
        // a negative length is as good as the file's end: nothing after it can be trusted
        if (!length || !(*length >= 0.0 && *length <= 4294967295.0)) return false;
        if (!values.skip(property.type, static_cast<std::uint64_t>(*length))) return false;
      } else {
        const auto value = values.next(property.type);
        if (!value) return false;
        sink(p, *value);
      }
    }
    return true;
  }

  Result<> skip(const PlyElement& element, Values& values) const {
    if (element.properties.empty()) return {};
    if (!element.has_lists() && encoding_ != PlyEncoding::Ascii) {
      const std::uint64_t record = element.min_bytes(encoding_);
      if (element.count > values.left() / record) return data_error(values, element, values.left() / record);
      values.skip(PlyType::Uint8, element.count * record);
      return {};
    }
    for (std::uint64_t i = 0; i < element.count; ++i) {
      if (!read_record(element, values, [](std::size_t, double) {})) return data_error(values, element, i);
    }
    return {};
  }

  Result<> read_vertices(const PlyElement& element, Values& values, PointFile& out) const {
    // the last value of an ascii file needs no white space after it
    const std::uint64_t room = (values.left() + 1) / element.min_bytes(encoding_);
    constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<int>::max());
    if (element.count > std::min(room, kMost)) {
      return header_error(
          fmt::format("element vertex is {}, more than the {} bytes after the header can hold (at most {}): "
                      "the file is cut off or the header is wrong",
                      element.count, values.left(), std::min(room, kMost)));
    }
    const auto n = static_cast<std::size_t>(element.count);
    const std::size_t x = *element.find("x"), y = *element.find("y"), z = *element.find("z");
    std::array<std::optional<std::size_t>, 3> colour = {element.find("red"), element.find("green"),
                                                        element.find("blue")};
    if (!colour[0])
      colour = {element.find("diffuse_red"), element.find("diffuse_green"), element.find("diffuse_blue")};
    if (!colour[0]) colour = {element.find("r"), element.find("g"), element.find("b")};
    const bool coloured = colour[0] && colour[1] && colour[2];

    PointFile read;
    read.width = static_cast<int>(n);
    read.height = 1;
    read.x.resize(n);
    read.y.resize(n);
    read.z.resize(n);
    if (coloured) read.rgb.resize(3 * n);
    for (std::size_t i = 0; i < n; ++i) {
      const bool whole = read_record(element, values, [&](std::size_t p, double value) {
        if (p == x) read.x[i] = to_coordinate(value);
        if (p == y) read.y[i] = to_coordinate(value);
        if (p == z) read.z[i] = to_coordinate(value);
        for (std::size_t c = 0; coloured && c < 3; ++c) {
          if (p == *colour[c]) read.rgb[3 * i + c] = to_byte(value, element.properties[p].type);
        }
      });
      if (!whole) return data_error(values, element, i);
    }
    out = std::move(read);
    return {};
  }

  static std::uint8_t to_byte(double value, PlyType type) {
    if (type == PlyType::Float32 || type == PlyType::Float64) value *= 255.0;
    if (type == PlyType::Uint16) value /= 257.0;
    if (!(value > 0.0)) return 0;
    return static_cast<std::uint8_t>(std::min(255.0, value + 0.5));
  }

  Result<> read_camera(const PlyElement& element, Values& values) {
    std::map<std::string_view, double> camera;
    if (!read_record(element, values,
                     [&](std::size_t p, double value) { camera[element.properties[p].name] = value; })) {
      return data_error(values, element, 0);
    }
    const auto number = [&](const char* key) {
      const auto found = camera.find(key);
      return found == camera.end() ? std::numeric_limits<double>::quiet_NaN() : found->second;
    };
    const auto vector = [&](const std::string& prefix) {
      return Vec3(number((prefix + "x").c_str()), number((prefix + "y").c_str()),
                  number((prefix + "z").c_str()));
    };
    const Vec3 position = vector("view_p");
    if (position.allFinite() && position.norm() < 1e9) viewpoint_.translation() = position;
    Eigen::Matrix3d axes;
    axes << vector("x_axis"), vector("y_axis"), vector("z_axis");
    if (axes.allFinite() && (axes * axes.transpose()).isIdentity(1e-3) && axes.determinant() > 0.0)
      viewpoint_.linear() = axes;
    const double columns = number("viewportx"), rows = number("viewporty");
    if (columns >= 1.0 && columns <= 1e6 && rows >= 1.0 && rows <= 1e6 && !columns_ && !rows_) {
      columns_ = static_cast<std::uint64_t>(columns);
      rows_ = static_cast<std::uint64_t>(rows);
    }
    return {};
  }

  Bytes bytes_;
  const std::string& name_;
  PlyEncoding encoding_ = PlyEncoding::Ascii;
  std::vector<PlyElement> elements_;
  std::optional<std::uint64_t> columns_, rows_;
  Pose viewpoint_ = Pose::Identity();
};

}  // namespace

Result<PointFile> parse_ply(Bytes bytes, const std::string& name) {
  return Parser(bytes, name).run();
}

}  // namespace colift::hal
