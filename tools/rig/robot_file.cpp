#include "tools/rig/robot_file.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "hal/config/config_file.hpp"

namespace colift::tools {
namespace {

using hal::YamlNode;

constexpr std::array<std::string_view, 3> kDevices{"arm", "hand", "camera"};

/// Turns `camera: {driver: ros2, image: /depth}` into `camera: ros2` and `ros2: {image: /depth}`, for each
/// device of a map. What is no such group stays as it is, and is refused where it does not belong.
void unfold_drivers(hal::YamlTree& tree, std::uint32_t map) {
  if (tree.at(map).kind != YamlNode::Kind::Map) return;
  const std::vector<std::uint32_t> entries = tree.at(map).children;
  for (std::size_t i = 0; i + 1 < entries.size(); i += 2) {
    const bool device = std::ranges::count(kDevices, tree.at(entries[i]).text) > 0;
    const YamlNode group = tree.at(entries[i + 1]);
    if (!device || group.kind != YamlNode::Kind::Map) continue;
    YamlNode rest{.kind = YamlNode::Kind::Map, .place = group.place, .text = {}, .children = {}};
    std::optional<std::uint32_t> driver;
    for (std::size_t k = 0; k + 1 < group.children.size(); k += 2) {
      if (!driver && tree.at(group.children[k]).text == "driver")
        driver = group.children[k + 1];
      else
        rest.children.insert(rest.children.end(), {group.children[k], group.children[k + 1]});
    }
    if (!driver || tree.at(*driver).text.empty()) continue;
    tree.nodes[map].children[i + 1] = *driver;
    if (rest.children.empty()) continue;
    YamlNode name = tree.at(*driver);
    const auto at = static_cast<std::uint32_t>(tree.nodes.size());
    tree.nodes.push_back(std::move(name));
    tree.nodes.push_back(std::move(rest));
    tree.nodes[map].children.insert(tree.nodes[map].children.end(), {at, at + 1});
  }
}

/// The same for the file and for each of its more_cameras.
void unfold_all(hal::YamlTree& tree) {
  unfold_drivers(tree, tree.root);
  const std::vector<std::uint32_t> entries = tree.at(tree.root).children;
  if (tree.at(tree.root).kind != YamlNode::Kind::Map) return;
  for (std::size_t i = 0; i + 1 < entries.size(); i += 2) {
    if (tree.at(entries[i]).text != "more_cameras" || tree.at(entries[i + 1]).kind != YamlNode::Kind::List)
      continue;
    const std::vector<std::uint32_t> cameras = tree.at(entries[i + 1]).children;
    for (const std::uint32_t camera : cameras) unfold_drivers(tree, camera);
  }
}

}  // namespace

hal::Result<RobotFile> read_robot_file(const std::optional<std::filesystem::path>& file) {
  RobotFile robot;
  if (!file) return robot;
  const std::string name = file->string();
  auto text = hal::read_yaml_file(*file);
  if (!text) return tl::unexpected(text.error());
  auto tree = hal::parse_yaml(*text, name);
  if (!tree) return tl::unexpected(tree.error());
  unfold_all(*tree);
  hal::FieldTable table = hal::table_of(robot);
  if (auto done = hal::apply_yaml_tree(table, *tree, name); !done) return tl::unexpected(done.error());
  if (auto done = hal::check_fields(table, name); !done) return tl::unexpected(done.error());
  return robot;
}

}  // namespace colift::tools
