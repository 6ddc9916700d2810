#pragma once

#include <map>
#include <memory>
#include <string>

#include "hal/types/result.hpp"

namespace urdf {
class ModelInterface;
}

namespace colift::hal {

/// A URDF as urdfdom understood it, and where its elements stand.
struct UrdfText {
  std::shared_ptr<urdf::ModelInterface> model;
  std::string name;  ///< Of the file; stands in errors.
  std::map<std::string, int> line_of_link, line_of_joint;

  /// "file:line" of an element.
  [[nodiscard]] std::string place_of_link(const std::string& link) const;
  [[nodiscard]] std::string place_of_joint(const std::string& joint) const;
};

/// Reads the XML. Errors: BadInput (no XML, with line and column; too deep or too large), BadConfig (what
/// urdfdom refuses, in its words).
[[nodiscard]] Result<UrdfText> read_urdf_text(const std::string& urdf, const std::string& name);

}  // namespace colift::hal
