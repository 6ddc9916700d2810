#include "tools/scenes/scene_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "tools/visualization/palette.hpp"

namespace colift::tools {

bool CheckedScene::accepted() const {
  return reason.empty() &&
         std::all_of(rows.begin(), rows.end(), [](const SceneRow& r) { return r.accepted; });
}

std::string scene_text(const CheckedScene& c) {
  std::string text = c.folder.string();
  for (const std::string& word : {c.file.object, c.file.camera})
    if (!word.empty()) text += "  " + word;
  text += "\n";
  if (!c.reason.empty()) return text + fmt::format("  no truth: {}\n", c.reason);
  for (const SceneRow& r : c.rows) {
    const char* const mark = r.accepted ? r.verdict == SceneVerdict::Right ? "" : " (known)" : " !";
    text +=
        fmt::format("  {:<7} {:<7} {:<16} {}; found: {}\n", to_string(r.step), control::to_string(r.method),
                    fmt::format("{}{}", to_string(r.verdict), mark), r.truth, r.found);
  }
  return text;
}

std::string scenes_document(const std::vector<CheckedScene>& checked) {
  using Json = nlohmann::ordered_json;
  Json scenes = Json::array();
  bool accepted = true;
  for (const CheckedScene& c : checked) {
    accepted = accepted && c.accepted();
    Json rows = Json::array();
    for (const SceneRow& r : c.rows)
      rows.push_back({{"step", to_string(r.step)},
                      {"method", control::to_string(r.method)},
                      {"verdict", to_string(r.verdict)},
                      {"accepted", r.accepted},
                      {"truth", r.truth},
                      {"found", r.found}});
    scenes.push_back({{"folder", c.folder.string()},
                      {"name", c.file.name},
                      {"object", c.file.object},
                      {"because", c.reason.empty() ? Json(nullptr) : Json(c.reason)},
                      {"accepted", c.accepted()},
                      {"rows", std::move(rows)}});
  }
  const Json j = {{"schema", "colift.scenes/1"}, {"accepted", accepted}, {"scenes", std::move(scenes)}};
  return j.dump(-1, ' ', false, Json::error_handler_t::replace);
}

picture::Canvas scene_picture(const RecordedSteps& scene, const SceneTruth& truth) {
  const auto& k = truth.object.intrinsics;
  constexpr int kCaption = 24;
  picture::Canvas canvas(2 * k.width, 2 * (k.height + kCaption), picture::kPaper);
  for (std::size_t step = 0; step < kSceneSteps.size(); ++step) {
    const hal::DepthFrame& frame = scene.frames[step].back();
    std::vector<std::uint8_t> rgb;
    rgb.reserve(3 * frame.depth_m.size());
    for (std::size_t i = 0; i < frame.depth_m.size(); ++i) {
      auto c = picture::depth_rgb(static_cast<double>(frame.depth_m[i]));
      if (step == 1 && truth.object_pixels[i]) c[2] = std::min(255.0, c[2] + 110.0);
      if (step == 2 && truth.person_pixels[i]) c[0] = std::min(255.0, c[0] + 110.0);
      for (const double v : c) rgb.push_back(static_cast<std::uint8_t>(v));
    }
    const int x = static_cast<int>(step % 2) * k.width,
              y = static_cast<int>(step / 2) * (k.height + kCaption);
    canvas.image(x, y, k.width, k.height, rgb);
    picture::TextStyle words;
    words.size = 13.0;
    canvas.text({x + 6.0, y + k.height + 17.0}, to_string(kSceneSteps[step]), words);
    if (step != 2) continue;
    for (const hal::Vec3& hand : truth.hands) {
      const auto at = truth.object.project(hand);
      canvas.circle({x + at.u, y + at.v}, 9.0, {picture::kTarget, 2.0});
    }
  }
  return canvas;
}

}  // namespace colift::tools
