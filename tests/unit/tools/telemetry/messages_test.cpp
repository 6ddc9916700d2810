#include "tools/telemetry/channels/messages.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <set>

#include "tools/telemetry/channels/channels.hpp"
#include "tools/telemetry/channels/json_parts.hpp"
#include "tools/telemetry/channels/string_message.hpp"
#include "tools/telemetry/record/cycle_inputs.hpp"

namespace {

using namespace colift;
using namespace colift::telemetry;
using J = nlohmann::json;

/// Every key of a message stands in its schema; types are held against it too.
void check_against(const J& schema, const J& value, const std::string& where) {
  INFO(where << " " << value.dump().substr(0, 100));
  if (!schema.contains("type")) return;
  std::set<std::string> types;
  if (schema["type"].is_array())
    for (const auto& t : schema["type"]) types.insert(t);
  else
    types.insert(schema["type"].get<std::string>());
  const bool fits =
      (value.is_object() && types.count("object")) || (value.is_array() && types.count("array")) ||
      (value.is_string() && types.count("string")) || (value.is_boolean() && types.count("boolean")) ||
      (value.is_number() && types.count("number")) || (value.is_number_integer() && types.count("integer")) ||
      (value.is_null() && types.count("null"));
  CHECK(fits);
  if (value.is_object() && schema.contains("properties"))
    for (const auto& [key, inner] : value.items()) {
      INFO(key);
      CHECK(schema["properties"].contains(key));
      if (schema["properties"].contains(key))
        check_against(schema["properties"][key], inner, where + "." + key);
    }
  if (value.is_array() && schema.contains("items"))
    for (const auto& inner : value) check_against(schema["items"], inner, where + "[]");
}

void check_message(Topic topic, const std::string& message) {
  const J value = J::parse(message);
  check_against(J::parse(channel_of(topic).schema), value, channel_of(topic).topic);
}

}  // namespace

TEST_CASE("topics and channels belong together", "[messages]") {
  REQUIRE(channels().size() == kTopics);
  std::set<std::string> names;
  for (int i = 0; i < kTopics; ++i) {
    const ChannelInfo& c = channels()[static_cast<std::size_t>(i)];
    CHECK(static_cast<int>(c.id) == i);
    CHECK(names.insert(c.topic).second);
    if (c.encoding == "json") CHECK(J::parse(c.schema)["title"] == c.schema_name);
  }
}

TEST_CASE("a text in CDR is read back, and what is cut or no text is refused", "[messages]") {
  for (const std::string text : {"", "<robot/>", "\xff\xfe"}) {
    const std::string bytes = string_message(text);
    CHECK(parse_string(bytes).value() == text);
    for (std::size_t length = 0; length < bytes.size(); ++length)
      CHECK_FALSE(parse_string(std::string_view(bytes).substr(0, length)));
  }
  CHECK_FALSE(parse_string(R"({"data": "json"})"));
  CHECK_FALSE(parse_string(std::string("\0\1\0\0\xff\xff\xff\xff", 8)));
}

