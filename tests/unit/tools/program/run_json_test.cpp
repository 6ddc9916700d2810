#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "run_example.hpp"
#include "sim_hal/scenario/scenario.hpp"
#include "tools/run/run_json.hpp"

using namespace colift;
using tests::RunExample;
using Json = nlohmann::json;

namespace {

Json document(const RunExample& e) {
  return Json::parse(tools::run_document(e.view()));
}

bool is_place(const Json& j) {
  return j.is_array() && j.size() == 3 && j[0].is_number() && j[1].is_number() && j[2].is_number();
}

// Paths at which two documents differ.
std::vector<std::string> differences(const Json& a, const Json& b) {
  std::vector<std::string> paths;
  for (const auto& step : Json::diff(a, b)) paths.push_back(step["path"]);
  return paths;
}

}  // namespace

TEST_CASE("a run's document has the keys and types of the contract", "[run]") {
  const RunExample e = tests::lifted_run();
  const Json j = document(e);
  CHECK(j["schema"] == "colift.run/1");
  CHECK(j["outcome"] == "lifted");
  CHECK(j["because"] == "held 5.0 cm for 2.0 s, lowered, released");
  CHECK(j["seed"] == 7);
  REQUIRE(j["states"].size() == e.record.states.size());
  CHECK(j["states"][0]["state"] == "observe");
  CHECK(j["states"][2]["t"].get<double>() == Approx(3.9));
  CHECK(j["states"][2]["because"] == "the partner grasps the object");
  CHECK(is_place(j["partner"]["position"]));
  CHECK(j["partner"]["error_m"].get<double>() ==
        Approx((e.record.decision->partner->position - *e.truth.partner).norm()));
  CHECK(j["decision"]["candidate"].is_number_integer());
  CHECK(is_place(j["decision"]["position"]));
  CHECK(j["decision"]["share"].is_number());
  for (const char* key : {"height_m", "tilt_deg", "share_robot", "share_predicted", "slip_m", "mass_kg"}) {
    INFO(key);
    CHECK(j["lift"][key].is_number());
  }
  CHECK(j["lift"]["tilt_deg"].get<double>() == Approx(0.0094 * 180 / std::numbers::pi));
  for (const char* key : {"grasp_to_decision_s", "decision_compute_ms", "plan_ms", "sim_s", "wall_s"}) {
    INFO(key);
    CHECK(j["timing"][key].is_number());
  }
  CHECK(j["truth"]["mass_kg"] == 4.0);
  CHECK(is_place(j["truth"]["cog"]));
  CHECK(is_place(j["truth"]["partner"]));
  CHECK(j["faults"] == Json::array());
}

TEST_CASE("the chosen candidate of a run's document is in its list, and the others have their reasons",
          "[run]") {
  const Json j = document(tests::lifted_run());
  REQUIRE(j["candidates"].size() > 10);
  int chosen = 0;
  for (const Json& c : j["candidates"]) {
    if (c["verdict"] == "chosen") {
      ++chosen;
      CHECK(c["id"] == j["decision"]["candidate"]);
      CHECK(c["position"] == j["decision"]["position"]);
      CHECK(c["share"] == j["decision"]["share"]);
    } else if (c["verdict"] != "ok") {
      CHECK(c["because"].get<std::string>().size() > 5);
    }
  }
  CHECK(chosen == 1);
}

TEST_CASE("what did not happen in a run is null", "[run]") {
  const Json j = document(tests::refused_run());
  CHECK(j["outcome"] == "refused");
  for (const char* key : {"partner", "decision", "lift", "curve"}) {
    INFO(key);
    REQUIRE(j.contains(key));
    CHECK(j[key].is_null());
  }
  CHECK(j["timing"]["grasp_to_decision_s"].is_null());
  CHECK(j["timing"]["plan_ms"].is_null());
  CHECK(j["truth"]["partner"].is_null());
  CHECK(j["truth"]["lift"].is_null());
  CHECK(j["candidates"].size() > 10);
}

TEST_CASE("a real rig's document holds no truth", "[run]") {
  const RunExample e = tests::lifted_run();
  const Json j = Json::parse(tools::run_document({e.record, e.setting, nullptr, nullptr}));
  CHECK_FALSE(j.contains("truth"));
  CHECK(j["partner"]["error_m"].is_null());
}

