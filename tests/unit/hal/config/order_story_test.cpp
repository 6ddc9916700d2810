#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "example_config.hpp"

using namespace colift::hal;
using namespace colift::hal::example;

namespace {

/// A command line with its files: `--config`s and `--set`s in the order given.
class Story {
 public:
  Story()
      : folder_(std::filesystem::temp_directory_path() /
                ("colift_config_story_" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  Story(const Story&) = delete;
  Story& operator=(const Story&) = delete;
  ~Story() { std::filesystem::remove_all(folder_); }

  App app;
  FieldTable table = table_of(app);

  Result<> config(const std::string& name, const std::string& text) {
    const auto path = folder_ / name;
    std::ofstream(path) << text;
    return apply_yaml_file(table, path);
  }
  Result<> set(const std::string& text) { return apply_setting(table, text); }

  /// Origin of a field, without the folder.
  [[nodiscard]] std::string origin(const std::string& path) const {
    const std::string origin = table.find(path)->origin;
    const std::string folder = folder_.string() + "/";
    return origin.starts_with(folder) ? origin.substr(folder.size()) : origin;
  }
  [[nodiscard]] std::filesystem::path file(const std::string& name) const { return folder_ / name; }

 private:
  std::filesystem::path folder_;
};

}  // namespace

TEST_CASE("the later file wins, value by value", "[config][story]") {
  Story story;
  REQUIRE(story.config("robot.yaml", "epsilon: 2\nground:\n  max_tilt_deg: 10\n  refine: {rounds: 5}\n"));
  REQUIRE(story.config("room.yaml", "# this room only\nground:\n  max_tilt_deg: 20\n"));

  CHECK(story.app.epsilon == 2.0);
  CHECK(story.app.ground.max_tilt_deg == 20.0);
  CHECK(story.app.ground.refine.rounds == 5);
  CHECK(story.origin("epsilon") == "robot.yaml:1");
  CHECK(story.origin("ground.max_tilt_deg") == "room.yaml:3");
  CHECK(story.origin("ground.refine.rounds") == "robot.yaml:4");
  CHECK(story.origin("share") == "default");
}

TEST_CASE("a list is replaced as a whole by a later file", "[config][story]") {
  Story story;
  REQUIRE(story.config(
      "a.yaml", "parts: [{size_m: [1, 1, 1], mass_kg: 3}, {size_m: [2, 2, 2]}]\nweights: [1, 2, 3]\n"));
  REQUIRE(story.config("b.yaml", "parts: [{size_m: [5, 5, 5]}]\nweights: [9]\n"));

  REQUIRE(story.app.parts.size() == 1);
  CHECK(story.app.parts[0].size_m == Vec3(5, 5, 5));
  CHECK(std::isnan(story.app.parts[0].mass_kg));
  CHECK(story.app.weights == std::vector<double>{9});
  CHECK(story.origin("parts") == "b.yaml:1");
}

TEST_CASE("a setting wins over the files, the last setting over the one before", "[config][story]") {
  Story story;
  REQUIRE(story.config("a.yaml", "epsilon: 2\n"));
  REQUIRE(story.set("epsilon=3"));
  REQUIRE(story.set("epsilon=4"));

  CHECK(story.app.epsilon == 4.0);
  CHECK(story.origin("epsilon") == "--set");
}

TEST_CASE("a slip in the second file leaves the first in force", "[config][story]") {
  Story story;
  REQUIRE(story.config("a.yaml", "epsilon: 2\nshare: 0.5\n"));
  const auto slip = story.config("b.yaml", "share: 0.75\n\nepsillon: 3\n");

  REQUIRE_FALSE(slip);
  CHECK(slip.error().where == story.file("b.yaml").string() + ":3:1");
  CHECK(slip.error().detail == "unknown key \"epsillon\"; did you mean \"epsilon\"?");
  CHECK(story.app.share == 0.5);
  CHECK(story.origin("share") == "a.yaml:2");
}

TEST_CASE("what check prints is itself a file that repeats the run", "[config][story]") {
  Story story;
  REQUIRE(
      story.config("a.yaml", "title: 'a: b'\nepsilon: 0.30000000000000004\nparts: [{size_m: [1, 1, 1]}]\n"));
  REQUIRE(story.set("ground.refine.up=[0, 0, 1]"));

  Story again;
  REQUIRE(again.config("effective.yaml", effective_yaml(story.table, true)));
  CHECK(again.app.epsilon == 0.30000000000000004);
  CHECK(again.app.ground.refine.up == Vec3(0, 0, 1));
  CHECK(yaml_of(again.app) == yaml_of(story.app));
}

TEST_CASE("a file that stands for itself is one call", "[config][story]") {
  Story story;
  std::ofstream(story.file("part.yaml")) << "shape: cylinder\nsize_m: [0.1, 0.1, 1]\n";
  const auto part = load_yaml<Part>(story.file("part.yaml"));
  REQUIRE(part);
  CHECK(part->shape == "cylinder");

  std::ofstream(story.file("half.yaml")) << "shape: cylinder\n";
  const auto half = load_yaml<Part>(story.file("half.yaml"));
  REQUIRE_FALSE(half);
  CHECK(half.error().where == story.file("half.yaml").string());
  CHECK(half.error().detail == "size_m is missing, expected a list of 3 numbers, each greater than 0");

  REQUIRE_FALSE(load_yaml<Part>(story.file("none.yaml")));
}

TEST_CASE("a command line is files in order, then settings in order", "[config][story]") {
  Story story;
  std::ofstream(story.file("a.yaml")) << "epsilon: 2\nshare: 0.5\n";
  std::ofstream(story.file("b.yaml")) << "epsilon: 3\ntitle: b\n";
  const std::string a = story.file("a.yaml").string();
  const std::string b = story.file("b.yaml").string();

  REQUIRE(apply_command_line(story.table, std::vector{a, b, a},
                             std::vector<std::string>{"share=0.1", "share=0.2"}));
  CHECK(story.app.epsilon == 2.0);
  CHECK(story.app.title == "b");
  CHECK(story.app.share == 0.2);

  const auto slip = apply_command_line(story.table, std::vector{a}, std::vector<std::string>{"shaer=1"});
  REQUIRE_FALSE(slip);
  CHECK(slip.error().text() == "--set shaer=1: unknown key \"shaer\"; did you mean \"share\"?");
}
