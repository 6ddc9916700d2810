#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "hal/config/config_file.hpp"

namespace colift::hal::example {

struct Part {
  std::string shape = "box";
  Vec3 size_m = Vec3::Zero();
  double mass_kg = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> rpy_deg = {0, 0, 0};

  template <class Visitor>
  void visit(Visitor& v) {
    v("shape", shape, Choices{"box", "cylinder"}, "What it is.");
    v("size_m", size_m, kPositive, "Full lengths.", Presence::Required);
    v("mass_kg", mass_kg, kPositive, "Unset: from the volume.");
    v("rpy_deg", rpy_deg, Range{-360, 360}, "Roll, pitch, yaw.");
  }
};

struct Group {
  std::string name;
  std::vector<Part> parts;

  template <class Visitor>
  void visit(Visitor& v) {
    v("name", name, "Name.");
    v("parts", parts, "What belongs to it.");
  }
};

struct Refine {
  int rounds = 3;
  bool robust = true;
  std::optional<Vec3> up;

  template <class Visitor>
  void visit(Visitor& v) {
    v("rounds", rounds, Range{0, 100}, "Rounds of refinement.");
    v("robust", robust, "Weights by distance.");
    v("up", up, Range{-1, 1}, "Known direction against gravity.");
  }
};

struct Ground {
  double max_tilt_deg = 50.0;
  double reach_m = std::numeric_limits<double>::infinity();
  Refine refine;

  template <class Visitor>
  void visit(Visitor& v) {
    v("max_tilt_deg", max_tilt_deg, Range{0, 90}, "Largest angle between the normal and up.");
    v("reach_m", reach_m, kPositive, "How far the ground goes.");
    v("refine", refine, "After the first fit.");
  }
};

struct App {
  std::string method = "fast";
  std::string title = "a: b # c";
  Ground ground;
  double epsilon = 1.0;
  double unset = std::numeric_limits<double>::quiet_NaN();
  std::optional<double> share;
  Vec3 at = Vec3(1, 2, 3);
  std::vector<double> weights = {1, 20};
  std::vector<Part> parts;
  std::vector<Group> groups;

  template <class Visitor>
  void visit(Visitor& v) {
    v("method", method, Choices{"fast", "thesis"}, "Which way to see.");
    v("title", title, "Any text.");
    v("ground", ground, "How the ground is found.");
    v("epsilon", epsilon, kPositive, "Weight of the robot.");
    v("unset", unset, kAny, "Nothing until somebody says so.");
    v("share", share, kFraction, "Part of the load.");
    v("at", at, kAny, "A place.");
    v("weights", weights, kNotNegative, "Some weights.");
    v("parts", parts, "Bodies.");
    v("groups", groups, "Bodies in groups.");
  }
};

/// The whole error of a text, or "accepted".
inline std::string refusal_of(const std::string& text) {
  App app;
  FieldTable table = table_of(app);
  const auto done = apply_yaml_text(table, text, "a.yaml");
  return done ? "accepted" : done.error().text();
}

inline std::string refusal_of_setting(const std::string& setting) {
  App app;
  app.parts.resize(2);
  FieldTable table = table_of(app);
  const auto done = apply_setting(table, setting);
  return done ? "accepted" : done.error().text();
}

/// A configuration that a text makes of the defaults.
inline App app_from(const std::string& text) {
  App app;
  FieldTable table = table_of(app);
  if (const auto done = apply_yaml_text(table, text, "a.yaml"); !done)
    throw std::runtime_error(done.error().text());
  return app;
}

inline std::string yaml_of(App& app) {
  return effective_yaml(table_of(app), false);
}

}  // namespace colift::hal::example
