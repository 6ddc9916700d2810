#include "tools/analyse/rank_json.hpp"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/unit/planner/load_sharing/reference.hpp"
#include "tools/analyse/cmd_rank.hpp"

using colift::hal::Error;
using colift::tools::parse_rank_problem;
using nlohmann::json;

namespace {

const std::string kExample = R"({"cog":[0,0,0], "partner":[-0.4,0,0], "candidates":[[0.4,0,0],[0.2,0,0]],
 "wrenches":[[0,0,40,0,0,0]],
 "weights":{"epsilon":1,"omega1":1,"omega2":1},
 "limits":{"partner":{"force":30,"torque":5},"robot":{"force":60,"torque":8}}})";

std::string with(const std::string& from, const std::string& to) {
  std::string text = kExample;
  const auto at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

Error refused(const std::string& text) {
  const auto r = parse_rank_problem(text, "p.json");
  INFO(text.substr(0, 200));
  REQUIRE_FALSE(r);
  CHECK(r.error().code == colift::hal::ErrorCode::BadInput);
  CHECK(r.error().detail.find('\n') == std::string::npos);
  return r.error();
}

/// Runs the command on a file with this text; what it wrote and returned.
struct Ran {
  int exit = -1;
  std::string out, err;
};
Ran run(const std::string& text, bool as_json) {
  const auto folder = std::filesystem::temp_directory_path() / ("colift_rank_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  const auto input = folder / "problem.json", out = folder / "out", err = folder / "err";
  std::ofstream(input, std::ios::binary) << text;
  std::fflush(stdout);
  std::fflush(stderr);
  const int old_out = ::dup(1), old_err = ::dup(2);
  std::FILE* to_out = std::fopen(out.c_str(), "wb");
  std::FILE* to_err = std::fopen(err.c_str(), "wb");
  ::dup2(::fileno(to_out), 1);
  ::dup2(::fileno(to_err), 2);
  Ran r;
  r.exit = colift::tools::cmd_rank(input, as_json);
  std::fflush(stdout);
  std::fflush(stderr);
  ::dup2(old_out, 1);
  ::dup2(old_err, 2);
  ::close(old_out);
  ::close(old_err);
  std::fclose(to_out);
  std::fclose(to_err);
  const auto slurp = [](const std::filesystem::path& path) {
    std::stringstream all;
    all << std::ifstream(path).rdbuf();
    return all.str();
  };
  r.out = slurp(out);
  r.err = slurp(err);
  std::filesystem::remove_all(folder);
  return r;
}

}  // namespace

TEST_CASE("the example of the contract gives the answer of the contract", "[rank_json]") {
  const Ran r = run(kExample, true);
  REQUIRE(r.exit == 0);
  CHECK(r.err.empty());
  const json answer = json::parse(r.out);
  CHECK(answer["schema"] == "colift.rank/1");
  CHECK(answer["best"] == 0);
  REQUIRE(answer["ranking"].size() == 2);
  const json& first = answer["ranking"][0];
  CHECK(first["candidate"] == 0);
  CHECK(first["feasible"] == true);
  CHECK(first["cost"].get<double>() == Approx(800.0).epsilon(1e-12));
  CHECK(first["share"].get<double>() == Approx(0.5).epsilon(1e-12));
  CHECK(first["poses"][0]["robot"]["force"][2].get<double>() == Approx(20).epsilon(1e-12));
  CHECK(first["poses"][0]["partner"]["torque"].size() == 3);
  CHECK_FALSE(first.contains("reason"));
}

TEST_CASE("the read problem is the written one", "[rank_json]") {
  const auto p = parse_rank_problem(with("[0,0,0]", "[1.5,-2e-3,7]"), "p").value();
  CHECK(p.cog == colift::hal::Vec3(1.5, -2e-3, 7));
  CHECK(p.candidates[1].x() == 0.2);
  CHECK(p.wrenches[0].force.z() == 40);
  CHECK(p.limits->robot.torque_nm == 8);
  CHECK(p.weights.omega1_per_m == 1);

  const auto open =
      parse_rank_problem(with(R"({"partner":{"force":30,"torque":5},"robot":{"force":60,"torque":8}})",
                              R"({"robot":{"torque":8}})"),
                         "p")
          .value();
  CHECK(std::isinf(open.limits->partner.force_n));
  CHECK(open.limits->robot.torque_nm == 8);
}

TEST_CASE("printed numbers read back to the same bits", "[rank_json]") {
  reference::Dice dice(31);
  colift::planner::RankProblem p;
  p.partner = dice.vector(1);
  for (int i = 0; i < 50; ++i) p.candidates.push_back(dice.vector(1));
  p.wrenches = {dice.wrench(1e-7, 3), dice.wrench(1e9, 1e-3)};
  p.limits = colift::planner::SharingLimits{{7e8, 1e9}, {7e8, 1e9}};
  const auto ranked = colift::planner::rank(p).value();
  const json answer = json::parse(colift::tools::rank_to_json(ranked));
  for (std::size_t i = 0; i < ranked.ranking.size(); ++i) {
    const auto& entry = ranked.ranking[i];
    const json& printed = answer["ranking"][i];
    REQUIRE(printed["feasible"] == entry.feasible);
    if (!entry.feasible) {
      CHECK(printed["reason"] == entry.reason);
      CHECK_FALSE(printed.contains("cost"));
      continue;
    }
    CHECK(printed["cost"].get<double>() == entry.cost);
    CHECK(printed["share"].get<double>() == *entry.share);
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(printed["poses"][1]["robot"]["torque"][k].get<double>() ==
            entry.poses[1].robot.torque[static_cast<Eigen::Index>(k)]);
    }
  }
}

