#include "tools/cli/shipped_files.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <system_error>

#include "hal/config/nearest_name.hpp"

namespace colift::tools {
namespace {

namespace fs = std::filesystem;

/// The first paragraph of the comment at the top of a YAML file, its lines joined; an indented line is a
/// command and ends it.
std::string leading_comment(const fs::path& file) {
  std::ifstream in(file);
  std::string about;
  for (std::string line; std::getline(in, line) && line.starts_with("# ") && !line.starts_with("#  ");) {
    if (!about.empty()) about += ' ';
    about += line.substr(2);
  }
  return about;
}

constexpr const char* kFrame = "depth.png";

/// The folder that holds all of one kind; of a checkout or of an installation.
fs::path folder_of(ShippedKind kind) {
  const fs::path config = shipped_folder();
  if (config.empty() || kind == ShippedKind::Robot) return config;
  if (kind == ShippedKind::Scenario) return config / "scenario";
  const fs::path installed = config.parent_path() / "scene";
  std::error_code error;
  return fs::is_directory(installed, error) ? installed : config.parent_path() / "tests" / "data" / "real";
}

/// What a scene shows, as its truth says; empty without.
std::string summary_of(const fs::path& scene) {
  std::ifstream in(scene / "truth.json");
  const auto truth = nlohmann::json::parse(in, nullptr, false);
  return truth.is_object() ? truth.value("summary", "") : "";
}

/// The file of a kind that an entry of its folder stands for; nothing when it is something else.
std::optional<ShippedFile> shipped_file(ShippedKind kind, const fs::path& entry) {
  std::error_code error;
  if (kind != ShippedKind::Scene)
    return entry.extension() != ".yaml"
               ? std::nullopt
               : std::optional(ShippedFile{entry.stem().string(), entry, leading_comment(entry)});
  if (!fs::exists(entry / kFrame, error)) return std::nullopt;
  return ShippedFile{entry.filename().string(), entry / kFrame, summary_of(entry)};
}

}  // namespace

const char* word_of(ShippedKind kind) {
  switch (kind) {
    case ShippedKind::Scenario:
      return "scenario";
    case ShippedKind::Robot:
      return "robot";
    case ShippedKind::Scene:
      return "scene";
  }
  return "";
}

fs::path shipped_folder() {
  std::error_code error;
  fs::path file = fs::read_symlink("/proc/self/exe", error);
  // the Python module is not where its interpreter is
  Dl_info code{};
  if (dladdr(reinterpret_cast<const void*>(&shipped_folder), &code) != 0 && code.dli_fname != nullptr &&
      std::string_view(code.dli_fname).ends_with(".so"))
    file = fs::absolute(code.dli_fname, error);
  // installed: PREFIX/bin, PREFIX/lib/python3/dist-packages/colift; of a checkout: build, build/PRESET,
  // build/python/colift
  constexpr int kLevels = 5;
  fs::path folder = file.parent_path();
  for (int level = 0; level < kLevels && folder.has_relative_path(); ++level, folder = folder.parent_path())
    for (const fs::path& config : {folder / "share" / "colift" / "config", folder / "config"})
      if (fs::is_regular_file(config / "scenario" / "table.yaml", error)) return config;
  return {};
}

std::vector<ShippedFile> shipped_files(ShippedKind kind) {
  std::vector<ShippedFile> files;
  const fs::path folder = folder_of(kind);
  if (folder.empty()) return files;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
    if (auto file = shipped_file(kind, entry.path())) files.push_back(std::move(*file));
  std::sort(files.begin(), files.end(),
            [](const ShippedFile& a, const ShippedFile& b) { return a.name < b.name; });
  return files;
}

hal::Result<fs::path> file_or_shipped(ShippedKind kind, const std::string& text) {
  std::error_code error;
  if (text.find_first_of("/.") != std::string::npos || fs::exists(text, error)) {
    const bool scene = kind == ShippedKind::Scene && fs::exists(fs::path(text) / kFrame, error);
    return scene ? fs::path(text) / kFrame : fs::path(text);
  }
  std::vector<std::string> names;
  for (const ShippedFile& each : shipped_files(kind)) {
    if (each.name == text) return each.file;
    names.push_back(each.name);
  }
  const auto nearest = hal::nearest_path(text, names);
  return hal::failure(
      hal::ErrorCode::NotFound, text,
      fmt::format("there is no such file, and no {0} of that name is shipped; {1}", word_of(kind),
                  nearest ? fmt::format("did you mean \"{}\"?", *nearest)
                          : fmt::format("\"colift {}s\" lists those that are", word_of(kind))));
}

}  // namespace colift::tools
