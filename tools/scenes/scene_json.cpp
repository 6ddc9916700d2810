#include "tools/scenes/scene_json.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

namespace colift::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSchema = "colift.scene/1";
constexpr std::size_t kMaxImages = 1000;
constexpr double kMaxLift_m = 2.0;

auto bad(const std::string& place, std::string why) {
  return hal::failure(hal::ErrorCode::BadInput, place, std::move(why));
}

std::optional<SceneVerdict> verdict_of(const std::string& word) {
  for (const auto v : {SceneVerdict::Right, SceneVerdict::Partly, SceneVerdict::Nothing, SceneVerdict::Wrong})
    if (word == to_string(v)) return v;
  return std::nullopt;
}

// An image's name stays in its folder.
bool is_plain(const std::string& name) {
  return !name.empty() && name.find('/') == std::string::npos && name.front() != '.';
}

hal::Result<SceneFile> parse(const std::string& path, const Json& j) {
  const auto text = [&](const char* key) {
    return j.contains(key) && j[key].is_string() ? j[key].get<std::string>() : std::string();
  };
  if (!j.is_object() || text("schema") != kSchema)
    return bad(path, fmt::format("is no recorded scene: schema is not {}", kSchema));
  SceneFile file{text("name"), text("object"), text("camera"), text("licence"), {}, {}, {}, {}};
  if (j.contains("lifted_m") && !j["lifted_m"].is_null()) {
    if (!j["lifted_m"].is_number() || !(std::abs(j["lifted_m"].get<double>()) <= kMaxLift_m))
      return bad(path, "lifted_m: expected a number of metres, or null");
    file.lifted_m = j["lifted_m"].get<double>();
  }
  if (j.contains("hand_px") && !j["hand_px"].is_null()) {
    const Json& px = j["hand_px"];
    if (!px.is_array() || px.size() != 2 || !px[0].is_number() || !px[1].is_number())
      return bad(path, "hand_px: expected column and row of a pixel, or null");
    file.hand_px = {px[0].get<double>(), px[1].get<double>()};
  }
  if (!j.contains("images") || !j["images"].is_object()) return bad(path, "images: expected the four steps");
  for (const SceneStep step : kSceneSteps) {
    const char* const name = to_string(step);
    const Json list = j["images"].value(name, Json::array());
    if (!list.is_array() || list.empty() || list.size() > kMaxImages)
      return bad(path, fmt::format("images.{}: expected 1 to {} names of images", name, kMaxImages));
    for (const Json& image : list) {
      if (!image.is_string() || !is_plain(image.get<std::string>()))
        return bad(path, fmt::format("images.{}: expected names of images in this folder", name));
      file.images[static_cast<std::size_t>(step)].push_back(image.get<std::string>());
    }
  }
  const Json known = j.value("known", Json::object());
  for (const auto& [key, value] : known.items()) {
    const auto verdict = value.is_string() ? verdict_of(value.get<std::string>()) : std::nullopt;
    if (!verdict) return bad(path, fmt::format("known.{}: expected right, partly, nothing or wrong", key));
    file.known[key] = *verdict;
  }
  return file;
}

}  // namespace

const char* to_string(SceneStep step) {
  constexpr std::array kNames{"empty", "object", "hand", "lift"};
  return kNames[static_cast<std::size_t>(step)];
}

const char* to_string(SceneVerdict verdict) {
  constexpr std::array kWords{"right", "partly", "nothing", "wrong"};
  return kWords[static_cast<std::size_t>(verdict)];
}

hal::Result<SceneFile> parse_scene_file(std::string_view text, const std::string& place) {
  const Json j = Json::parse(text, nullptr, false);
  if (j.is_discarded()) return bad(place, "is no JSON");
  return parse(place, j);
}

std::string scene_file_text(const SceneFile& file) {
  Json images = Json::object(), known = Json::object();
  for (const SceneStep step : kSceneSteps)
    images[to_string(step)] = file.images[static_cast<std::size_t>(step)];
  for (const auto& [step, verdict] : file.known) known[step] = to_string(verdict);
  const Json j = {{"schema", kSchema},
                  {"name", file.name},
                  {"object", file.object},
                  {"camera", file.camera},
                  {"licence", file.licence},
                  {"lifted_m", file.lifted_m ? Json(*file.lifted_m) : Json(nullptr)},
                  {"hand_px", file.hand_px ? Json(*file.hand_px) : Json(nullptr)},
                  {"images", std::move(images)},
                  {"known", std::move(known)}};
  return j.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace colift::tools