TEST_CASE("nothing feasible is an answer, not an error", "[rank_json]") {
  const std::string weak = with(R"("force":60)", R"("force":5)");
  const Ran r = run(weak, true);
  CHECK(r.exit == 0);
  const json answer = json::parse(r.out);
  CHECK(answer["best"].is_null());
  CHECK(answer["ranking"][1]["reason"] == "needs 40 N along z; partner 30 N and robot 5 N give 35 N");
  CHECK(run(weak, false).out.find("best: none") != std::string::npos);
}

TEST_CASE("people get a table", "[rank_json]") {
  const Ran r = run(kExample, false);
  CHECK(r.exit == 0);
  CHECK(r.out.find("best: candidate 0 of 2 (2 feasible)\n") != std::string::npos);
  CHECK(r.out.find("50.0 %") != std::string::npos);
}

TEST_CASE("a wrong document is refused with its place", "[rank_json]") {
  Error e = refused(with("[0.2,0,0]", "[0.2,\"a\",0]"));
  CHECK(e.where == "p.json:1:68");
  CHECK(e.detail == "candidates[1][1] is the text \"a\", expected a number");

  e = refused(with("\"weights\"", "\"wieghts\""));
  CHECK(e.detail.find("unknown key \"wieghts\"; the nearest known is \"weights\"") != std::string::npos);
  CHECK(e.where.rfind("p.json:3:", 0) == 0);

  CHECK(refused(with("\"omega2\":1", "\"omega3\":1")).detail.find("nearest known is \"omega") !=
        std::string::npos);
  CHECK(refused(with(",\"omega2\":1", "")).detail == "weights has no key \"omega2\", which is required");
  CHECK(refused(with("\"cog\":[0,0,0], ", "")).detail ==
        "the document has no key \"cog\", which is required");
  CHECK(refused(with("\"epsilon\":1", "\"epsilon\":0")).where == "p.json:3:23");
  CHECK(refused(with("\"epsilon\":1", "\"epsilon\":-1")).detail.find("weights.epsilon is -1") == 0);
  CHECK(refused(with("\"omega1\":1", "\"omega1\":-2")).detail.find("weights.omega1 is -2") == 0);
  CHECK(refused(with("\"force\":30", "\"force\":-30")).detail.find("limits.partner.force is -30") == 0);
  CHECK(
      refused(with("[0,0,40,0,0,0]", "[0,0,40,0,0]")).detail.find("wrenches[0] is a list of 5, expected 6") ==
      0);
  CHECK(refused(with("[-0.4,0,0]", "[-0.4,0,0,0]")).detail.find("partner is a list of 4, expected 3") == 0);
  CHECK(refused(with("[-0.4,0,0]", "null")).detail.find("partner is null") == 0);
  CHECK(refused(with("[[0.4,0,0],[0.2,0,0]]", "[]")).detail.find("candidates is empty") == 0);
  CHECK(refused(with("[[0,0,40,0,0,0]]", "[]")).detail.find("wrenches is empty") == 0);
  CHECK(refused(with("\"epsilon\":1", "\"epsilon\":true")).detail.find("true or false, expected a number") !=
        std::string::npos);
  CHECK(refused(with("\"cog\":[0,0,0]", "\"cog\":[0,0,0],\"cog\":[0,0,1]")).detail.find("comes twice") !=
        std::string::npos);
  CHECK(refused("[]").detail == "the document is a list of 0, expected an object");
  CHECK(refused("3").where == "p.json:1:1");
}

