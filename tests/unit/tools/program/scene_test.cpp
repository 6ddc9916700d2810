// Recorded scenes: what is recorded, its truth, and what is said of it.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "hal/types/units.hpp"
#include "sim_hal/mock/mock_camera.hpp"
#include "sim_hal/synthetic/scenes.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tools/bring_up/camera/record_scene.hpp"
#include "tools/scenes/cmd_scene.hpp"
#include "tools/scenes/scene_truth.hpp"

namespace colift {
using namespace tools;
namespace {

namespace fs = std::filesystem;

constexpr double kLift_m = 0.06;

/// A place before a camera where somebody does what the recorder asks for, or not.
struct Place {
  sim_hal::SyntheticScene scene;
  sim_hal::PartnerPose partner;
  SceneStep step = SceneStep::Empty;
  bool brings = true, comes = true, lifts = true;
  bool stays_in_view = false;  ///< Somebody stands beside the object that he put down.

  explicit Place(std::uint64_t seed, sim_hal::ObjectKind kind = sim_hal::ObjectKind::Table)
      : scene(sim_hal::make_scene(kind, seed)), partner(sim_hal::make_partner(scene, seed, false)) {}

  [[nodiscard]] sim_hal::World now(double rise_m = 0.0) const {
    sim_hal::World w = scene.world;
    const bool with_object = step != SceneStep::Empty && brings;
    if (with_object && step == SceneStep::Object && stays_in_view)
      w = sim_hal::with_passer_by(scene, 3, false);
    if (step >= SceneStep::Hand && comes) w = sim_hal::with_partner(scene.world, partner);
    std::vector<sim_hal::Shape> shapes;
    for (sim_hal::Shape s : w.shapes) {
      if (s.label == sim_hal::Label::Target && !with_object) continue;
      const bool moves = s.label == sim_hal::Label::Target || s.part == sim_hal::BodyPart::Hand;
      if (moves) s.X_WS.pretranslate(hal::Vec3(0, 0, rise_m));
      shapes.push_back(s);
    }
    return {shapes};
  }

  [[nodiscard]] sim_hal::CameraScript script() const {
    sim_hal::CameraScript s;
    s.world = [this, first = std::optional<std::uint64_t>()](std::uint64_t frame) mutable {
      if (step != SceneStep::Lift || !lifts) return now();
      if (!first) first = frame;
      return now(std::min(kLift_m, 0.0012 * static_cast<double>(frame - *first)));
    };
    s.intrinsics = {320, 240, 287.9, 287.9, 160.0, 120.0};
    s.X_WC = scene.X_WC;
    return s;
  }

