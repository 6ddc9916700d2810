#include "tools/scenes/scene_file.hpp"

#include <fstream>
#include <string>

#include "hal/drivers/recorded/frame_file.hpp"
#include "tools/visualization/file_output.hpp"

namespace colift::tools {
namespace {

constexpr std::size_t kMaxBytes = 1U << 20U;

auto bad(const std::filesystem::path& file, std::string why) {
  return hal::failure(hal::ErrorCode::BadInput, file.string(), std::move(why));
}

}  // namespace

hal::Result<RecordedSteps> read_scene(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "scene.json";
  std::ifstream in(path, std::ios::binary);
  if (!in) return bad(path, "cannot be read; expected a folder of colift hal camera record --scene");
  std::string text(kMaxBytes, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  auto file = parse_scene_file(text, path.string());
  if (!file) return tl::unexpected(file.error());

  RecordedSteps scene{folder, std::move(*file), {}};
  for (std::size_t step = 0; step < kSceneSteps.size(); ++step) {
    for (const std::string& image : scene.file.images[step]) {
      auto read = hal::read_frame(folder / image);
      if (!read) return tl::unexpected(read.error());
      const auto& first = scene.frames.front();
      if (!first.empty() && first.front().depth_m.size() != read->frame.depth_m.size())
        return bad(folder / image, "is of another size than the first image");
      scene.frames[step].push_back(std::move(read->frame));
    }
  }
  return scene;
}

hal::Result<> write_scene_file(const std::filesystem::path& folder, const SceneFile& file) {
  const std::string text = scene_file_text(file);
  return picture::write_file(folder / "scene.json",
                             {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

}  // namespace colift::tools
