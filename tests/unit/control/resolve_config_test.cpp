// The one maker of configurations: who wins, what is never overwritten, who said what.
#include "control/config/resolve_config.hpp"

#include <unistd.h>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <regex>

#include "planner/grasp/grasp_decision.hpp"

using namespace colift;
using namespace colift::control;

namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

/// A file with a text, gone with it.
struct TextFile {
  std::filesystem::path path;
  explicit TextFile(const std::string& text) {
    static int n = 0;
    path = std::filesystem::temp_directory_path() /
           ("colift-resolve-" + std::to_string(::getpid()) + "-" + std::to_string(n++) + ".yaml");
    std::ofstream(path) << text;
  }
  ~TextFile() { std::filesystem::remove(path); }
  TextFile(const TextFile&) = delete;
  TextFile& operator=(const TextFile&) = delete;
};

ConfigRequest with(std::vector<std::string> settings, const char* method = nullptr) {
  ConfigRequest request;
  request.settings = std::move(settings);
  if (method != nullptr) request.options.push_back({"method", method, "--method"});
  return request;
}

ResolvedConfig made(const ConfigRequest& request) {
  auto resolved = resolve_config(request);
  INFO((resolved ? "" : resolved.error().text()));
  REQUIRE(resolved);
  return std::move(*resolved);
}

std::string refusal(const ConfigRequest& request) {
  const auto resolved = resolve_config(request);
  return resolved ? "accepted" : resolved.error().text();
}

/// Without the comments.
std::string values(const ResolvedConfig& resolved) {
  return std::regex_replace(yaml_of(resolved), std::regex("  # .*"), "");
}

ConfigRequest replay_of(const std::string& yaml, Method method, bool complete = true) {
  ConfigRequest request;
  request.command = Command::Replay;
  request.recorded = {yaml, method, complete};
  return request;
}

}  // namespace

TEST_CASE("each command has its own defaults") {
  CHECK(made(with({})).config.candidates.max_turn_deg == 40.0);
  CHECK(made(with({})).origins.at("candidates.max_turn_deg") == "run's default");
  ConfigRequest analysis;
  analysis.command = Command::SceneAnalysis;
  CHECK(made(analysis).config.candidates.max_turn_deg == 0.0);
  CHECK(made(analysis).origins.empty());
}

TEST_CASE("what a person sets is never overwritten by the method") {
  const TextFile file("decision: {weights: {omega1_per_m: 7}}\n");
  ConfigRequest request =
      with({"decision.weights.epsilon=3", "decision.weights.omega2_per_m=8", "decision.max_lever_m=0.5",
            "decision.max_sideways=0.4", "candidates.step_m=0.01", "tracker.dwell_s=0.2"},
           "thesis");
  request.files = {file.path.string()};
  const ResolvedConfig r = made(request);
  CHECK(r.method == Method::Thesis);
  CHECK(r.config.decision.weights.epsilon == 3.0);
  CHECK(r.config.decision.weights.omega1_per_m == 7.0);
  CHECK(r.config.decision.weights.omega2_per_m == 8.0);
  CHECK(r.config.decision.max_lever_m == 0.5);
  CHECK(r.config.decision.max_sideways == 0.4);
  CHECK(r.config.candidates.step_m == 0.01);
  CHECK(r.config.tracker.dwell_s == 0.2);
  CHECK(r.config.tracker.let_go_s == 0.8);
  CHECK(r.origins.at("decision.weights.omega1_per_m") == file.path.string() + ":1");
  CHECK(r.origins.at("tracker.let_go_s") == "method thesis");
}

TEST_CASE("the method's defaults come with its name, wherever that stands") {
  const TextFile file("method: thesis\n");
  ConfigRequest in_file;
  in_file.files = {file.path.string()};
  const ConfigRequest requests[] = {in_file, with({"method=thesis"}), with({}, "thesis")};
  for (const ConfigRequest& request : requests) {
    const ResolvedConfig r = made(request);
    CHECK(r.method == Method::Thesis);
    CHECK(r.config.method == "thesis");
    CHECK(r.config.decision.max_lever_m == kInf);
    CHECK(r.config.decision.weights.omega1_per_m == 1.0);
    CHECK_FALSE(r.config.candidates.edges);
    CHECK(r.config.candidates.max_turn_deg == 0.0);
  }
  // the option has the last word, and nothing of the other method stays
  in_file.options.push_back({"method", "fast", "--method"});
  CHECK(values(made(in_file)) == values(made(with({}))));
  CHECK(refusal(with({}, "quick")).find("--method quick") == 0);
}

