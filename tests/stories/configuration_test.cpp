// `colift check --for COMMAND ...its options` shows what that command works with, to the bit.

#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "control/session/pipeline.hpp"
#include "tests/stories/run_program.hpp"
#include "tools/cli/config_of.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/trials/sighting.hpp"
#include "tools/log/cmd_log.hpp"
#include "tools/telemetry/mcap/mcap_reader.hpp"

using namespace colift;
using story::scratch;
using story::slurp;

namespace {

const std::string kConfig = std::string(COLIFT_SOURCE_DIR) + "/config/";
const std::vector<std::string> kMethods = [] {
  std::vector<std::string> methods{"fast"};
  if (control::make_pipeline(control::Method::Thesis)) methods.emplace_back("thesis");  // in this build
  return methods;
}();
// the simulated rig, and each file that is shipped
const std::vector<std::string> kRobots = [] {
  std::vector<std::string> robots{""};
  for (const auto& entry : std::filesystem::directory_iterator(kConfig))
    if (entry.path().extension() == ".yaml") robots.push_back(entry.path().filename().string());
  return robots;
}();

std::string shown(const std::string& words) {
  const auto r = story::run_colift("check --for " + words);
  INFO(words << "\n" << r.err);
  REQUIRE(r.code == 0);
  return r.out;
}

std::string recorded(const std::filesystem::path& file) {
  auto source = telemetry::open_file(file);
  REQUIRE(source);
  const auto reader = telemetry::McapReader::open(std::move(*source), file.string());
  REQUIRE(reader);
  const auto config = reader->attachment("config.yaml");
  REQUIRE(config);
  return config->data;
}

std::string used(const hal::Result<control::ResolvedConfig>& resolved) {
  REQUIRE(resolved);
  return control::yaml_of(*resolved);
}

/// Files and settings as a person has them, among them old habits: the method in a file, two files, T1.
tools::CommonOptions common_options() {
  static const auto file = scratch() / "mine.yaml";
  std::ofstream(file) << "arm_mode: t1\ndecision: {weights: {omega1_per_m: 7}}\ncandidates: {step_m: 0.02}\n";
  tools::CommonOptions common;
  common.config_files = {file.string()};
  common.settings = {"task.partner_timeout_s=1", "decision.near_partner_m=0.2"};
  return common;
}
std::string words_of(const tools::CommonOptions& common) {
  std::string words;
  for (const auto& file : common.config_files) words += " --config " + file;
  for (const auto& setting : common.settings) words += " --set " + setting;
  return words;
}

}  // namespace

TEST_CASE("what check --for run shows is what stands in the run's recording", "[program][config]") {
  const tools::CommonOptions common = common_options();
  for (const std::string& method : kMethods) {
    const auto scenario = scratch() / "higher.yaml";
    std::string text = slurp(kConfig + "scenario/pipe.yaml");
    const auto height = text.find("height: 0.05");
    REQUIRE(height != std::string::npos);
    std::ofstream(scenario) << text.replace(height, 12, "height: 0.07");
    const std::string options =
        " --scenario " + scenario.string() + " --share 0.3 --method " + method + words_of(common);
    // nobody comes within a second: the run is over soon after its first pictures
    const auto file = scratch() / (method + ".mcap");
    const auto run = story::run_colift("run" + options + " --dry-run --record " + file.string());
    INFO(run.err);
    REQUIRE(run.code == 1);
    const std::string config = recorded(file);
    CHECK(config == shown("run" + options));
    // other places of --for, and one that says what is asked for in one word
    CHECK(config == story::run_colift("check" + options + " --for run").out);
    CHECK(config == story::run_colift("check --for=run" + options).out);
    CHECK_THAT(config, Catch::Contains("share: 0.3  # --share") && Catch::Contains("step_m: 0.02  # ") &&
                           Catch::Contains("lift_height_m: 0.07  # scenario ") &&
                           Catch::Contains("# arm_mode t1"));
    // and its replay works with the same numbers
    tools::LogOptions log;
    log.file = file;
    CHECK(used(tools::config_of_replay({}, log)) == shown("log replay " + file.string()));
    const auto replay = story::run_colift("log replay " + file.string() + " --json");
    INFO(replay.out);
    CHECK(replay.code == 0);
  }
}

