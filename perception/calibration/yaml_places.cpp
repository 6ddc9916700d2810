#include "perception/calibration/yaml_places.hpp"

#include <optional>

namespace colift::perception {
namespace {

std::optional<std::uint32_t> child(const hal::YamlTree& tree, std::uint32_t map, const std::string& key) {
  const hal::YamlNode& node = tree.at(map);
  if (node.kind != hal::YamlNode::Kind::Map) return std::nullopt;
  for (std::size_t i = 0; i + 1 < node.children.size(); i += 2)
    if (tree.at(node.children[i]).text == key) return node.children[i + 1];
  return std::nullopt;
}

}  // namespace

std::string place_of(const std::string& yaml, const std::string& name, const std::string& key) {
  const auto tree = hal::parse_yaml(yaml, name);
  if (!tree) return name;
  const auto value = child(*tree, tree->root, key);
  return value ? hal::place_text(name, tree->at(*value).place) : name;
}

std::string place_of(const std::string& yaml, const std::string& name, const std::string& list,
                     std::size_t index, const std::string& key) {
  const auto tree = hal::parse_yaml(yaml, name);
  if (!tree) return name;
  const auto items = child(*tree, tree->root, list);
  if (!items || index >= tree->at(*items).children.size()) return name;
  const std::uint32_t item = tree->at(*items).children[index];
  const auto value = child(*tree, item, key);
  return hal::place_text(name, tree->at(value ? *value : item).place);
}

}  // namespace colift::perception
