#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hal/types/result.hpp"

namespace colift::tools {

/// What CoLift ships and finds by name from any folder.
enum class ShippedKind {
  Scenario,  ///< Simulated rigs with their partner: config/scenario/NAME.yaml.
  Robot,     ///< Robot files: config/NAME.yaml.
  Scene,     ///< Recorded depth frames with what they show: NAME/depth.png, camera.json, truth.json.
};

struct ShippedFile {
  std::string name;  ///< "pipe".
  std::filesystem::path file;
  /// First paragraph of the comment at the file's top, in one line; of a scene the summary of its truth.json.
  std::string about;
};

/// The folder config/ beside the program: of the checkout that it was built in, or share/colift/config of an
/// installation. Empty when there is none.
[[nodiscard]] std::filesystem::path shipped_folder();

/// The word of a kind in messages and documents: "scenario", "robot", "scene".
[[nodiscard]] const char* word_of(ShippedKind kind);

/// All of one kind, by name; none where there is no such folder.
[[nodiscard]] std::vector<ShippedFile> shipped_files(ShippedKind kind);

/// The file that an option means: a path (with a slash, a dot, or of a file that is there) as it stands, else
/// the shipped file of that name. A folder that stands for a scene becomes its depth.png. Errors: NotFound,
/// with the nearest name.
[[nodiscard]] hal::Result<std::filesystem::path> file_or_shipped(ShippedKind kind, const std::string& text);

}  // namespace colift::tools