TEST_CASE("every message is what its schema says", "[messages]") {
  const hal::Timestamp at(std::chrono::milliseconds(1500));
  const hal::RobotModel& model = hal::built_in_robot();
  hal::HandState hand;
  hand.torque_nm[1] = NAN;
  check_message(Topic::Transforms,
                transforms_message(at, model, hal::JointVector::Zero(), {}, hal::Pose::Identity()));
  const std::string joints = joints_message(at, model, {}, hand);
  check_message(Topic::Joints, joints);
  CHECK(J::parse(joints)["joints"].size() == 7 + 6 + 2);
  CHECK(J::parse(joints)["timestamp"] == J{{"sec", 1}, {"nsec", 500000000}});
  control::TrackedPoses tracked;
  tracked.at = at;
  CHECK(J::parse(tracked_message(tracked))["transforms"].empty());
  tracked.X_WO = hal::Pose(Eigen::Translation3d(1, 2, 3));
  tracked.partner_W = hal::Vec3(1, NAN, 3);  // no place
  check_message(Topic::Tracked, tracked_message(tracked));
  REQUIRE(J::parse(tracked_message(tracked))["transforms"].size() == 1);
  tracked.partner_W = hal::Vec3(4, 5, 6);
  const J both = J::parse(tracked_message(tracked))["transforms"];
  REQUIRE(both.size() == 2);
  CHECK(both[0]["child_frame_id"] == "object");
  CHECK(both[0]["timestamp"] == J{{"sec", 1}, {"nsec", 500000000}});
  CHECK(both[1]["child_frame_id"] == "partner");
  CHECK(both[1]["translation"] == J{{"x", 4.0}, {"y", 5.0}, {"z", 6.0}});
  hal::DepthFrame frame;
  frame.intrinsics = {8, 4, 575, 575, 4, 2};
  frame.depth_m.assign(32, 1.25f);
  frame.depth_m[0] = NAN;
  check_message(Topic::Calibration, calibration_message(at, frame.intrinsics));
  const std::string preview = preview_message(frame);
  check_message(Topic::Preview, preview);
  CHECK(J::parse(preview)["width"] == 4);
  CHECK(J::parse(preview)["data"] == "AADiBOIE4gTiBOIE4gTiBA==");  // 0, then 1250 seven times
  check_message(Topic::Cloud, cloud_message(frame));
  frame.depth_m.pop_back();  // not as many as the size says
  check_message(Topic::Cloud, cloud_message(frame));
  check_message(Topic::Log, log_message(at, Level::Warning, "arm", "broken \xff text"));
  control::JobStatus status;
  status.partner_W = hal::Vec3(1, 2, NAN);
  check_message(Topic::Change, change_message({at, control::Task::Lift, "because"}));
  status.partner_W = hal::Vec3(1, 2, 3);
  check_message(Topic::Status, status_message(status));
  status.force.limits = control::ForceLimits{60, 35, 100, 25};
  control::SeparationStatus::Body body;
  body.id = 3;
  body.box.extend(hal::Vec3(0.2, -1.0, 0.0));
  body.box.extend(hal::Vec3(0.6, -0.6, 1.7));
  body.velocity_m_s = {0.0, 1.0, 0.0};
  body.distance_m = 0.62;
  status.separation.bodies.push_back(body);
  check_message(Topic::Status, status_message(status));
  check_message(Topic::Bodies, bodies_message(hal::Timestamp(0), status.separation));
  CHECK(bodies_message(hal::Timestamp(0), status.separation).find("body 3, 0.62 m") != std::string::npos);
  check_message(Topic::Intent,
                intent_message({hal::Timestamp(0), control::Motion::Lift, 0.5, "lifts the object"}));
  check_message(Topic::Intent, intent_message({hal::Timestamp(0), std::nullopt, 0.0, "please step aside"}));
  check_message(Topic::Devices, devices_message({{"arm", {}}}));
  check_message(Topic::Timing, timing_message({10, 1, 0, 2.0, {}, {}}));
  check_message(Topic::Stages, stages_message({}, 1.0, {}));
  check_message(Topic::Tactile, tactile_message({}));
  hal::HandState pressed;
  pressed.tactile[3].measured_at = at;
  pressed.tactile[3].pressure_n_cm2.fill(0.5F);
  pressed.palm_force_n = 11.6;
  check_message(Topic::Tactile, tactile_message(pressed));
  check_message(Topic::Load, load_message({}));
  LoadNow load;
  load.wrench_W = hal::Wrench{{1, 2, 3}, {4, 5, 6}};
  load.share = NAN;
  check_message(Topic::Load, load_message(load));
  DecisionView decision;
  check_message(Topic::Decision, decision_message(decision));
  decision.outcome.candidates.resize(2);
  decision.outcome.candidates[1].id = 1;
  decision.outcome.candidates[1].verdict = planner::Verdict::NearPartner;
  decision.outcome.partner.emplace();
  decision.outcome.decision.chosen = 0;
  decision.outcome.decision.scores = {planner::ScoredCandidate{}, std::nullopt};
  check_message(Topic::Decision, decision_message(decision));
  SceneView scene;
  scene.ground.emplace();
  scene.target.emplace();
  scene.shape.emplace();
  scene.surfaces = {perception::Rectangle{}, perception::Cylinder{}};
  scene.candidates = decision.outcome.candidates;
  scene.partner.emplace();
  scene.optimum = hal::Vec3(0, 0, 0);
  scene.path_W = {hal::Vec3(0, 0, 0), hal::Vec3(1, 0, 0)};
  scene.gripper = gripper_view(model, hal::Pose::Identity());
  const std::string entities = scene_message(at, scene);
  check_message(Topic::Scene, entities);
  std::set<std::string> ids;
  const J parsed = J::parse(entities);
  for (const auto& e : parsed["entities"]) CHECK(ids.insert(e["id"]).second);
}

