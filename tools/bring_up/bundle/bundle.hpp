#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hal/types/result.hpp"

namespace colift::tools {

/// One file of a bundle.
struct BundlePart {
  std::string name;  ///< Without folder; at most 80 letters, digits, '.', '-' and '_'.
  std::string text;
};

/// A tar archive (POSIX.1-1988 ustar) of all parts in a folder `folder`, each with mode 0644 and time 0, so
/// that the same parts give the same bytes. A part of a name that cannot be is left out.
[[nodiscard]] std::string bundle_bytes(const std::string& folder, const std::vector<BundlePart>& parts);

/// Whether the file is still to be made: asked before a device is, whose answers could not be kept. Errors:
/// BadInput (exists already).
[[nodiscard]] hal::Result<> check_new_bundle(const std::filesystem::path& file);

/// Writes it. Errors: BadInput (exists already, no such folder, no permission).
[[nodiscard]] hal::Result<> write_bundle(const std::filesystem::path& file,
                                         const std::vector<BundlePart>& parts);

}  // namespace colift::tools
