#include "hal/drivers/recorded/cloud_files/pcd.hpp"

#include <fmt/format.h>
#include <liblzf/lzf.h>

#include <bit>
#include <cstring>
#include <limits>
#include <type_traits>

#include "hal/drivers/recorded/cloud_files/pcd_header.hpp"

namespace colift::hal {
namespace {

// Column types and byte order: PCD is written in the order of the writing machine, in practice little-endian.
static_assert(std::endian::native == std::endian::little);

class DataParser {
 public:
  DataParser(Bytes bytes, const std::string& name, PcdHeader header)
      : bytes_(bytes),
        name_(name),
        header_(std::move(header)),
        scanner_(bytes, header_.data_offset, header_.data_line) {}

  Result<PointFile> run() {
    if (header_.data == PcdHeader::Data::Ascii) return read_ascii();
    if (header_.data == PcdHeader::Data::Binary) return read_binary();
    return read_compressed();
  }

 private:
  [[nodiscard]] tl::unexpected<Error> at_line(std::size_t line, std::string detail) const {
    return failure(ErrorCode::BadInput, fmt::format("{}:{}", name_, line), std::move(detail));
  }
  [[nodiscard]] tl::unexpected<Error> at_byte(std::size_t byte, std::string detail) const {
    return failure(ErrorCode::BadInput, fmt::format("{}: byte {}", name_, byte), std::move(detail));
  }

  [[nodiscard]] PointFile empty_points() const {
    PointFile out;
    out.width = header_.width;
    out.height = header_.height;
    out.viewpoint = header_.viewpoint;
    const auto n = static_cast<std::size_t>(header_.points);
    out.x.resize(n);
    out.y.resize(n);
    out.z.resize(n);
    if (header_.colour) out.rgb.resize(3 * n);
    return out;
  }

  static void put_colour(PointFile& out, std::size_t i, std::uint32_t packed) {
    out.rgb[3 * i] = static_cast<std::uint8_t>(packed >> 16);
    out.rgb[3 * i + 1] = static_cast<std::uint8_t>(packed >> 8);
    out.rgb[3 * i + 2] = static_cast<std::uint8_t>(packed);
  }

  Result<PointFile> read_ascii() {
    // a value and the white space after it take two bytes at least; the last one may end the file
    const std::uint64_t room = (bytes_.size() - header_.data_offset + 1) / 2;
    if (header_.row_values > room || header_.points > room / header_.row_values) {
      return failure(
          ErrorCode::BadInput, name_ + ": header POINTS",
          fmt::format(
              "POINTS is {} with {} values each, more than the {} bytes after the header can hold: the "
              "file is cut off or the header is wrong",
              header_.points, header_.row_values, bytes_.size() - header_.data_offset));
    }
    // what to do with each value of a line: index of the field that it belongs to
    std::vector<std::size_t> slot;
    slot.reserve(static_cast<std::size_t>(header_.row_values));
    for (std::size_t f = 0; f < header_.fields.size(); ++f) {
      slot.insert(slot.end(), static_cast<std::size_t>(header_.fields[f].count), f);
    }
    PointFile out = empty_points();
    const auto n = static_cast<std::size_t>(header_.points);
    std::size_t i = 0;
    for (; i < n;) {
      const auto text = scanner_.next();
      if (!text) break;
      std::string_view rest = *text;
      std::string_view word = next_word(rest);
      if (word.empty()) continue;
      std::size_t values = 0;
      for (; !word.empty(); word = next_word(rest), ++values) {
        if (values >= slot.size()) break;
        if (auto ok = put_value(out, i, slot[values], word); !ok) return tl::unexpected(ok.error());
      }
      if (values != slot.size() || !word.empty()) {
        return at_line(scanner_.line(),
                       fmt::format("has {} values; expected {}",
                                   word.empty() ? fmt::to_string(values) : "too many", slot.size()));
      }
      ++i;
    }
    if (i != n) return at_line(scanner_.line(), fmt::format("the file ends after {} of {} points", i, n));
    return out;
  }

  Result<> put_value(PointFile& out, std::size_t i, std::size_t field, std::string_view word) const {
    if (field == header_.colour) {
      const bool real = header_.fields[field].type == 'F';
      const auto number = to_number(word);
      if (!number)
        return at_line(scanner_.line(), fmt::format("found {} where a colour was expected", shown(word)));
      // a colour typed F is a float whose bits are the colour; otherwise it is the number itself
      std::uint32_t packed = 0;
      if (real) {
        packed = std::bit_cast<std::uint32_t>(to_coordinate(*number));
      } else if (std::isfinite(*number) && std::abs(*number) < 4294967296.0) {
        packed = static_cast<std::uint32_t>(static_cast<std::int64_t>(*number));
      }
      put_colour(out, i, packed);
      return {};
    }
    std::vector<float>* const column = field == header_.x   ? &out.x
                                       : field == header_.y ? &out.y
                                       : field == header_.z ? &out.z
                                                            : nullptr;
    if (column == nullptr) return {};
    const auto number = to_number(word);
    if (!number) {
      return at_line(scanner_.line(), fmt::format("found {} where field {} needs a number", shown(word),
                                                  header_.fields[field].name));
    }
    (*column)[i] = to_coordinate(*number);
    return {};
  }

