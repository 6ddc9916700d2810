#pragma once

#include <filesystem>
#include <string>

namespace colift::hal::capture {

/// Folder of the running program: capture processes are beside it.
[[nodiscard]] inline std::string own_folder() {
  std::error_code none;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", none);
  return none ? std::string(".") : self.parent_path().string();
}

}  // namespace colift::hal::capture
