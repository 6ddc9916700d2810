#include "hal/drivers/recorded/camera_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace colift::hal {
namespace {

using Json = nlohmann::json;

bool is_wordy(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.' || c == '-' ||
         c == '+';
}

// Where a byte of a text lies, as an editor shows it.
std::string place(const std::string& name, std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, std::min(byte, text.size()));
  const auto line = std::count(before.begin(), before.end(), '\n') + 1;
  const std::size_t last = before.rfind('\n');
  const std::size_t column = last == std::string_view::npos ? before.size() : before.size() - last - 1;
  return fmt::format("{}:{}:{}", name, line, column + 1);
}

Result<double> number(const Json& json, const char* key, double low, double high, const char* unit,
                      const std::string& name) {
  const auto refuse = [&](const std::string& found) {
    return failure(ErrorCode::BadInput, fmt::format("{}: {}", name, key),
                   fmt::format("{} {}; expected a number from {} to {} ({})", key, found, low, high, unit));
  };
  const auto entry = json.find(key);
  if (entry == json.end()) return refuse("is missing");
  // writing nested JSON out again recurses as deep as it is nested
  if (entry->is_structured()) return refuse(fmt::format("is an {}", entry->type_name()));
  if (!entry->is_number())
    return refuse("is " + shown(entry->dump(-1, ' ', true, Json::error_handler_t::replace)));
  const auto value = entry->get<double>();
  if (!(value >= low && value <= high)) return refuse(fmt::format("is {}", value));
  return value;
}

Result<int> pixels(const Json& json, const char* key, const std::string& name) {
  const auto value = number(json, key, 1, 8192, "pixels", name);
  if (!value) return tl::unexpected(value.error());
  if (*value != std::floor(*value)) {
    return failure(ErrorCode::BadInput, fmt::format("{}: {}", name, key),
                   fmt::format("{} is {}; expected a whole number of pixels", key, *value));
  }
  return static_cast<int>(*value);
}

}  // namespace

Result<CameraFile> parse_camera_json(Bytes bytes, const std::string& name) {
  const std::string_view text = as_text(bytes);
  Json json;
  try {
    json = Json::parse(text);
  } catch (const Json::parse_error& error) {
    std::size_t byte = std::min(error.byte > 0 ? error.byte - 1 : 0, text.size());
    // the parser names the end of a token that it did not expect, a person looks for its beginning
    while (byte > 0 && byte < text.size() && is_wordy(text[byte]) && is_wordy(text[byte - 1])) --byte;
    const std::string_view at = text.substr(byte);
    return failure(ErrorCode::BadInput, place(name, text, byte),
                   at.empty() ? "the JSON text ends too early"
                              : fmt::format("not valid JSON at {}", shown(at.substr(0, at.find('\n')))));
  } catch (const Json::exception& error) {
    return failure(ErrorCode::BadInput, name, fmt::format("not usable JSON: {}", error.what()));
  }
  if (!json.is_object()) {
    return failure(ErrorCode::BadInput, name + ":1:1",
                   fmt::format("found JSON of type {}; expected an object with fx, fy, cx, cy, depth_scale_m",
                               json.type_name()));
  }

  // generous: from a fisheye of 50 pixels to a telescope; a scale beyond 0.1 m is somebody's units per metre
  struct Entry {
    const char* key;
    double CameraFile::*field;
    double low, high;
    const char* unit;
  };
  CameraFile out;
  for (const Entry& e :
       {Entry{"fx", &CameraFile::fx, 1.0, 1e5, "pixels"}, Entry{"fy", &CameraFile::fy, 1.0, 1e5, "pixels"},
        Entry{"cx", &CameraFile::cx, 1e-3, 8192, "pixels"},
        Entry{"cy", &CameraFile::cy, 1e-3, 8192, "pixels"},
        Entry{"depth_scale_m", &CameraFile::depth_scale_m, 1e-7, 0.1, "metres per unit"}}) {
    const auto value = number(json, e.key, e.low, e.high, e.unit, name);
    if (!value) return tl::unexpected(value.error());
    out.*e.field = *value;
  }
  for (const auto& [key, field, centre] : {std::tuple{"width", &CameraFile::width, &CameraFile::cx},
                                           std::tuple{"height", &CameraFile::height, &CameraFile::cy}}) {
    if (!json.contains(key)) continue;
    const auto value = pixels(json, key, name);
    if (!value) return tl::unexpected(value.error());
    out.*field = *value;
    if (out.*centre >= *value) {
      return failure(
          ErrorCode::BadInput, fmt::format("{}: {}", name, key),
          fmt::format("the image's centre {} lies outside its {} of {} pixels", out.*centre, key, *value));
    }
  }
  return out;
}

}  // namespace colift::hal