TEST_CASE("the judge's verdict stands in the document, and none is null", "[run]") {
  RunExample e = tests::lifted_run();
  CHECK(document(e)["judge"].is_null());
  sim_hal::Verdict v;
  v.breaches = {"hand: 150 N clamped"};
  v.contacts.push_back({5.7, "hand", "robot", 0, 150.0, 140.0, 150.0, 0.6, 120.0, 0.3, 0.2, 0.25, false});
  v.min_distance_m = -0.001;
  v.distances = {{0.1, INFINITY, 0.7}, {0.2, 0.3, 0.6}};
  e.truth.verdict = v;
  const Json j = document(e)["judge"];
  CHECK(j["breaches"][0] == "hand: 150 N clamped");
  CHECK(j["contacts"][0]["body"] == "hand");
  CHECK(j["contacts"][0]["limit_n"] == 140.0);
  CHECK(j["contacts"][0]["clamped_s"] == 0.6);
  CHECK(j["contacts"][0]["kept_n"] == 120.0);
  CHECK(j["contacts"][0]["closing_m_s"] == 0.3);
  CHECK(j["contacts"][0]["robot_m_s"] == 0.25);
  CHECK(j["distance"]["people_m"] == Json::array({nullptr, 0.3}));
  CHECK(j["distance"]["partner_m"] == Json::array({0.7, 0.6}));
  CHECK(j["min_distance_m"] == -0.001);
  CHECK(j["partner_distance_m"].is_null());
}

TEST_CASE("a scenario's times may count from every state that the task has", "[run]") {
  const auto& names = sim_hal::task_state_names();
  for (int state = 0; state <= static_cast<int>(control::Task::Stopped); ++state) {
    const std::string name(control::word(static_cast<control::Task>(state)));
    INFO(name);
    CHECK(std::find(names.begin(), names.end(), name) != names.end());
  }
}

TEST_CASE("no number of a run's document is NaN or infinite", "[run]") {
  RunExample e = tests::lifted_run();
  const double nan = std::nan("");
  e.record.lift.emplace();
  e.record.lift->height_m = e.record.lift->tilt_rad = e.record.lift->share_robot = nan;
  e.record.lift->share_predicted = e.record.lift->slip_m = nan;
  e.record.lift->mass_kg = std::numeric_limits<double>::infinity();
  e.record.timing.grasp_to_decision_s = nan;
  e.truth.curve.clear();
  e.record.reason = "bytes that are no text: \xFF";
  const std::string text = tools::run_document(e.view());
  CHECK(text.find("nan") == std::string::npos);
  CHECK(text.find("inf\"") == std::string::npos);
  const Json j = Json::parse(text);
  CHECK(j["lift"]["height_m"].is_null());
  CHECK(j["lift"]["mass_kg"].is_null());
  const std::function<void(const Json&)> all_finite = [&](const Json& v) {
    if (v.is_number()) CHECK(std::isfinite(v.get<double>()));
    if (v.is_structured())
      for (const Json& part : v) all_finite(part);
  };
  all_finite(j);
}

TEST_CASE("two machines differ only in three times of a run's document", "[run]") {
  RunExample fast = tests::lifted_run(), slow = fast;
  slow.record.timing.wall_s *= 3;
  slow.record.timing.plan_ms *= 3;
  slow.record.timing.decision_compute_ms *= 3;
  slow.record.analysis->ms.total = 99;
  slow.record.decision->decision_ms = 99;
  slow.record.decision->partner_ms = 99;
  slow.record.plan->plan_ms = slow.record.plan->exact_ms = 99;
  std::vector<std::string> paths = differences(document(fast), document(slow));
  std::sort(paths.begin(), paths.end());
  CHECK(paths ==
        std::vector<std::string>{"/timing/decision_compute_ms", "/timing/plan_ms", "/timing/wall_s"});
}

TEST_CASE("the truth at the top is the mean while it is held", "[run]") {
  const RunExample e = tests::lifted_run();
  const auto top = tools::true_lift(e.view());
  REQUIRE(top);
  CHECK(top->height_m == Approx(0.0492).margin(1e-6));
  CHECK(top->share_robot == Approx(19.2 / 39.24).margin(1e-3));
  CHECK(std::isnan(tools::true_share({.robot_force_z_n = 5, .partner_force_z_n = 5, .floor_force_z_n = 30})));
  CHECK(tools::true_share({.robot_force_z_n = 10, .partner_force_z_n = 30}) == Approx(0.25));
  CHECK_FALSE(tools::true_lift(tests::refused_run().view()));
}
