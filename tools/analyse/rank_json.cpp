#include "tools/analyse/rank_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <iterator>
#include <nlohmann/json.hpp>
#include <span>
#include <type_traits>
#include <vector>

#include "tools/cli/json_tree.hpp"

namespace colift::tools {
namespace {

using hal::Vec3;
using hal::Wrench;
using nlohmann::json;
using planner::AgentLimits;
using planner::RankProblem;

/// Changes of one letter that turn one word into the other.
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t corner = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t swap = corner + (a[i - 1] != b[j - 1]);
      corner = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, swap});
    }
  }
  return row[b.size()];
}

/// Turns the tree into a problem. Throws Refusal inside, which parse_rank_problem() alone sees.
class Reader {
 public:
  struct Refusal {
    std::size_t at;
    std::string why;
  };

  [[nodiscard]] static RankProblem problem(const JsonNode& root) {
    object(root, "", {"cog", "partner", "candidates", "wrenches", "weights", "limits"});
    RankProblem p;
    p.cog = vector(required(root, "", "cog"), "cog");
    p.partner = vector(required(root, "", "partner"), "partner");
    const JsonNode& candidates = list(required(root, "", "candidates"), "candidates", "positions [x, y, z]");
    p.candidates.reserve(candidates.items.size());
    for (std::size_t i = 0; i < candidates.items.size(); ++i) {
      p.candidates.push_back(vector(candidates.items[i], [&] { return fmt::format("candidates[{}]", i); }));
    }
    const JsonNode& wrenches =
        list(required(root, "", "wrenches"), "wrenches", "wrenches [fx, fy, fz, tx, ty, tz]");
    for (std::size_t i = 0; i < wrenches.items.size(); ++i) {
      std::array<double, 6> w{};
      numbers(
          wrenches.items[i], [&] { return fmt::format("wrenches[{}]", i); }, w, "[fx, fy, fz, tx, ty, tz]");
      p.wrenches.push_back({Vec3(w[0], w[1], w[2]), Vec3(w[3], w[4], w[5])});
    }
    const JsonNode& weights = required(root, "", "weights");
    object(weights, "weights", {"epsilon", "omega1", "omega2"});
    p.weights.epsilon = not_negative(required(weights, "weights", "epsilon"), "weights.epsilon");
    p.weights.omega1_per_m = not_negative(required(weights, "weights", "omega1"), "weights.omega1");
    p.weights.omega2_per_m = not_negative(required(weights, "weights", "omega2"), "weights.omega2");
    if (p.weights.epsilon == 0.0) {
      refuse(*find(weights, "epsilon"), "weights.epsilon", "is 0, expected a number above 0");
    }
    if (const JsonNode* limits = find(root, "limits")) {
      object(*limits, "limits", {"partner", "robot"});
      p.limits.emplace();
      agent(*limits, "partner", p.limits->partner);
      agent(*limits, "robot", p.limits->robot);
    }
    return p;
  }

 private:
  [[noreturn]] static void refuse(const JsonNode& node, const std::string& path, const std::string& why) {
    throw Refusal{node.at, path.empty() ? "the document " + why : path + " " + why};
  }

  static const JsonNode* find(const JsonNode& node, std::string_view key) {
    const auto& keys = *node.texts;
    const auto at = std::find(keys.begin(), keys.end(), key);
    return at == keys.end() ? nullptr : &node.items[static_cast<std::size_t>(at - keys.begin())];
  }

  static const JsonNode& required(const JsonNode& node, const std::string& path, const char* key) {
    if (const JsonNode* found = find(node, key)) return *found;
    refuse(node, path, fmt::format("has no key \"{}\", which is required", key));
  }

  static void object(const JsonNode& node, const std::string& path,
                     std::initializer_list<std::string_view> known) {
    if (node.kind != JsonNode::Kind::Object)
      refuse(node, path, fmt::format("is {}, expected an object", node.found()));
    for (std::size_t i = 0; i < node.items.size(); ++i) {
      const std::string& key = (*node.texts)[i];
      if (std::find(known.begin(), known.end(), key) != known.end()) continue;
      const std::string given = shown(key);
      const auto nearest = std::min_element(
          known.begin(), known.end(),
          [&](std::string_view a, std::string_view b) { return distance(given, a) < distance(given, b); });
      refuse(node.items[i], path,
             fmt::format("has an unknown key \"{}\"; the nearest known is \"{}\"", given, *nearest));
    }
  }

  template <class Path>
  static std::string say(const Path& path) {
    if constexpr (std::is_invocable_v<Path>) {
      return path();
    } else {
      return path;
    }
  }

  /// `path` may be a function, so that a million good rows cost no text.
  template <class Path>
  static void numbers(const JsonNode& node, const Path& path, std::span<double> out, const char* meaning) {
    if (node.kind != JsonNode::Kind::Array) {
      refuse(node, say(path),
             fmt::format("is {}, expected {} numbers {}", node.found(), out.size(), meaning));
    }
    if (node.items.size() != out.size()) {
      refuse(node, say(path),
             fmt::format("is a list of {}, expected {} numbers {}", node.items.size(), out.size(), meaning));
    }
    for (std::size_t i = 0; i < out.size(); ++i) {
      const JsonNode& item = node.items[i];
      if (item.kind != JsonNode::Kind::Number) {
        refuse(item, fmt::format("{}[{}]", say(path), i),
               fmt::format("is {}, expected a number", item.found()));
      }
      out[i] = item.number;
    }
  }