TEST_CASE("the chosen gripper is the robot's own hand, wherever the palm is put", "[messages]") {
  const hal::RobotModel& model = hal::built_in_robot();
  hal::Pose X_WH = hal::Pose::Identity();
  X_WH.translation() = hal::Vec3(1, 2, 3);
  X_WH.linear() = Eigen::AngleAxisd(1.0, hal::Vec3::UnitX()).toRotationMatrix();
  const GripperView here = gripper_view(model, hal::Pose::Identity()), there = gripper_view(model, X_WH);
  REQUIRE(here.hand_W.size() == there.hand_W.size());
  CHECK(here.hand_W.size() >= 4);  // palm and three fingers at least
  for (std::size_t i = 0; i < here.hand_W.size(); ++i) {
    CHECK(there.hand_W[i].X_LS.isApprox(X_WH * here.hand_W[i].X_LS, 1e-9));
    CHECK(here.hand_W[i].X_LS.translation().norm() < 0.3);
  }
}

TEST_CASE("the map is sent as few boxes, each cell in one of them", "[messages]") {
  MapView map;
  map.cell_m = 0.02;
  map.origin_W = hal::Vec3(-0.1, 0, 0);
  map.size = {10, 6, 5};
  map.cells.assign(300, MapView::Cell::Nothing);
  const auto cell = [&](int x, int y, int z) -> MapView::Cell& {
    return map.cells[static_cast<std::size_t>((z * 6 + y) * 10 + x)];
  };
  for (int z = 0; z < 3; ++z)  // a wall with a target in it
    for (int x = 0; x < 10; ++x) cell(x, 2, z) = MapView::Cell::Obstacle;
  cell(4, 2, 1) = MapView::Cell::Target;
  cell(9, 5, 4) = MapView::Cell::Hidden;
  const std::string message = map_message(hal::Timestamp(0), map);
  check_message(Topic::Map, message);
  const J entities = J::parse(message)["entities"];
  REQUIRE(entities.size() == 3);
  CHECK(entities[0]["id"] == "obstacles");
  double volume = 0.0;
  for (const auto& c : entities[0]["cubes"])
    volume += c["size"]["x"].get<double>() * c["size"]["y"].get<double>() * c["size"]["z"].get<double>();
  CHECK(volume == Approx(29 * 8e-6));
  CHECK(entities[0]["cubes"].size() <= 5);
  CHECK(entities[0]["metadata"][1]["value"] == "29");
  REQUIRE(entities[1]["cubes"].size() == 1);
  CHECK(entities[1]["cubes"][0]["pose"]["position"] == J{{"x", -0.01}, {"y", 0.05}, {"z", 0.03}});
  CHECK(entities[2]["cubes"].size() == 1);
  CHECK(message == map_message(hal::Timestamp(0), map));

  INFO("a map that is nothing but single cells stays bounded, and says what it left out");
  map.size = {100, 100, 2};
  map.cells.assign(20000, MapView::Cell::Nothing);
  for (std::size_t i = 0; i < 10000; ++i)
    if ((i % 100 + i / 100) % 2 == 0) map.cells[i] = MapView::Cell::Obstacle;
  const std::string crowded = map_message(hal::Timestamp(0), map);
  CHECK(crowded.size() < 1u << 20);
  const J first = J::parse(crowded)["entities"][0];
  CHECK(first["cubes"].size() == 3000);
  CHECK(first["metadata"][2]["value"] == "2000");
}