TEST_CASE("by the thesis's method the cost alone judges a grasp beside the partner's") {
  // the partner holds almost under the centre of gravity; the cheapest grasp is 12 cm from his hand
  const auto id_chosen = [](const char* method) {
    planner::GraspCandidate beside, far;
    beside.position = {0.07, 0.0, 0.7};
    far.position = {0.6, 0.0, 0.7};
    far.id = 1;
    std::vector<planner::GraspCandidate> candidates{beside, far};
    planner::DecisionInput input;
    input.partner.position = {-0.05, 0.0, 0.7};
    input.cog = {0.0, 0.0, 0.7};
    const auto decision = planner::decide_grasp(candidates, input, made(with({}, method)).config.decision);
    REQUIRE(decision);
    REQUIRE(decision->chosen);
    return candidates[*decision->chosen].id;
  };
  CHECK(id_chosen("thesis") == 0);
  CHECK(id_chosen("fast") == 1);
  CHECK(made(with({}, "thesis")).config.thesis.partner_reference == "object");
  CHECK(made(with({"decision.near_partner_m=0.2"}, "thesis")).config.decision.near_partner_m == 0.2);
}

TEST_CASE("share and epsilon say the same thing, and the last word counts") {
  const auto epsilon = [](const ConfigRequest& r) { return made(r).config.decision.weights.epsilon; };
  CHECK(epsilon(with({"decision.share=0.2"})) == 2.0);
  CHECK(epsilon(with({"decision.share=0.2"}, "thesis")) == 2.0);
  CHECK(epsilon(with({"decision.weights.epsilon=5", "decision.share=0.2"})) == 2.0);
  const ResolvedConfig later = made(with({"decision.share=0.2", "decision.weights.epsilon=5"}));
  CHECK(later.config.decision.weights.epsilon == 5.0);
  CHECK_FALSE(later.config.decision.share);
  // an option over a file, either way
  const TextFile share("decision: {share: 0.2}\n"), cost_weight("decision: {weights: {epsilon: 5}}\n");
  ConfigRequest request;
  request.files = {share.path.string()};
  request.options.push_back({"decision.weights.epsilon", "3", "--epsilon"});
  CHECK(epsilon(request) == 3.0);
  request.files = {cost_weight.path.string()};
  request.options.back() = {"decision.share", "0.5", "--share"};
  const ResolvedConfig half = made(request);
  CHECK(half.config.decision.weights.epsilon == 1.0);
  CHECK(half.config.decision.share == 0.5);
  CHECK(half.origins.at("decision.weights.epsilon") == "decision.share (--share)");
  // taken back: what was said before it
  CHECK(epsilon(with({"decision.weights.epsilon=5", "decision.share=0.2", "decision.share=~"})) == 5.0);
}

TEST_CASE("one file with a share and another epsilon is refused; with the same it is read") {
  const TextFile differ("decision: {share: 0.2, weights: {epsilon: 1.5}}\n");
  ConfigRequest request;
  request.files = {differ.path.string()};
  CHECK_THAT(refusal(request),
             Catch::StartsWith(differ.path.string() + ":1: ") && Catch::Contains("contradict each other"));
  const TextFile same("decision: {share: 0.2, weights: {epsilon: 2}}\n");
  request.files = {same.path.string()};
  CHECK(made(request).config.decision.weights.epsilon == 2.0);
  for (const char* bad : {"decision.share=0", "decision.share=1"})
    CHECK_THAT(refusal(with({bad})), Catch::Contains("more than 0 and less than 1"));
}

TEST_CASE("the scenario's task goes over the defaults and under what a person says") {
  ConfigRequest request = with({"task.hold_s=9"});
  request.task = {"scenario pipe", 0.11, 3.0};
  const ResolvedConfig r = made(request);
  CHECK(r.config.task.lift_height_m == 0.11);
  CHECK(r.config.task.hold_s == 9.0);
  CHECK(r.origins.at("task.lift_height_m") == "scenario pipe");
  CHECK(r.origins.at("task.hold_s") == "--set");
}

TEST_CASE("T1 comes last and only makes slower") {
  const ResolvedConfig r = made(with({"arm_mode=t1", "motion.max_joint_rad_s=0.1"}));
  CHECK(r.config.motion.max_joint_rad_s == 0.1);
  CHECK(r.origins.at("motion.max_joint_rad_s") == "--set");
  CHECK(r.config.guard_arm.max_velocity_rad_s == 0.24);
  CHECK(r.origins.at("guard_arm.max_velocity_rad_s") == "arm_mode t1");
}

