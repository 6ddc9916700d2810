// A whole simulated lift: recording it and being watched by somebody who never reads changes nothing, and
// replaying it decides the same to the bit.

#include <unistd.h>

#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "hal/robot_model/robot_model.hpp"
#include "recorded_run.hpp"
#include "sim_hal/mujoco/devices/sim_devices.hpp"
#include "tools/telemetry/channels/built_in_texts.hpp"
#include "tools/telemetry/channels/recorded_frame.hpp"
#include "tools/telemetry/channels/string_message.hpp"

namespace {

using namespace colift;
using namespace colift::telemetry;
using namespace colift::telemetry::test;

/// Every number that a run leaves behind, to the bit.
std::string fingerprint(const control::RunRecord& r) {
  std::string out = r.reason;
  const auto put = [&](double v) { out += ' ' + std::to_string(std::bit_cast<std::uint64_t>(v)); };
  for (const auto& s : r.states) out += '\n' + std::to_string(s.at.count()) + s.reason;
  for (const auto& s : r.curve)
    for (const double v : {s.t_s, s.palm_height_m, s.load_n}) put(v);
  if (r.decision)
    for (const auto& c : r.decision->candidates) {
      out += '\n' + c.reason;
      for (const double v : {c.position.x(), c.position.y(), c.position.z(), c.width}) put(v);
    }
  if (r.lift)
    for (const double v : {r.lift->height_m, r.lift->tilt_rad, r.lift->share_robot, r.lift->mass_kg}) put(v);
  put(r.timing.sim_s);
  return out;
}

}  // namespace

TEST_CASE("a lift that is recorded and watched is the same lift, and its replay decides the same to the bit",
          "[lift]") {
  const auto file =
      std::filesystem::temp_directory_path() / ("colift-lift-" + std::to_string(::getpid()) + ".mcap");
  const sim_hal::Scenario scenario = short_lift();
  const Recorded plain = run(scenario, nullptr), recorded = run(scenario, &file);
  CHECK(plain.record.outcome == control::RunRecord::Result::Lifted);
  CHECK(fingerprint(plain.record) == fingerprint(recorded.record));
  CHECK(recorded.report.complete);
  CHECK(recorded.report.lost_queue + recorded.report.lost_disk == 0);
  const double seconds = recorded.record.timing.sim_s;
  const double mb = 1e-6 * static_cast<double>(recorded.report.file_bytes);
  WARN("a lift of " << seconds << " s makes a file of " << mb << " MB, " << mb / seconds << " MB/s");
  CHECK(mb / seconds < 6.0);  // 30 lossless frames a second

  const McapReader reader = opened(file);
  CHECK(reader.info().complete);
  CHECK(reader.scan().damage.empty());

  Watcher watcher;
  const auto again = replayed(reader, {}, &watcher);
  REQUIRE(again);
  for (const auto& d : again->differences)
    UNSCOPED_INFO(channel_of(d.topic).topic << " " << d.index << "\n" << d.recorded << "\n" << d.replayed);
  CHECK(again->same());
  CHECK(again->notes.empty());
  CHECK(again->compared.at(Topic::Decision) >= 1);
  CHECK(again->compared.at(Topic::Plan) >= 1);
  CHECK(again->compared.at(Topic::Change) == recorded.record.states.size());
  CHECK(again->compared.at(Topic::Status) > 200);
  CHECK(again->record.states.size() == recorded.record.states.size());

  {
    INFO("who watches the replay sees what was to be seen then: scene and map anew, devices as they were");
    const auto of = [&](Topic topic) {
      const Channel* channel = reader.info().channel(channel_of(topic).topic);
      return channel == nullptr ? 0 : reader.info().statistics.per_channel.at(channel->id);
    };
    for (const Topic topic : {Topic::Scene, Topic::Map, Topic::Decision, Topic::Devices, Topic::Timing,
                              Topic::Cloud, Topic::Tracked, Topic::Description}) {
      INFO(channel_of(topic).topic);
      CHECK(watcher.count[topic] > 0);
      CHECK(watcher.count[topic] == of(topic));
    }
    auto cursor = reader.messages({"/map", "/devices"});
    std::map<std::string, std::string> last;
    while (const auto message = cursor.next())
      last[reader.info().channels.at(message->channel_id).topic] = std::string(message->data);
    CHECK(watcher.text[Topic::Map] == last["/map"]);
    CHECK(watcher.text[Topic::Devices] == last["/devices"]);
    CHECK(last["/map"].size() < 1u << 20);
    WARN("the map is a message of " << last["/map"].size() / 1000 << " kB");
  }
  {
    INFO("with another configuration the replay shows what differs");
    const auto other = replayed(reader, {"decision.weights.epsilon=3"});
    REQUIRE(other);
    CHECK_FALSE(other->same());
    bool decision = false;
    for (const auto& d : other->differences) decision = decision || d.topic == Topic::Decision;
    CHECK(decision);
  }
  {
    INFO("cut in the middle, it is replayed up to there");
    const auto size = std::filesystem::file_size(file);
    std::filesystem::resize_file(file, size * 6 / 10);
    const McapReader cut = opened(file);
    CHECK_FALSE(cut.info().complete);
    const auto part = replayed(cut);
    REQUIRE(part);
    CHECK(part->same());
    CHECK_FALSE(part->notes.empty());
    CHECK(part->cycles < again->cycles);
    CHECK(part->compared.at(Topic::Status) > 50);
  }
  std::filesystem::remove(file);
}