  Result<PointFile> read_binary() {
    const std::uint64_t rest = bytes_.size() - header_.data_offset;
    if (header_.points > rest / header_.row_bytes) {
      return at_byte(bytes_.size(),
                     fmt::format("{} bytes follow the header; expected {} points of {} bytes = {}", rest,
                                 header_.points, header_.row_bytes, header_.points * header_.row_bytes));
    }
    return take_columns(bytes_.data() + header_.data_offset, /*planar=*/false);
  }

  Result<PointFile> read_compressed() {
    const std::size_t start = header_.data_offset;
    if (bytes_.size() - start < 8)
      return at_byte(bytes_.size(), "the file ends before the two sizes of the compressed data");
    std::uint32_t packed = 0, full = 0;
    std::memcpy(&packed, bytes_.data() + start, 4);
    std::memcpy(&full, bytes_.data() + start + 4, 4);
    const std::uint64_t rest = bytes_.size() - start - 8;
    if (packed > rest) {
      return at_byte(bytes_.size(),
                     fmt::format("{} bytes of compressed data follow; expected {}", rest, packed));
    }
    // divided, not multiplied: points and row size come from the header and may be anything
    if (header_.points != full / header_.row_bytes || full % header_.row_bytes != 0) {
      return at_byte(start + 4, fmt::format("the data expand to {} bytes; expected {} points of {} bytes",
                                            full, header_.points, header_.row_bytes));
    }
    // three bytes expand to 264 at most
    if (full / 88 > packed) {
      return at_byte(start, fmt::format("{} compressed bytes cannot expand to {}", packed, full));
    }
    std::vector<std::byte> columns(full);
    // takes all of its input or fails; of no input it would read a byte all the same
    if (packed == 0 || lzf_decompress(bytes_.data() + start + 8, packed, columns.data(), full) != full)
      return at_byte(start + 8,
                     fmt::format("the compressed data are damaged: they do not expand to {} bytes", full));
    return take_columns(columns.data(), /*planar=*/true);
  }

  // Binary files hold point after point; compressed ones hold all of x, then all of y, and so on.
  [[nodiscard]] PointFile take_columns(const std::byte* data, bool planar) const {
    PointFile out = empty_points();
    std::size_t offset = 0;
    for (std::size_t f = 0; f < header_.fields.size(); ++f) {
      const PcdField& field = header_.fields[f];
      const auto bytes = static_cast<std::size_t>(field.size * field.count);
      const std::byte* const first = data + offset;
      const std::size_t stride = planar ? bytes : static_cast<std::size_t>(header_.row_bytes);
      if (f == header_.x) take_column(first, stride, field, out.x);
      if (f == header_.y) take_column(first, stride, field, out.y);
      if (f == header_.z) take_column(first, stride, field, out.z);
      if (f == header_.colour) {
        for (std::size_t i = 0; i < out.size(); ++i) {
          std::uint32_t packed = 0;
          std::memcpy(&packed, first + i * stride, 4);
          put_colour(out, i, packed);
        }
      }
      offset += planar ? bytes * out.size() : bytes;
    }
    return out;
  }

  template <class T>
  static void take_numbers(const std::byte* first, std::size_t stride, std::vector<float>& out) {
    for (std::size_t i = 0; i < out.size(); ++i) {
      T value;
      std::memcpy(&value, first + i * stride, sizeof(T));
      if constexpr (std::is_same_v<T, double>) {
        out[i] = to_coordinate(value);
      } else {
        out[i] = static_cast<float>(value);
      }
    }
  }

  static void take_column(const std::byte* first, std::size_t stride, const PcdField& field,
                          std::vector<float>& out) {
    const auto size = field.size;
    if (field.type == 'F')
      return size == 4 ? take_numbers<float>(first, stride, out) : take_numbers<double>(first, stride, out);
    const bool is_signed = field.type == 'I';
    if (size == 1)
      return is_signed ? take_numbers<std::int8_t>(first, stride, out)
                       : take_numbers<std::uint8_t>(first, stride, out);
    if (size == 2)
      return is_signed ? take_numbers<std::int16_t>(first, stride, out)
                       : take_numbers<std::uint16_t>(first, stride, out);
    if (size == 4)
      return is_signed ? take_numbers<std::int32_t>(first, stride, out)
                       : take_numbers<std::uint32_t>(first, stride, out);
    return is_signed ? take_numbers<std::int64_t>(first, stride, out)
                     : take_numbers<std::uint64_t>(first, stride, out);
  }

  Bytes bytes_;
  const std::string& name_;
  PcdHeader header_;
  LineScanner scanner_;
};

}  // namespace

Result<PointFile> parse_pcd(Bytes bytes, const std::string& name) {
  return parse_pcd_header(bytes, name).and_then([&](PcdHeader&& header) {
    return DataParser(bytes, name, std::move(header)).run();
  });
}

}  // namespace colift::hal