TEST_CASE("what is not JSON is refused with its place", "[rank_json]") {
  for (const char* literal :
       {"NaN", "Infinity", "-Infinity", "nan", "1e999", "-1e999", "0x10", "01", "+1", ".5", "1."}) {
    const Error e = refused(with("40,0,0,0", std::string(literal) + ",0,0,0"));
    CHECK(e.where.rfind("p.json:2:", 0) == 0);
  }
  CHECK(refused("").detail.find("empty") != std::string::npos);
  CHECK(refused(" \n\t ").detail.find("empty") != std::string::npos);
  CHECK(refused(kExample + "x").where.rfind("p.json:4:", 0) == 0);
  CHECK(refused(std::string("\0\0\0", 3)).where == "p.json:1:1");
  refused("\xff\xfe{");
  refused("{\"a\xc3(\":1}");
  for (std::size_t n = 0; n < kExample.size(); ++n) refused(kExample.substr(0, n));
}

TEST_CASE("no flipped byte crashes the reader", "[rank_json]") {
  reference::Dice dice(32);
  int accepted = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string text = kExample;
    for (int k = dice.below(4); k >= 0; --k)
      text[static_cast<std::size_t>(dice.below(static_cast<int>(text.size())))] =
          static_cast<char>(dice.below(256));
    const auto p = parse_rank_problem(text, "p");
    accepted += p.has_value();
    if (p) CHECK_NOTHROW(colift::planner::rank(*p));
  }
  CHECK(accepted < 1500);
}

TEST_CASE("a nesting bomb is refused before it costs anything", "[rank_json]") {
  CHECK(refused(std::string(200000, '[')).detail.find("nested deeper") != std::string::npos);
  std::string objects;
  for (int i = 0; i < 100000; ++i) objects += "{\"a\":";
  CHECK(refused(objects).detail.find("nested deeper") != std::string::npos);
  CHECK(refused(with("[0.4,0,0]", std::string(100000, '[') + std::string(100000, ']')))
            .detail.find("nested deeper") != std::string::npos);
}

TEST_CASE("files that are none are refused", "[rank_json]") {
  CHECK(colift::tools::cmd_rank("/nonexistent/colift.json", true) == 2);
  CHECK(colift::tools::cmd_rank("/", true) == 2);
  CHECK(colift::tools::cmd_rank("/dev/zero", true) == 2);
  const Ran r = run("{", true);
  CHECK(r.exit == 2);
  CHECK(r.out.empty());
  CHECK(r.err.find("problem.json:1:2: is not valid JSON") != std::string::npos);
}
