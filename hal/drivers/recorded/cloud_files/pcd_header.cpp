#include "hal/drivers/recorded/cloud_files/pcd_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace colift::hal {
namespace {

using Data = PcdHeader::Data;

struct HeaderLine {
  std::size_t line = 0;  // 0: the key did not occur
  std::vector<std::string_view> words;
};

constexpr std::array<std::string_view, 10> kKeys = {"VERSION", "FIELDS", "SIZE",      "TYPE",   "COUNT",
                                                    "WIDTH",   "HEIGHT", "VIEWPOINT", "POINTS", "DATA"};
enum Key { Version, Fields, Size, Type, Count, Width, Height, Viewpoint, Points, DataKey };

class HeaderParser {
 public:
  HeaderParser(Bytes bytes, const std::string& name) : name_(name), scanner_(bytes) {}

  Result<PcdHeader> run() {
    if (auto ok = collect_lines(); !ok) return tl::unexpected(ok.error());
    if (auto ok = read_fields(); !ok) return tl::unexpected(ok.error());
    if (auto ok = read_size(); !ok) return tl::unexpected(ok.error());
    if (auto ok = read_viewpoint(); !ok) return tl::unexpected(ok.error());
    return std::move(header_);
  }

 private:
  [[nodiscard]] tl::unexpected<Error> at_line(std::size_t line, std::string detail) const {
    return failure(ErrorCode::BadInput, fmt::format("{}:{}", name_, line), std::move(detail));
  }
  [[nodiscard]] tl::unexpected<Error> at_key(Key key, const std::string& detail) const {
    return failure(ErrorCode::BadInput, fmt::format("{}: header {}", name_, kKeys[key]),
                   fmt::format("{} {}", kKeys[key], detail));
  }
  [[nodiscard]] const HeaderLine& line(Key key) const { return lines_[key]; }
  [[nodiscard]] bool given(Key key) const { return line(key).line != 0; }