TEST_CASE("a recording has the robot's model once, and object and partner in the frames that show them",
          "[lift]") {
  const auto file =
      std::filesystem::temp_directory_path() / ("colift-tracked-" + std::to_string(::getpid()) + ".mcap");
  const Recorded recorded = run(short_lift(), &file);
  const McapReader reader = opened(file);
  std::vector<std::string> models;
  std::set<std::int64_t> exposures;
  std::map<std::string, std::map<std::int64_t, hal::Vec3>> seen;
  auto cursor = reader.messages({"/robot_description", "/camera/frame", "/tf/tracked"});
  while (const auto message = cursor.next()) {
    const std::string& topic = reader.info().channels.at(message->channel_id).topic;
    if (topic == "/robot_description") {
      models.emplace_back(parse_string(message->data).value());
      continue;
    }
    const auto j = nlohmann::json::parse(message->data);
    if (topic == "/camera/frame") exposures.insert(j["exposed_at"].get<std::int64_t>());
    if (topic != "/tf/tracked") continue;
    CHECK_FALSE(j["transforms"].empty());
    for (const auto& t : j["transforms"]) {
      const auto at = t["timestamp"]["sec"].get<std::int64_t>() * 1'000'000'000 +
                      t["timestamp"]["nsec"].get<std::int64_t>();
      const auto& p = t["translation"];
      CHECK(seen[t["child_frame_id"]].emplace(at, hal::Vec3(p["x"], p["y"], p["z"])).second);
      CHECK(exposures.count(at) == 1);  // of a frame that has come, and of no other time
    }
  }
  CHECK(models == std::vector<std::string>{built_in_robot_urdf()});
  REQUIRE(seen.size() == 2);

  const auto& object = seen.at("object");
  const auto& curve = recorded.record.curve;
  const auto followed = std::count_if(curve.begin(), curve.end(),
                                      [](const auto& sample) { return sample.X_WTnow_WTref.has_value(); });
  CHECK(object.size() == static_cast<std::size_t>(followed) + 1);  // and the look at the scene
  double top_m = 0.0;
  for (const auto& [at, place] : object) top_m = std::max(top_m, place.z() - object.begin()->second.z());
  REQUIRE(recorded.record.lift);
  CHECK(top_m == Approx(recorded.record.lift->height_m).margin(0.01));
  CHECK(object.rbegin()->second.z() == Approx(object.begin()->second.z()).margin(0.01));  // stands again

  // from his touch on until he leaves, and not a frame longer; within a hand's width of where he was decided
  // to be
  const auto& partner = seen.at("partner");
  CHECK(partner.size() > 100);
  CHECK(partner.begin()->first > object.begin()->first);
  CHECK(partner.rbegin()->first < *exposures.rbegin());
  REQUIRE(recorded.record.decision->partner);
  for (const auto& [at, place] : partner)
    CHECK((place - recorded.record.decision->partner->position).head<2>().norm() < 0.12);
  std::filesystem::remove(file);
}

TEST_CASE("a camera that was pushed is shown where it is, and its recording is replayed to the bit",
          "[lift]") {
  const auto file =
      std::filesystem::temp_directory_path() / ("colift-pushed-" + std::to_string(::getpid()) + ".mcap");
  const sim_hal::Scenario scenario = short_lift();
  hal::Pose pushed = hal::Pose::Identity();
  pushed.translation() = hal::Vec3(0.015, -0.01, 0.0);
  const Recorded recorded = run(scenario, &file, pushed);
  CHECK(recorded.record.outcome == control::RunRecord::Result::Lifted);
  REQUIRE(recorded.record.camera_correction);
  INFO(recorded.record.camera_correction->reason);
  REQUIRE(recorded.record.camera_correction->applied());

  const McapReader reader = opened(file);
  auto cursor = reader.messages({"/tf"});
  // a point of the workspace, as whoever takes the camera's pose from /tf sees it
  const hal::Pose X_WC = sim_hal::camera_pose(scenario.camera);
  const hal::Vec3 place(0.9, 0.0, 0.4);
  std::vector<double> off_m;
  while (const auto message = cursor.next()) {
    const auto all = nlohmann::json::parse(message->data);
    for (const auto& t : all["transforms"])
      if (t["child_frame_id"] == "camera") {
        const auto &p = t["translation"], &r = t["rotation"];
        hal::Pose shown(Eigen::Quaterniond(r["w"], r["x"], r["y"], r["z"]));
        shown.pretranslate(hal::Vec3(p["x"], p["y"], p["z"]));
        off_m.push_back((shown * X_WC.inverse() * place - place).norm());
      }
  }
  REQUIRE(off_m.size() > 50);
  CHECK(off_m.front() == Approx(pushed.translation().norm()).margin(1e-6));
  CHECK(off_m.back() < 0.5 * off_m.front());

  const auto again = replayed(reader);
  REQUIRE(again);
  CHECK(again->same());
  REQUIRE(again->record.camera_correction);
  CHECK(again->record.camera_correction->reason == recorded.record.camera_correction->reason);
  std::filesystem::remove(file);
}
