// The table of rules as a Graphviz drawing.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "control/task/machine/task_machine.hpp"

namespace colift::control {

namespace {

struct Group {
  std::string_view name, title, colour;
  bool (*has)(Task);
};

bool is_empty_handed_in_motion(Task t) {
  return (is_moving(t) || t == Task::Halt || t == Task::Contact) && !is_loaded(t);
}

bool is_before_motion(Task t) {
  return !is_end(t) && !is_loaded(t) && !is_empty_handed_in_motion(t);
}

constexpr std::array<Group, 3> kGroups = {{
    {"looks", "looks and decides: nothing moves", "#e8f1fb", is_before_motion},
    {"motion", "in motion: hand empty", "#fdf3dc", is_empty_handed_in_motion},
    {"loaded", "hand at the object: once something is raised, only release opens it", "#e6f4e6", is_loaded},
}};

/// Events that end every state alike: one line in the legend instead of a label at each arrow.
bool is_everywhere(Event e) {
  return e == Event::ArmLost || e == Event::HandLost || e == Event::Interrupted;
}

std::string node(Task t) {
  if (!is_end(t)) return fmt::format("\"{}\" [style=\"rounded,filled\", fillcolor=white];", word(t));
  const char* colour = t == Task::Done ? "#9ad29a" : t == Task::Stopped ? "#f2a6a0" : "#d9d9d9";
  return fmt::format("\"{}\" [peripheries=2, style=filled, fillcolor=\"{}\"];", word(t), colour);
}

/// All rules between two states as one arrow.
std::string arrow(Task from, Task to, const std::vector<Event>& on) {
  std::string label, tooltip;
  for (const Event e : on) {
    if (!is_everywhere(e)) label += fmt::format("{}{}", label.empty() ? "" : "\\n", word(e));
    tooltip += fmt::format("{}{}: {}", tooltip.empty() ? "" : "\\n", word(e), next(from, e)->reason);
  }
  const auto first =
      std::find_if(rules().begin(), rules().end(), [&](const Rule& rule) { return rule.from == from; });
  const bool backwards = !is_end(to) && static_cast<int>(to) <= static_cast<int>(from);
  std::string_view analysis;
  if (to == Task::Stopped)
    analysis = ", color=\"#c0504d\", fontcolor=\"#c0504d\", style=dashed";
  else if (backwards)
    analysis = ", color=\"#808080\", fontcolor=\"#606060\", constraint=false";
  else if (first->to == to)
    analysis = ", penwidth=2, weight=8";
  else
    analysis = ", color=\"#808080\", fontcolor=\"#606060\"";
  return fmt::format("  \"{}\" -> \"{}\" [label=\"{}\", tooltip=\"{}\"{}];\n", word(from), word(to), label,
                     tooltip, analysis);
}

}  // namespace

std::string graph() {
  std::string out =
      "digraph colift {\n"
      "  rankdir=TB; nodesep=0.35; ranksep=0.45; fontname=\"sans-serif\"; labelloc=b;\n"
      "  label=\"Dashed: holds where it is, grip kept, until a person decides. Not written at the arrows: "
      "arm lost and hand lost stop every state;\\ninterrupted stops it too, and refuses the job while "
      "nothing "
      "moves.\";\n"
      "  node [shape=box, fontname=\"sans-serif\"];\n"
      "  edge [fontname=\"sans-serif\", fontsize=10];\n";
  for (const Group& group : kGroups) {
    out +=
        fmt::format("  subgraph cluster_{} {{\n    label=\"{}\"; style=\"rounded,filled\"; color=\"{}\";\n",
                    group.name, group.title, group.colour);
    for (int t = 0; t < kTasks; ++t)
      if (const Task task = static_cast<Task>(t); group.has(task)) out += "    " + node(task) + "\n";
    out += "  }\n";
  }
  for (int t = 0; t < kTasks; ++t)
    if (const Task task = static_cast<Task>(t); is_end(task)) out += "  " + node(task) + "\n";

  for (int f = 0; f < kTasks; ++f)
    for (int t = 0; t < kTasks; ++t) {
      std::vector<Event> on;
      for (const Rule& rule : rules())
        if (rule.from == static_cast<Task>(f) && rule.to == static_cast<Task>(t)) on.push_back(rule.on);
      if (!on.empty()) out += arrow(static_cast<Task>(f), static_cast<Task>(t), on);
    }
  return out + "}\n";
}

}  // namespace colift::control
