#include "sim_hal/scenario/scenario_lists.hpp"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "hal/config/field_value.hpp"

namespace colift::sim_hal {
namespace {

// longer lists are refused by whoever reads them; here they would only cost memory
constexpr std::size_t kMaxPeople = 100, kMaxPoints = 1000;

using hal::YamlNode;
using hal::YamlTree;
using Kind = YamlNode::Kind;

// nodes may be shared by aliases: what changes is a copy
std::uint32_t add(YamlTree& tree, YamlNode node) {
  tree.nodes.push_back(std::move(node));
  return static_cast<std::uint32_t>(tree.nodes.size() - 1);
}

/// Place of a key's value among a map's children, 0 when there is none.
std::size_t value_of(const YamlTree& tree, const YamlNode& map, std::string_view key) {
  if (map.kind != Kind::Map) return 0;
  for (std::size_t i = 0; i + 1 < map.children.size(); i += 2)
    if (tree.at(map.children[i]).text == key) return i + 1;
  return 0;
}

hal::Result<> flatten_path(YamlTree& tree, YamlNode& person, const std::string& where,
                           const std::string& name) {
  const std::size_t at = value_of(tree, person, "path");
  if (at == 0 || tree.at(person.children[at]).kind != Kind::List) return {};
  YamlNode flat = tree.at(person.children[at]);
  if (flat.children.size() > kMaxPoints) return {};
  const std::vector<std::uint32_t> points = std::exchange(flat.children, {});
  for (std::size_t k = 0; k < points.size(); ++k) {
    const YamlNode& point = tree.at(points[k]);
    if (point.kind != Kind::List || point.children.size() != 2)
      return hal::failure(hal::ErrorCode::BadConfig, hal::place_text(name, point.place),
                          fmt::format("{}.path[{}] expects a point of the floor, [x, y], but found {}", where,
                                      k, hal::description(point)));
    flat.children.insert(flat.children.end(), point.children.begin(), point.children.end());
  }
  person.children[at] = add(tree, std::move(flat));
  return {};
}

void split_reach(YamlTree& tree, YamlNode& person) {
  const std::size_t at = value_of(tree, person, "reach_to");
  if (at == 0 || tree.at(person.children[at]).kind != Kind::List) return;
  const std::uint32_t list = person.children[at];
  YamlNode word;
  word.kind = Kind::Plain;
  word.place = tree.at(list).place;
  word.text = "point";
  const std::uint32_t both = add(tree, std::move(word));  // value of the one key, name of the other
  person.children[at] = both;
  person.children.push_back(both);
  person.children.push_back(list);
}

}  // namespace

hal::Result<> flatten_lists(YamlTree& tree, const std::string& name) {
  const std::size_t people_at = value_of(tree, tree.at(tree.root), "people");
  if (people_at == 0) return {};
  YamlNode people = tree.at(tree.at(tree.root).children[people_at]);
  if (people.kind != Kind::List || people.children.size() > kMaxPeople) return {};
  for (std::size_t i = 0; i < people.children.size(); ++i) {
    YamlNode person = tree.at(people.children[i]);
    if (person.kind != Kind::Map) continue;
    if (auto done = flatten_path(tree, person, fmt::format("people[{}]", i), name); !done) return done;
    split_reach(tree, person);
    people.children[i] = add(tree, std::move(person));
  }
  const std::uint32_t changed = add(tree, std::move(people));
  tree.nodes[tree.root].children[people_at] = changed;
  return {};
}

}  // namespace colift::sim_hal