TEST_CASE("check --for shows the configuration of every command, method and shipped robot",
          "[program][config]") {
  const tools::CommonOptions common = common_options();
  const std::string words = words_of(common);
  for (const std::string& method : kMethods) {
    const std::string named = " --method " + method + words;
    for (const std::string& robot : kRobots) {
      tools::RunOptions run;
      run.method = method;
      std::string rig;
      if (!robot.empty()) {
        // what only exists on that site
        auto text = slurp(kConfig + robot);
        if (const auto at = text.find("calibration: camera.yaml"); at != std::string::npos)
          text.insert(at, "# ");
        run.robot = scratch() / robot;
        std::ofstream(*run.robot) << text;
        rig = " --robot " + run.robot->string();
      }
      CHECK(used(tools::config_of_run(common, run)) == shown("run" + named + rig));
      const std::string with_robot = rig + words;
      if (method == "fast") CHECK(shown("recover" + with_robot) == shown("run" + with_robot));
      for (const char* verb : {"hal arm state", "hal hand state", "hal camera info"})
        CHECK(used(tools::config_of(common, control::Command::Hal)) == shown(verb + with_robot));
      CHECK(used(tools::config_of(common, control::Command::Calibrate)) == shown("calibrate" + with_robot));
    }
    tools::LookOptions analysis;
    analysis.method = method;
    CHECK(used(tools::config_of_look(common, analysis)) == shown("look" + named));
    tools::DecideOptions decide;
    decide.look = analysis;
    decide.epsilon = "2";
    CHECK(used(tools::config_of_decide(common, decide)) == shown("decide --epsilon 2" + named));
    for (const experiments::Experiment& e : experiments::all_experiments()) {
      const auto trials = experiments::resolved_for(*control::method_named(method), e.task);
      CHECK(control::yaml_of(trials) == shown("experiment " + e.name + " --method " + method));
    }
  }
}

TEST_CASE("a run on the emulated rig records the configuration that check shows", "[program][config]") {
  // with ports of its own: other tests serve the usual ones
  std::string text = slurp(kConfig + "emulated.yaml");
  const auto replace = [&](const std::string& old, const std::string& with) {
    const auto at = text.find(old);
    REQUIRE(at != std::string::npos);
    text.replace(at, old.size(), with);
  };
  replace("krc: 127.0.0.1,", "krc: 127.0.0.1, port: 49961,");
  replace("29536", "29561");
  replace("@colift-kinect", "@colift-kinect-configuration");
  const auto robot = scratch() / "elsewhere.yaml";
  std::ofstream(robot) << text;
  const std::string options =
      " --robot " + robot.string() +
      " --set task.partner_timeout_s=1 --set task.lift_height_m=0.04 --set arm_mode=t1";
  const auto file = scratch() / "emulated.mcap";
  const auto run = story::run_colift("run" + options + " --dry-run --record " + file.string());
  INFO(run.err);
  REQUIRE(run.code == 1);
  CHECK(recorded(file) == shown("run" + options));
}

TEST_CASE("the configuration of a robot whose camera was not calibrated yet is shown all the same",
          "[program][config]") {
  const auto r = story::run_colift("check --for run --robot real");
  CHECK(r.code == 2);
  CHECK_THAT(r.err, Catch::Contains("camera.yaml"));
  CHECK(r.out == shown("run"));
}

TEST_CASE("check says whose configuration it shows, who said what, and what it cannot show",
          "[program][config]") {
  const auto plain = nlohmann::json::parse(story::run_colift("check --json").out);
  CHECK(plain["for"] == "run");
  CHECK(plain["config"] == shown("run"));
  CHECK(plain["changed"]["decision.max_lever_m"] == "run's default");
  const auto decide =
      nlohmann::json::parse(story::run_colift("check --for decide --method thesis --share 0.2 --json").out);
  CHECK(decide["for"] == "decide");
  CHECK(decide["changed"]["decision.weights.epsilon"] == "decision.share (--share)");
  CHECK(decide["changed"]["decision.max_sideways"] == "method thesis");
  CHECK_THAT(shown("run --explain"), Catch::Contains("# Height of the lift"));
  for (const char* words : {"rank", "doctor", "emulate krc", "log info"}) {
    const auto r = story::run_colift(std::string("check --for ") + words);
    INFO(words << "\n" << r.err);
    CHECK(r.code == 2);
    CHECK_THAT(r.err, Catch::Contains("takes no configuration"));
  }
  CHECK(story::run_colift("check --for").code == 2);
  CHECK(story::run_colift("check --for frobnicate").code == 2);
  CHECK(story::run_colift("check --for run --share 2").code == 2);
}