TEST_CASE("of the map the cells near the robot are taken, and the others counted", "[messages]") {
  perception::WorldMapConfig config;
  config.min_m = hal::Vec3(-0.2, -0.2, 0.0);
  config.max_m = hal::Vec3(3.0, 0.2, 0.4);
  perception::WorldMap map(config);
  const std::vector<hal::Vec3> target = {hal::Vec3(1.0, 0.0, 0.2), hal::Vec3(2.5, 0.0, 0.2)};
  map.set_target(target);
  const MapView view = map_view(map, {hal::Vec3::UnitZ(), 0.0});
  CHECK(view.size == std::array<int, 3>{110, 20, 20});
  CHECK(view.cropped == 1);
  CHECK(std::count(view.cells.begin(), view.cells.end(), MapView::Cell::Target) == 1);

  config.cell_m = 0.015;  // too many cells for one message: some of them make one
  config.min_m = hal::Vec3(-2, -2, 0.0);
  config.max_m = hal::Vec3(2, 2, 2);
  const MapView fine = map_view(perception::WorldMap(config), {hal::Vec3::UnitZ(), 0.0});
  CHECK(fine.cell_m == Approx(0.03));
  CHECK(fine.size == std::array<int, 3>{133, 133, 67});
}

TEST_CASE("inputs of a cycle read back to the same bits", "[messages]") {
  CycleInputs in;
  in.cycle = 7;
  in.clock_ns = {1, 9007199254740993};  // beyond what a double holds
  hal::ArmState arm;
  arm.measured_at = hal::Timestamp(9007199254740993);
  arm.q_rad = hal::JointVector::Constant(0.1 + 0.2);
  arm.q_rad[3] = -0.0;
  arm.tau_nm[1] = 1e-310;
  arm.may_command = true;
  in.arm = {arm, hal::failure(hal::ErrorCode::LinkLost, "arm", "gone")};
  hal::HandState hand;
  hand.tip_force_n = {NAN, 1.0 / 3.0, 0.0};
  hand.warning.set("warm");
  in.hand = {hand};
  in.camera = {{12, {hal::ErrorCode::Timeout, "", ""}},
               {{}, {hal::ErrorCode::LinkLost, "camera", "unplugged"}}};
  in.answers = {hal::Result<>{}, hal::failure(hal::ErrorCode::LimitExceeded, "arm", "too fast")};
  in.arm_health = {{hal::DeviceHealth::State::Stalled, 0, 0, "quality bad"}};
  in.view.emplace();
  in.view->state = arm;
  in.view->wrench_W = hal::Wrench{{1.1, 2.2, 3.3}, {0, 0, 0}};
  in.view->fault.set("late");
  in.interrupted = true;

  const std::string message = inputs_message(in);
  check_message(Topic::Inputs, message);
  const auto back = parse_inputs(message);
  REQUIRE(back);
  CHECK(inputs_message(*back) == message);
  CHECK(back->clock_ns == in.clock_ns);
  CHECK(back->arm[0]->q_rad == arm.q_rad);
  CHECK(std::signbit(back->arm[0]->q_rad[3]));
  CHECK(back->arm[0]->tau_nm[1] == 1e-310);
  CHECK(back->arm[0]->measured_at == arm.measured_at);
  CHECK(back->arm[1].error().text() == "arm: gone");
  CHECK(std::isnan(back->hand[0]->tip_force_n[0]));
  CHECK(back->camera[0].frame == 12u);
  CHECK(back->camera[1].error.code == hal::ErrorCode::LinkLost);
  CHECK(back->answers[0]);
  CHECK(back->answers[1].error().code == hal::ErrorCode::LimitExceeded);
  CHECK(back->view->wrench_W->force.z() == 3.3);
  CHECK(back->view->fault.str() == "late");
  for (const char* bad :
       {"", "[]", "{}", "{\"cycle\":\"x\",\"clock\":[]}", "{\"cycle\":1,\"clock\":[1],\"hand\":[{}]}"})
    CHECK_FALSE(parse_inputs(bad));
}

TEST_CASE("base64 as in RFC 4648", "[messages]") {
  CHECK(base64("") == "");
  CHECK(base64("f") == "Zg==");
  CHECK(base64("fo") == "Zm8=");
  CHECK(base64("foo") == "Zm9v");
  CHECK(base64("foobar") == "Zm9vYmFy");
}