  Result<> collect_lines() {
    while (const auto text = scanner_.next()) {
      std::string_view rest = *text;
      std::string_view key = next_word(rest);
      if (key.empty() || key.front() == '#') continue;
      if (key == "COLUMNS") key = "FIELDS";  // the name before version .5
      const auto found = std::find(kKeys.begin(), kKeys.end(), key);
      if (found == kKeys.end()) {
        return at_line(
            scanner_.line(),
            fmt::format("found {} where a PCD header line (VERSION, FIELDS, ..., DATA) was expected",
                        shown(*text)));
      }
      HeaderLine& entry = lines_[static_cast<std::size_t>(found - kKeys.begin())];
      if (entry.line != 0) {
        return at_line(scanner_.line(),
                       fmt::format("{} is given a second time, first in line {}", key, entry.line));
      }
      entry.line = scanner_.line();
      for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest)) {
        entry.words.push_back(word);
      }
      if (key == "DATA") return read_data_kind();
    }
    return at_line(scanner_.line(), "the file ends inside the header: no line DATA was found");
  }

  Result<> read_data_kind() {
    const auto& words = line(DataKey).words;
    const std::string_view kind = words.empty() ? std::string_view{} : words.front();
    if (kind == "ascii") {
      header_.data = Data::Ascii;
    } else if (kind == "binary") {
      header_.data = Data::Binary;
    } else if (kind == "binary_compressed") {
      header_.data = Data::Compressed;
    } else {
      return at_line(scanner_.line(),
                     fmt::format("DATA is {}; expected ascii, binary or binary_compressed", shown(kind)));
    }
    header_.data_offset = scanner_.offset();
    header_.data_line = scanner_.line();
    return {};
  }

  Result<> read_fields() {
    if (given(Version)) {
      const auto& words = line(Version).words;
      const auto version = words.empty() ? std::nullopt : to_number(words.front());
      if (!version || !(*version >= 0.5 - 1e-9 && *version <= 0.7 + 1e-9)) {
        return at_key(Version,
                      fmt::format("is {}; expected .5, .6 or .7", shown(words.empty() ? "" : words.front())));
      }
    }
    if (!given(Fields) || line(Fields).words.empty())
      return at_key(Fields, "is missing; expected at least x y z");
    for (const std::string_view name : line(Fields).words) header_.fields.push_back({name});
    const std::size_t n = header_.fields.size();
    for (const Key key : {Size, Type, Count}) {
      if (given(key) && line(key).words.size() != n) {
        return at_key(key,
                      fmt::format("has {} entries; expected {} as in FIELDS", line(key).words.size(), n));
      }
      // text needs no sizes, bytes cannot be cut without them
      if (!given(key) && key != Count && header_.data != Data::Ascii) return at_key(key, "is missing");
    }
    // larger than any field and small enough that products of two stay inside 64 bits
    constexpr std::uint64_t kLargest = std::uint64_t{1} << 20;
    for (std::size_t i = 0; i < n; ++i) {
      PcdField& field = header_.fields[i];
      const auto positive = [&](Key key, std::uint64_t& value) -> Result<> {
        if (!given(key)) return {};
        const auto number = to_count(line(key).words[i]);
        if (!number || *number == 0 || *number > kLargest) {
          return at_key(key, fmt::format("of field {} is {}; expected 1 to {}", shown(field.name),
                                         shown(line(key).words[i]), kLargest));
        }
        value = *number;
        return {};
      };
      if (auto ok = positive(Size, field.size); !ok) return ok;
      if (auto ok = positive(Count, field.count); !ok) return ok;
      if (given(Type)) {
        const std::string_view type = line(Type).words[i];
        if (type != "F" && type != "I" && type != "U") {
          return at_key(Type,
                        fmt::format("of field {} is {}; expected F, I or U", shown(field.name), shown(type)));
        }
        field.type = type.front();
      }
      header_.row_bytes += field.size * field.count;
      header_.row_values += field.count;
      if (auto ok = take_role(i); !ok) return ok;
    }
    if (header_.row_bytes > std::numeric_limits<std::uint32_t>::max()) {
      return at_key(Size, fmt::format("and COUNT give {} bytes per point, more than any file holds",
                                      header_.row_bytes));
    }
    for (const auto& [index, name] : {std::pair{x_, 'x'}, {y_, 'y'}, {z_, 'z'}}) {
      if (!index) return at_key(Fields, fmt::format("has no field {}; expected x, y and z", name));
    }
    header_.x = *x_;
    header_.y = *y_;
    header_.z = *z_;
    return {};
  }

  // Remembers where x, y, z and the colour lie, and refuses types that they cannot have.
  Result<> take_role(std::size_t index) {
    const PcdField& field = header_.fields[index];
    const bool colour = field.name == "rgb" || field.name == "rgba";
    std::optional<std::size_t>* const role = field.name == "x"   ? &x_
                                             : field.name == "y" ? &y_
                                             : field.name == "z" ? &z_
                                             : colour            ? &header_.colour
                                                                 : nullptr;
    if (role == nullptr) return {};
    if (role->has_value() && !colour) return at_key(Fields, fmt::format("names {} twice", field.name));
    const bool number = field.type == 'F'
                            ? field.size == 4 || field.size == 8
                            : field.size == 1 || field.size == 2 || field.size == 4 || field.size == 8;
    if (field.count != 1 || !number || (colour && field.size != 4)) {
      if (colour) return {};  // a colour of another kind is not needed
      return at_key(Size, fmt::format("of field {} is {} x {} bytes of type {}; expected one number",
                                      field.name, field.count, field.size, field.type));
    }
    *role = index;
    return {};
  }

  Result<> read_size() {
    std::optional<std::uint64_t> width, height, points;
    for (const auto& [key, value] : {std::pair{Width, &width}, {Height, &height}, {Points, &points}}) {
      if (!given(key)) continue;
      const std::string_view word = line(key).words.empty() ? std::string_view{} : line(key).words.front();
      *value = to_count(word);
      if (!value->has_value()) return at_key(key, fmt::format("is {}; expected a whole number", shown(word)));
      if (**value == 0) return at_key(key, "is 0: the file holds no points");
      if (**value > static_cast<std::uint64_t>(std::numeric_limits<int>::max())) {
        return at_key(key, fmt::format("is {}, more than any file holds (at most {})", **value,
                                       std::numeric_limits<int>::max()));
      }
    }
    if (!width && !points) return at_key(Points, "is missing, and WIDTH too");
    if (!width) width = height ? *points / *height : *points;
    if (!height) height = points && *points % *width == 0 ? *points / *width : 1;
    if (!points) points = *width * *height;
    if (*width * *height != *points) {
      return at_key(Points, fmt::format("is {}, but WIDTH {} x HEIGHT {} is {}", *points, *width, *height,
                                        *width * *height));
    }
    header_.width = static_cast<int>(*width);
    header_.height = static_cast<int>(*height);
    header_.points = *points;
    return {};
  }

  Result<> read_viewpoint() {
    if (!given(Viewpoint)) return {};
    const auto& words = line(Viewpoint).words;
    if (words.size() != 7)
      return at_key(Viewpoint, fmt::format("has {} numbers; expected 7 (x y z qw qx qy qz)", words.size()));
    std::array<double, 7> v{};
    for (std::size_t i = 0; i < 7; ++i) {
      const auto number = to_number(words[i]);
      if (!number || !std::isfinite(*number) || std::abs(*number) > 1e9) {
        return at_key(Viewpoint, fmt::format("holds {}; expected a finite number", shown(words[i])));
      }
      v[i] = *number;
    }
    Eigen::Quaterniond q(v[3], v[4], v[5], v[6]);
    if (q.norm() < 1e-6) return at_key(Viewpoint, "has a quaternion of length 0; expected length 1");
    header_.viewpoint.linear() = q.normalized().toRotationMatrix();
    header_.viewpoint.translation() = Vec3(v[0], v[1], v[2]);
    return {};
  }

  const std::string& name_;
  LineScanner scanner_;
  std::array<HeaderLine, kKeys.size()> lines_;
  std::optional<std::size_t> x_, y_, z_;
  PcdHeader header_;
};

}  // namespace

Result<PcdHeader> parse_pcd_header(Bytes bytes, const std::string& name) {
  return HeaderParser(bytes, name).run();
}

}  // namespace colift::hal
