#include "hal/drivers/recorded/cloud_files/ply_header.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

namespace colift::hal {
namespace {

std::optional<PlyType> type_of(std::string_view word) {
  constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypes = {{{"char", PlyType::Int8},
                                                                            {"int8", PlyType::Int8},
                                                                            {"uchar", PlyType::Uint8},
                                                                            {"uint8", PlyType::Uint8},
                                                                            {"short", PlyType::Int16},
                                                                            {"int16", PlyType::Int16},
                                                                            {"ushort", PlyType::Uint16},
                                                                            {"uint16", PlyType::Uint16},
                                                                            {"int", PlyType::Int32},
                                                                            {"int32", PlyType::Int32},
                                                                            {"uint", PlyType::Uint32},
                                                                            {"uint32", PlyType::Uint32},
                                                                            {"float", PlyType::Float32},
                                                                            {"float32", PlyType::Float32},
                                                                            {"double", PlyType::Float64},
                                                                            {"float64", PlyType::Float64}}};
  for (const auto& [name, type] : kTypes) {
    if (name == word) return type;
  }
  return std::nullopt;
}

class HeaderParser {
 public:
  HeaderParser(Bytes bytes, const std::string& name) : name_(name), scanner_(bytes) {}

  Result<PlyHeader> run() {
    if (auto ok = read_header(); !ok) return tl::unexpected(ok.error());
    header_.data_offset = scanner_.offset();
    header_.data_line = scanner_.line() + 1;
    return std::move(header_);
  }

 private:
  [[nodiscard]] tl::unexpected<Error> at_line(std::string detail) const {
    return failure(ErrorCode::BadInput, fmt::format("{}:{}", name_, scanner_.line()), std::move(detail));
  }

  Result<> read_header() {
    const auto magic = scanner_.next();
    if (!magic || *magic != "ply")
      return at_line(fmt::format("found {}; a PLY file begins with ply", shown(magic.value_or(""))));
    bool format_given = false;
    while (const auto text = scanner_.next()) {
      std::string_view rest = *text;
      const std::string_view key = next_word(rest);
      if (key.empty() || key == "comment") continue;
      if (key == "end_header") {
        if (!format_given) return at_line("the header ends without a line format");
        return {};
      }
      Result<> ok;
      if (key == "format") {
        ok = read_format(rest);
        format_given = true;
      } else if (key == "element") {
        ok = read_element(rest);
      } else if (key == "property") {
        ok = read_property(rest);
      } else if (key == "obj_info") {
        const std::string_view what = next_word(rest);
        const auto number = to_count(next_word(rest));
        if (what == "num_cols") header_.columns = plausible(number);
        if (what == "num_rows") header_.rows = plausible(number);
      } else {
        ok = at_line(
            fmt::format("found {}; expected format, element, property, comment or end_header", shown(*text)));
      }
      if (!ok) return ok;
    }
    return at_line("the file ends inside the header: no line end_header was found");
  }

  static std::optional<std::uint64_t> plausible(std::optional<std::uint64_t> n) {
    return n && *n > 0 && *n <= static_cast<std::uint64_t>(std::numeric_limits<int>::max()) ? n
                                                                                            : std::nullopt;
  }

  Result<> read_format(std::string_view rest) {
    const std::string_view kind = next_word(rest);
    const std::string_view version = next_word(rest);
    if (kind == "ascii") {
      header_.encoding = PlyEncoding::Ascii;
    } else if (kind == "binary_little_endian") {
      header_.encoding = PlyEncoding::Little;
    } else if (kind == "binary_big_endian") {
      header_.encoding = PlyEncoding::Big;
    } else {
      return at_line(fmt::format("format is {}; expected ascii, binary_little_endian or binary_big_endian",
                                 shown(kind)));
    }
    if (version != "1.0") return at_line(fmt::format("format version is {}; expected 1.0", shown(version)));
    return {};
  }

  Result<> read_element(std::string_view rest) {
    PlyElement element;
    element.name = next_word(rest);
    const std::string_view count = next_word(rest);
    const auto number = to_count(count);
    if (element.name.empty() || !number) {
      return at_line(fmt::format("element {} has count {}; expected a name and a whole number",
                                 shown(element.name), shown(count)));
    }
    element.count = *number;
    header_.elements.push_back(std::move(element));
    return {};
  }

  Result<> read_property(std::string_view rest) {
    if (header_.elements.empty()) return at_line("found a property before the first element");
    PlyProperty property;
    std::string_view word = next_word(rest);
    if (word == "list") {
      word = next_word(rest);
      property.length = type_of(word);
      if (!property.length || *property.length == PlyType::Float32 || *property.length == PlyType::Float64) {
        return at_line(
            fmt::format("the length of a list has type {}; expected a whole number's type", shown(word)));
      }
      word = next_word(rest);
    }
    const auto type = type_of(word);
    if (!type)
      return at_line(fmt::format("property type {} is not one of PLY's (char to double)", shown(word)));
    property.type = *type;
    property.name = next_word(rest);
    if (property.name.empty()) return at_line("a property has no name");
    header_.elements.back().properties.push_back(property);
    return {};
  }

  const std::string& name_;
  LineScanner scanner_;
  PlyHeader header_;
};

}  // namespace

std::size_t bytes_of(PlyType type) {
  switch (type) {
    case PlyType::Int8:
    case PlyType::Uint8:
      return 1;
    case PlyType::Int16:
    case PlyType::Uint16:
      return 2;
    case PlyType::Int32:
    case PlyType::Uint32:
    case PlyType::Float32:
      return 4;
    case PlyType::Float64:
      return 8;
  }
  return 8;
}

bool PlyElement::has_lists() const {
  return std::any_of(properties.begin(), properties.end(),
                     [](const PlyProperty& p) { return p.length.has_value(); });
}

std::optional<std::size_t> PlyElement::find(std::string_view wanted) const {
  for (std::size_t i = 0; i < properties.size(); ++i) {
    if (properties[i].name == wanted && !properties[i].length) return i;
  }
  return std::nullopt;
}

std::uint64_t PlyElement::min_bytes(PlyEncoding encoding) const {
  std::uint64_t sum = 0;
  for (const PlyProperty& p : properties) {
    sum += encoding == PlyEncoding::Ascii ? 2 : bytes_of(p.length.value_or(p.type));
  }
  return sum;
}

Result<PlyHeader> parse_ply_header(Bytes bytes, const std::string& name) {
  return HeaderParser(bytes, name).run();
}

}  // namespace colift::hal
