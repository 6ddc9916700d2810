#include "hal/drivers/recorded/camera_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
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

// Names that drivers and calibration tools give to the one model that is known here.
bool known_model(std::string model) {
  for (char& c : model) c = c == '_' || c == ' ' ? '-' : static_cast<char>(std::tolower(c));
  for (const char* known :
       {"none", "brown-conrady", "plumb-bob", "rational", "rational-polynomial", "opencv"})
    if (model == known) return true;
  return false;
}

Result<LensDistortion> distortion(const Json& entry, const std::string& name) {
  const std::string where = name + ": distortion";
  const auto refuse = [&](const std::string& why) { return failure(ErrorCode::BadInput, where, why); };
  const char* const expected =
      "expected 4, 5 or 8 numbers k1 k2 p1 p2 k3 k4 k5 k6, or an object with model and coefficients";
  if (entry.is_null()) return LensDistortion{};
  const Json* list = &entry;
  if (entry.is_object()) {
    const auto model = entry.find("model");
    if (model == entry.end() || !model->is_string()) return refuse(std::string("has no model; ") + expected);
    const auto coefficients = entry.find("coefficients");
    const bool has = coefficients != entry.end() && coefficients->is_array();
    bool zero = true;
    if (has)
      for (const Json& k : *coefficients) zero = zero && k.is_number() && k.get<double>() == 0.0;
    if (!known_model(model->get<std::string>()) && !(has && zero))
      return refuse(fmt::format("the model {} is not known; expected none, brown-conrady or rational",
                                shown(model->get<std::string>())));
    if (!has) {
      if (model->get<std::string>() == "none") return LensDistortion{};
      return refuse(std::string("has no list of coefficients; ") + expected);
    }
    if (zero) return LensDistortion{};
    list = &*coefficients;
  }
  if (!list->is_array() || (list->size() != 4 && list->size() != 5 && list->size() != 8 && !list->empty()))
    return refuse(list->is_array() ? fmt::format("has {} numbers; {}", list->size(), expected)
                                   : fmt::format("is a {}; {}", list->type_name(), expected));
  LensDistortion lens;
  const std::array<double LensDistortion::*, 8> fields{
      &LensDistortion::k1, &LensDistortion::k2, &LensDistortion::p1, &LensDistortion::p2,
      &LensDistortion::k3, &LensDistortion::k4, &LensDistortion::k5, &LensDistortion::k6};
  for (std::size_t i = 0; i < list->size(); ++i) {
    const Json& k = (*list)[i];
    // the rational model's numbers are large and cancel each other; beyond a thousand nobody measured them
    if (!k.is_number() || !(std::abs(k.get<double>()) <= 1000.0))
      return refuse(fmt::format("number {} is not one from -1000 to 1000", i + 1));
    lens.*fields[i] = k.get<double>();
  }
  return lens;
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
  if (const auto entry = json.find("distortion"); entry != json.end()) {
    const auto lens = distortion(*entry, name);
    if (!lens) return tl::unexpected(lens.error());
    out.lens = *lens;
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
