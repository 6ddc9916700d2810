// A campaign gives the same figures however it is split, stopped and continued.

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tools/experiments/campaign.hpp"
#include "tools/experiments/outcome.hpp"
#include "tools/experiments/worst.hpp"

using namespace colift;
using namespace colift::experiments;
namespace fs = std::filesystem;

namespace {

/// An experiment that needs no world: two numbers from the seed, two details.
Experiment toy() {
  Experiment e;
  e.name = "toy";
  e.title = "Toy";
  e.thesis = "none";
  e.question = "Numbers.";
  e.default_trials = 9;
  e.columns = {"value", "words"};
  e.detail_columns = {"part"};
  e.run = [](const Trial& t) {
    const double v = static_cast<double>(t.own_seed(1) % 1000) / 7.0;
    return TrialRows{{cell(v), "a, \"quoted\"\nline"}, {{cell(v)}, {cell(2 * v)}}, "done"};
  };
  e.figures = [](const Results& r) {
    return std::vector<Figure>{{"median", "median", quantile_estimate(r.trials.numbers("value"), 0.5), ""},
                               {"mean_part", "mean", mean_estimate(r.details.numbers("part")), ""}};
  };
  e.plot = [](const Results&) { return picture::Canvas(10, 10, picture::rgb(0xFFFFFF)); };
  return e;
}

fs::path fresh(const std::string& name) {
  const fs::path folder = fs::temp_directory_path() / ("colift_campaign_test_" + name);
  fs::remove_all(folder);
  return folder;
}

std::string bytes(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::stringstream s;
  s << in.rdbuf();
  return s.str();
}

CampaignOptions options(const fs::path& out, int trials = 9, int shard = 1, int shards = 1, int jobs = 2) {
  CampaignOptions o;
  o.trials = trials;
  o.seed = 5;
  o.shard = shard;
  o.shards = shards;
  o.jobs = jobs;
  o.out = out;
  return o;
}

}  // namespace

TEST_CASE("three shards joined are the whole, byte for byte", "[campaign]") {
  const Experiment e = toy();
  const fs::path whole = fresh("whole"), joined = fresh("joined");
  const auto one = run_campaign(e, options(whole), {});
  REQUIRE(one);
  std::vector<fs::path> parts;
  for (int i = 1; i <= 3; ++i) {
    parts.push_back(fresh("part" + std::to_string(i)));
    REQUIRE(run_campaign(e, options(parts.back(), 9, i, 3, 1), {}));
  }
  // in any order, and with a part that is there twice
  const auto merged = merge_campaigns(e, {parts[2], parts[0], parts[1], parts[0]}, joined);
  REQUIRE(merged);
  CHECK(bytes(joined / "toy.csv") == bytes(whole / "toy.csv"));
  CHECK(bytes(joined / "toy_grasps.csv") == bytes(whole / "toy_grasps.csv"));
  CHECK(experiment_document(e, *merged) == experiment_document(e, *one));
  CHECK(one->trials.rows().size() == 9);
}

TEST_CASE("an interrupted campaign goes on where it was", "[campaign]") {
  const Experiment e = toy();
  const fs::path whole = fresh("whole2"), broken = fresh("broken");
  REQUIRE(run_campaign(e, options(whole), {}));
  int n = 0;
  CampaignHooks hooks;
  hooks.interrupted = [&] { return ++n >= 4; };
  const auto part = run_campaign(e, options(broken, 9, 1, 1, 1), hooks);
  REQUIRE(part);
  CHECK_FALSE(part->complete);
  CHECK(part->trials.rows().size() == 4);
  // power failed in the middle of a line, after details of a trial that never ended
  std::ofstream(broken / "toy.csv", std::ios::app) << "8,fast,12.5,\"a";
  std::ofstream(broken / "toy_grasps.csv", std::ios::app) << "8,fast,1\n";
  int ran = 0;
  hooks.interrupted = {};
  hooks.progress = [&](const CampaignProgress& p) {
    ++ran;
    CHECK(p.kept == 4);
    CHECK(p.to_do == 5);
  };
  const auto rest = run_campaign(e, options(broken), hooks);
  REQUIRE(rest);
  CHECK(rest->complete);
  CHECK(ran == 5);
  CHECK(bytes(broken / "toy.csv") == bytes(whole / "toy.csv"));
  CHECK(bytes(broken / "toy_grasps.csv") == bytes(whole / "toy_grasps.csv"));
}