TEST_CASE("a file may be a pipe: it is read once") {
  int ends[2];
  REQUIRE(::pipe(ends) == 0);
  const std::string text = "method: thesis\ndecision: {mass_kg: 3}\n";
  REQUIRE(::write(ends[1], text.data(), text.size()) == static_cast<ssize_t>(text.size()));
  ::close(ends[1]);
  ConfigRequest request;
  request.files = {"/dev/fd/" + std::to_string(ends[0])};
  const ResolvedConfig r = made(request);
  ::close(ends[0]);
  CHECK(r.method == Method::Thesis);
  CHECK(r.config.decision.mass_kg == 3.0);
}

TEST_CASE("a configuration reads back to the same bits, as a file and as a recording") {
  for (const char* method : {"fast", "thesis"}) {
    const ResolvedConfig first =
        made(with({"decision.share=0.3", "arm_mode=t1", "decision.mass_kg=0.1"}, method));
    const TextFile file(yaml_of(first, true));
    ConfigRequest from_file;
    from_file.files = {file.path.string()};
    CHECK(values(made(from_file)) == values(first));
    const ResolvedConfig replayed = made(replay_of(yaml_of(first), first.method));
    CHECK(values(replayed) == values(first));
    CHECK(replayed.warnings.empty());
  }
}

TEST_CASE("a recording of another version: missing keys are defaults, unknown ones are left out and named") {
  const ResolvedConfig r =
      made(replay_of("gone: 1\ndecision: {mass_kg: 2, old_limit_n: 4}\n", Method::Thesis));
  CHECK(r.config.decision.mass_kg == 2.0);
  CHECK(r.config.method == "thesis");
  CHECK(r.config.decision.weights.omega1_per_m == 1.0);
  REQUIRE(r.warnings.size() == 2);
  CHECK_THAT(r.warnings[0], Catch::StartsWith("recorded config.yaml:1:1: unknown key \"gone\""));
}

TEST_CASE("an old recording of the thesis's method: its candidates are those that were used") {
  // as version 0.1 wrote it: candidates of the fast method, --method not written through
  const std::string old =
      "method: fast\ncandidates: {max_turn_deg: 40, side_clearance_m: 0.03, edges: true}\n"
      "decision: {max_sideways: .inf, max_lever_m: .inf}\n";
  const ResolvedConfig r = made(replay_of(old, Method::Thesis, false));
  CHECK(r.method == Method::Thesis);
  CHECK(values(r) == values(made(with({}, "thesis"))));
  // what is set on purpose still counts
  ConfigRequest changed = replay_of(old, Method::Thesis, false);
  changed.settings = {"candidates.step_m=0.01"};
  CHECK(made(changed).config.candidates.step_m == 0.01);
}

TEST_CASE("a replay with another method takes its defaults, and leaves what was set") {
  const std::string recorded = yaml_of(made(with({"decision.weights.omega1_per_m=3"})));
  ConfigRequest request = replay_of(recorded, Method::Fast);
  request.settings = {"method=thesis"};
  const ResolvedConfig r = made(request);
  CHECK(r.method == Method::Thesis);
  CHECK(r.config.decision.weights.omega1_per_m == 3.0);
  CHECK(r.config.decision.weights.omega2_per_m == 1.0);
  CHECK_FALSE(r.config.candidates.edges);
}

TEST_CASE("a support that the thesis's method does not have is refused, whoever asks for it") {
  ConfigRequest request = with({"method=thesis", "support=table"});
  auto refused = resolve_config(request);
  REQUIRE_FALSE(refused);
  CHECK(refused.error().where == "--set");
  request.settings = {"method=thesis"};
  request.options.push_back({"support", "table", "--support"});
  refused = resolve_config(request);
  REQUIRE_FALSE(refused);
  CHECK(refused.error().where == "--support");
  request.options.back().value = "floor";
  CHECK(resolve_config(request));
}

TEST_CASE("nobody but resolve_config makes the configuration of a command, and nobody changes it") {
  // the one exception is a lift at full speed without monitoring, which no configuration allows
  const std::regex maker(
      R"(run_defaults\(|apply_command_line\(|table_of\((\w+\.)?config\)|set_method_defaults\()"
      R"(|\bconfig\.(decision|task|candidates|test_lift|monitor|motion)\b[\w.]* = )");
  int files = 0;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(std::string(COLIFT_SOURCE_DIR) + "/tools")) {
    const std::string path = entry.path().string();
    const bool source = path.ends_with(".cpp") && path.find("/tools/examples/") == std::string::npos;
    if (!source || path.find("node_modules") != std::string::npos) continue;
    ++files;
    std::ifstream in(path);
    std::string text{std::istreambuf_iterator<char>(in), {}};
    text = std::regex_replace(text, std::regex("if \\(with.without_monitor\\)[^;]*;"), "");
    INFO(path);
    std::smatch found;
    CHECK_FALSE(std::regex_search(text, found, maker));
  }
  CHECK(files > 50);
}
