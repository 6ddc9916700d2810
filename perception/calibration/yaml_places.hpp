#pragma once

#include <string>

#include "hal/config/yaml_tree.hpp"

namespace colift::perception {

/// "FILE:LINE:COLUMN" of a value in a YAML text that was accepted already: `key` at the top, or in element
/// `index` of the list `list` at the top. The file alone where there is none.
[[nodiscard]] std::string place_of(const std::string& yaml, const std::string& name, const std::string& key);
[[nodiscard]] std::string place_of(const std::string& yaml, const std::string& name, const std::string& list,
                                   std::size_t index, const std::string& key);

}  // namespace colift::perception