  template <class Path>
  static Vec3 vector(const JsonNode& node, const Path& path) {
    std::array<double, 3> v{};
    numbers(node, path, v, "[x, y, z]");
    return {v[0], v[1], v[2]};
  }

  static const JsonNode& list(const JsonNode& node, const std::string& path, const char* meaning) {
    if (node.kind != JsonNode::Kind::Array)
      refuse(node, path, fmt::format("is {}, expected a list of {}", node.found(), meaning));
    if (node.items.empty()) refuse(node, path, fmt::format("is empty, expected a list of {}", meaning));
    return node;
  }

  static double not_negative(const JsonNode& node, const std::string& path) {
    if (node.kind != JsonNode::Kind::Number)
      refuse(node, path, fmt::format("is {}, expected a number", node.found()));
    if (node.number < 0.0)
      refuse(node, path, fmt::format("is {}, expected a number that is not negative", node.number));
    return node.number;
  }

  static void agent(const JsonNode& limits, const char* who, AgentLimits& out) {
    const JsonNode* node = find(limits, who);
    if (node == nullptr) return;
    const std::string path = fmt::format("limits.{}", who);
    object(*node, path, {"force", "torque"});
    if (const JsonNode* force = find(*node, "force")) out.force_n = not_negative(*force, path + ".force");
    if (const JsonNode* torque = find(*node, "torque"))
      out.torque_nm = not_negative(*torque, path + ".torque");
  }
};

// Adding zero turns -0 into 0, which is what a person would write.
void put(fmt::memory_buffer& out, const Vec3& v) {
  fmt::format_to(std::back_inserter(out), "[{},{},{}]", v.x() + 0.0, v.y() + 0.0, v.z() + 0.0);
}

void put(fmt::memory_buffer& out, std::string_view who, const Wrench& w) {
  fmt::format_to(std::back_inserter(out), "\"{}\":{{\"force\":", who);
  put(out, w.force);
  fmt::format_to(std::back_inserter(out), ",\"torque\":");
  put(out, w.torque);
  out.push_back('}');
}

}  // namespace

hal::Result<RankProblem> parse_rank_problem(std::string_view text, const std::string& name) {
  const auto tree = parse_json_tree(text, name);
  if (!tree) return tl::unexpected(tree.error());
  try {
    return Reader::problem(*tree);
  } catch (const Reader::Refusal& refusal) {
    return failure_at(text, name, refusal.at, refusal.why);
  }
}

std::string rank_to_json(const planner::RankResult& result) {
  fmt::memory_buffer out;
  const auto end = std::back_inserter(out);
  fmt::format_to(end, "{{\"schema\":\"colift.rank/1\",\"best\":{},\"ranking\":[",
                 result.best ? std::to_string(*result.best) : "null");
  bool first = true;
  for (const auto& entry : result.ranking) {
    if (!first) out.push_back(',');
    first = false;
    fmt::format_to(end, "{{\"candidate\":{},\"feasible\":{}", entry.candidate, entry.feasible);
    if (!entry.feasible) {
      fmt::format_to(end, ",\"reason\":{}}}",
                     json(entry.reason).dump(-1, ' ', true, json::error_handler_t::replace));
      continue;
    }
    fmt::format_to(end, ",\"cost\":{}", entry.cost);
    if (entry.share) {
      fmt::format_to(end, ",\"share\":{}", *entry.share + 0.0);
    } else {
      fmt::format_to(end, ",\"share\":null");
    }
    fmt::format_to(end, ",\"poses\":[");
    for (std::size_t i = 0; i < entry.poses.size(); ++i) {
      fmt::format_to(end, "{}{{", i == 0 ? "" : ",");
      put(out, "partner", entry.poses[i].partner);
      out.push_back(',');
      put(out, "robot", entry.poses[i].robot);
      out.push_back('}');
    }
    fmt::format_to(end, "]}}");
  }
  fmt::format_to(end, "]}}");
  return fmt::to_string(out);
}

std::string rank_to_table(const RankProblem& problem, const planner::RankResult& result) {
  fmt::memory_buffer out;
  const auto end = std::back_inserter(out);
  fmt::format_to(end, "{:>4}  {:>9}  {:>26}  {:>12}  {:>6}\n", "rank", "candidate", "position (m)", "cost",
                 "share");
  std::size_t feasible = 0;
  for (const auto& entry : result.ranking) {
    const Vec3& p = problem.candidates[entry.candidate];
    const std::string position = fmt::format("{:8.3f} {:8.3f} {:8.3f}", p.x(), p.y(), p.z());
    if (!entry.feasible) {
      fmt::format_to(end, "{:>4}  {:>9}  {:>26}  {}\n", "-", entry.candidate, position, entry.reason);
      continue;
    }
    const std::string share = entry.share ? fmt::format("{:.1f} %", 100.0 * *entry.share) : std::string("-");
    fmt::format_to(end, "{:>4}  {:>9}  {:>26}  {:>12.6g}  {:>7}\n", ++feasible, entry.candidate, position,
                   entry.cost, share);
  }
  if (result.best) {
    fmt::format_to(end, "best: candidate {} of {} ({} feasible)\n", *result.best, result.ranking.size(),
                   feasible);
  } else {
    fmt::format_to(end, "best: none; all {} candidates are beyond the limits\n", result.ranking.size());
  }
  return fmt::to_string(out);
}

}  // namespace colift::tools
