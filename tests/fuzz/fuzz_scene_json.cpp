// libFuzzer: whatever the bytes, scene.json is read or refused with its place and a sentence; what was read
// has images of all steps, none of which leaves its folder, and reads again as the same.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "demand.hpp"
#include "tools/scenes/scene_json.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace colift::tools;
  using colift::fuzz::demand;
  const auto file = parse_scene_file({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!file) {
    demand(file.error().where == "fuzz" && !file.error().detail.empty());
    return 0;
  }
  for (const auto& images : file->images) {
    demand(!images.empty());
    for (const std::string& image : images) demand(!image.empty() && image.find('/') == std::string::npos);
  }
  const auto again = parse_scene_file(scene_file_text(*file), "again");
  demand(again && again->images.size() == file->images.size() && again->known == file->known);
  return 0;
}