  hal::Result<SceneFile> record(const fs::path& folder) {
    hal::ManualClock clock;
    sim_hal::MockCamera camera(script(), clock);
    return record_scene(camera, clock, {folder, "table", "simulated", "", kLift_m, 2.0},
                        [&](SceneStep next, const std::string& words) -> hal::Result<> {
                          CHECK_FALSE(words.empty());
                          step = next;
                          return {};
                        });
  }
};

/// The object's pixels are those that the simulation knows of, at the place's step.
void check_object(const SceneTruth& truth, const Place& place) {
  const auto rendering = sim_hal::cast_rays(place.now(), place.script().intrinsics, place.scene.X_WC);
  std::size_t own = 0, all = 0;
  for (std::size_t i = 0; i < truth.object_pixels.size(); ++i) {
    all += rendering.label[i] == sim_hal::Label::Target ? 1 : 0;
    own += truth.object_pixels[i] && rendering.label[i] == sim_hal::Label::Target ? 1 : 0;
  }
  // feet nearer to the floor than the threshold, the emitter's shadow
  CHECK(static_cast<double>(own) > 0.85 * static_cast<double>(all));
  CHECK(static_cast<double>(own) > 0.95 * static_cast<double>(truth.object_count));
}

CommonOptions silently() {
  CommonOptions common;
  common.quiet = true;
  return common;
}

/// Why the scene in a folder has no truth; empty where it has one.
std::string no_truth(const fs::path& folder) {
  const auto scene = read_scene(folder);
  REQUIRE(scene);
  const auto truth = scene_truth(*scene, {});
  return truth ? "" : truth.error().text();
}

void replace_in(const fs::path& file, const std::string& from, const std::string& to) {
  std::ifstream in(file);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto at = text.find(from);
  REQUIRE(at != std::string::npos);
  std::ofstream(file) << text.replace(at, from.size(), to);
}

}  // namespace

TEST_CASE("a scene is recorded in four steps, and its truth is what the simulation knows",
          "[program][scene]") {
  const std::uint64_t seed = GENERATE(1, 2, 3);
  const auto kind =
      GENERATE(sim_hal::ObjectKind::Table, sim_hal::ObjectKind::Box, sim_hal::ObjectKind::Chair);
  const tests::TemporaryFolder scratch;
  Place place(seed, kind);
  const auto file = place.record(scratch.path() / "new/");
  REQUIRE(file);
  const auto scene = read_scene(scratch.path() / "new");
  REQUIRE(scene);
  CHECK(scene->file.name == "new");
  CHECK(scene->file.object == "table");
  CHECK(scene->file.lifted_m == kLift_m);
  for (const std::size_t step : {0U, 1U, 2U}) CHECK(scene->frames[step].size() == 5);
  CHECK(scene->frames[3].size() == 10);

  const auto truth = scene_truth(*scene, {});
  INFO("kind " << static_cast<int>(kind) << " seed " << seed << (truth ? "" : ": " + truth.error().text()));
  REQUIRE(truth);
  place.step = SceneStep::Object;
  check_object(*truth, place);
  const hal::Vec3 contact_C = place.scene.X_WC.inverse() * place.partner.contact;
  CHECK(std::any_of(truth->hands.begin(), truth->hands.end(),
                    [&](const hal::Vec3& p) { return (p - contact_C).norm() < 0.07; }));
  CHECK(truth->moved > 0.12);  // 0.02 where nothing is lifted
}

TEST_CASE("perception is held against the truth, and a scene with a wrong answer fails", "[program][scene]") {
  const tests::TemporaryFolder scratch;
  Place place(2);
  const fs::path folder = scratch.path() / "table";
  REQUIRE(place.record(folder));
  const auto checked = check_recorded_scene(silently(), folder, "fast", folder / "scene.png");
  REQUIRE(checked);
  INFO(scene_text(*checked));
  CHECK(checked->accepted());
  CHECK(checked->rows.size() == 4);
  CHECK(fs::exists(folder / "scene.png"));
  SceneOptions options{{scratch.path()}, "", {}};
  CHECK(cmd_scene(silently(), options) == kDone);

  // it was lifted elsewhere than somebody says
  replace_in(folder / "scene.json", "\"lifted_m\": 0.06", "\"lifted_m\": 0.26");
  CHECK(cmd_scene(silently(), options) == kNoGoal);
  replace_in(folder / "scene.json", "\"known\": {}", "\"known\": {\"lift\": \"partly\"}");
  CHECK(cmd_scene(silently(), options) == kDone);

  const auto document = nlohmann::json::parse(scenes_document({*checked}));
  CHECK(document["accepted"] == true);
  CHECK(document["scenes"][0]["rows"][1]["step"] == "object");
}

TEST_CASE("a recording in which somebody did otherwise says what to do anew", "[program][scene]") {
  const tests::TemporaryFolder scratch;
  Place place(2);
  const fs::path folder = scratch.path() / "scene";
  SECTION("no object") {
    place.brings = false;
    REQUIRE(place.record(folder));
    CHECK_THAT(no_truth(folder), Catch::Contains("nothing is there that was not there before"));
    CHECK(cmd_scene(silently(), {{folder}, "", {}}) == kNoGoal);
  }
  SECTION("the person stays in view") {
    place.stays_in_view = true;
    REQUIRE(place.record(folder));
    CHECK_THAT(no_truth(folder), Catch::Contains("leave the view"));
  }
  SECTION("nobody comes") {
    place.comes = false;
    REQUIRE(place.record(folder));
    CHECK_THAT(no_truth(folder), Catch::Contains("nobody came into view"));
  }
  SECTION("nothing is lifted") {
    place.lifts = false;
    REQUIRE(place.record(folder));
    CHECK_THAT(no_truth(folder), Catch::Contains("lift it by some centimetres"));
  }
}

TEST_CASE("a camera that was pushed after the first step is noticed, or spoils nothing", "[program][scene]") {
  const tests::TemporaryFolder scratch;
  Place place(2);
  REQUIRE(place.record(scratch.path() / "before"));
  auto scene = read_scene(scratch.path() / "before");
  REQUIRE(scene);
  const int way = GENERATE(range(0, 12));  // 4 cm along each axis, or 3 degrees about it, to and fro
  const hal::Vec3 axis = hal::Vec3::Unit(way % 3);
  const double sign = way % 2 == 0 ? 1.0 : -1.0;
  if (way < 6)
    place.scene.X_WC.translate(sign * 0.04 * axis);
  else
    place.scene.X_WC.rotate(Eigen::AngleAxisd(sign * 3.0 * hal::kRadPerDeg, axis));
  REQUIRE(place.record(scratch.path() / "after"));
  auto pushed = read_scene(scratch.path() / "after");
  REQUIRE(pushed);
  pushed->frames[0] = scene->frames[0];
  const auto truth = scene_truth(*pushed, {});
  INFO("way " << way);
  // what moves along a bare floor sees the same floor: then nothing is wrong either
  if (!truth) {
    CHECK_THAT(truth.error().text(), Catch::Contains("camera"));
    return;
  }
  place.step = SceneStep::Object;
  check_object(*truth, place);
}

TEST_CASE("a camera that is pulled out while a scene is recorded leaves no half of one", "[program][scene]") {
  const tests::TemporaryFolder scratch;
  Place place(2);
  hal::ManualClock clock;
  sim_hal::MockCamera camera(place.script(), clock);
  camera.inject(sim_hal::MockCamera::Fault::Unplug, 30, 10000);
  const fs::path folder = scratch.path() / "scene/";
  const auto file = record_scene(camera, clock, {folder, "table", "simulated", "", {}, 2.0},
                                 [](SceneStep, const std::string&) { return hal::Result<>(); });
  REQUIRE_FALSE(file);
  CHECK(file.error().code == hal::ErrorCode::LinkLost);
  CHECK_FALSE(fs::exists(folder));
}

TEST_CASE("a scene's file that is not one is refused with the place", "[program][scene]") {
  const tests::TemporaryFolder scratch;
  Place place(2);
  const fs::path folder = scratch.path() / "scene";
  REQUIRE(place.record(folder));
  const auto refused = [&](const char* from, const char* to, const char* expected) {
    const fs::path file = folder / "scene.json";
    fs::copy_file(file, scratch.path() / "kept", fs::copy_options::overwrite_existing);
    replace_in(file, from, to);
    const auto read = read_scene(folder);
    fs::copy_file(scratch.path() / "kept", file, fs::copy_options::overwrite_existing);
    REQUIRE_FALSE(read);
    CHECK(read.error().code == hal::ErrorCode::BadInput);
    CHECK_THAT(read.error().text(), Catch::Contains(expected));
  };
  refused("colift.scene/1", "colift.scene/2", "schema");
  refused("\"hand_0.png\"", "\"../hand_0.png\"", "images.hand");
  refused("\"hand_0.png\"", "7", "images.hand");
  refused("\"hand_0.png\"", "\"hand_9.png\"", "hand_9.png");
  refused("0.06", "\"much\"", "lifted_m");
  refused("\"hand_px\": null", "\"hand_px\": [3]", "hand_px");
  refused("{", "", "is no JSON");
  CHECK(cmd_scene(silently(), {{scratch.path() / "nowhere"}, "", {}}) == kBadInput);

  // a folder that holds something is not written into
  const auto again = place.record(folder);
  REQUIRE_FALSE(again);
  CHECK_THAT(again.error().text(), Catch::Contains("new or empty folder"));
}

// tests/data/scenes/simulated_table: COLIFT_SCENE=tests/data/scenes/simulated_table build/unit_tools
// "[.sample]"
TEST_CASE("the sample of tests/data/scenes is written anew", "[.sample]") {
  const char* const folder = std::getenv("COLIFT_SCENE");
  REQUIRE(folder != nullptr);
  REQUIRE(Place(2).record(folder));
}

}  // namespace colift