TEST_CASE("a table of another campaign is never written over", "[campaign]") {
  const Experiment e = toy();
  const fs::path folder = fresh("other");
  REQUIRE(run_campaign(e, options(folder), {}));
  const std::string before = bytes(folder / "toy.csv");
  CampaignOptions other = options(folder);
  other.seed = 6;
  const auto refused = run_campaign(e, other, {});
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == hal::ErrorCode::BadInput);
  CHECK(refused.error().detail.find("seed=5") != std::string::npos);
  CHECK(bytes(folder / "toy.csv") == before);

  SECTION("nor one that was seen from elsewhere") {
    CampaignOptions side = options(folder);
    side.view = View::Side;
    CHECK_FALSE(run_campaign(e, side, {}));
    side.out = fresh("side");
    const auto seen = run_campaign(e, side, {});
    REQUIRE(seen);
    CHECK(seen->trials.header().find("camera=side") != std::string::npos);
  }
  SECTION("nor is one that is no table") {
    std::ofstream(folder / "toy.csv") << "my,own,notes\n";
    CHECK_FALSE(run_campaign(e, options(folder), {}));
    CHECK(bytes(folder / "toy.csv") == "my,own,notes\n");
  }
  SECTION("nor one with a damaged row, whose line is named") {
    std::ofstream(folder / "toy.csv", std::ios::app) << "x,fast\n";
    const auto bad = run_campaign(e, options(folder), {});
    REQUIRE_FALSE(bad);
    CHECK(bad.error().where.find("toy.csv:") != std::string::npos);
  }
}

TEST_CASE("shards that contradict each other are not joined", "[campaign]") {
  Experiment e = toy();
  const fs::path a = fresh("a"), b = fresh("b");
  REQUIRE(run_campaign(e, options(a, 3), {}));
  e.run = [](const Trial&) { return TrialRows{{"1", "other"}, {}, ""}; };
  REQUIRE(run_campaign(e, options(b, 3), {}));
  const auto merged = merge_campaigns(e, {a, b}, fresh("ab"));
  REQUIRE_FALSE(merged);
  CHECK(merged.error().detail.find("trial 0") != std::string::npos);
}

TEST_CASE("trials and shards out of range are refused", "[campaign]") {
  const Experiment e = toy();
  CHECK_FALSE(run_campaign(e, options(fresh("r"), -1), {}));
  CHECK_FALSE(run_campaign(e, options(fresh("r"), 9, 4, 3), {}));
  CHECK_FALSE(run_campaign(e, options(fresh("r"), 9, 0, 3), {}));
}

TEST_CASE("the worst trials are made once more, the worst first, each with its cause", "[campaign]") {
  Experiment e = toy();
  std::vector<int> again;
  const auto run = e.run;
  e.run = [&](const Trial& t) {
    if (t.watch) again.push_back(t.index);
    return run(t);
  };
  e.badness = [](const Results& r, const Row& row) -> std::optional<Badness> {
    const double v = r.trials.number(row, "value");
    if (v < 20.0) return std::nullopt;
    return Badness{v, fmt::format("is {:.3f}", v)};
  };
  const fs::path folder = fresh("worst");
  const auto campaign = run_campaign(e, options(folder), {});
  REQUIRE(campaign);
  CHECK(again.empty());
  std::vector<std::string> said;
  const auto page = write_worst(e, {.count = 3, .folder = folder}, [&](const std::string& words) {
    said.push_back(words);
    return true;
  });
  REQUIRE(page);
  REQUIRE(again.size() == 3);
  const auto value = [](int index) { return static_cast<double>(Trial{5, index}.own_seed(1) % 1000); };
  CHECK(value(again[0]) >= value(again[1]));
  CHECK(value(again[1]) >= value(again[2]));
  const std::string text = bytes(*page);
  const std::string cause = fmt::format("is {:.3f}", value(again[0]) / 7.0);
  CHECK(text.find(cause) != std::string::npos);
  CHECK(said.front().find(cause) != std::string::npos);

  Experiment unranked = toy();
  const auto refused = write_worst(unranked, {.folder = folder}, [](const std::string&) { return true; });
  REQUIRE_FALSE(refused);
  CHECK(refused.error().text().find("does not rank") != std::string::npos);
  CHECK_FALSE(write_worst(e, {.folder = fresh("nothing there")}, [](const std::string&) { return true; }));
}
