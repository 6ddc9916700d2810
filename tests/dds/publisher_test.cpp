#include <atomic>
#include <catch2/catch.hpp>
#include <future>

#include "hal/robot_model/robot_model.hpp"
#include "tests/dds/peer_process.hpp"
#include "tests/dds/ros_messages.hpp"
#include "tools/dds/ros2_publisher.hpp"
#include "tools/telemetry/channels/messages.hpp"
#include "tools/telemetry/channels/string_message.hpp"

namespace colift::tests {
namespace {

using namespace std::chrono_literals;
using telemetry::Publication;
using telemetry::Topic;

std::unique_ptr<ros2::Ros2Publisher> open(std::size_t queue = 256) {
  ros2::PublisherConfig config;
  config.dds.domain = test_domain();
  config.queue_messages = queue;
  auto made = ros2::Ros2Publisher::open(config);
  if (!made) FAIL(made.error().text());
  return std::move(*made);
}

Publication transforms(double y, hal::Timestamp at = 5s) {
  hal::Pose X_WC = hal::Pose::Identity();
  X_WC.translation() = hal::Vec3(1.0, y, 3.0);
  return {Topic::Transforms, at, [X_WC, at] {
            return telemetry::transforms_message(at, hal::built_in_robot(), hal::JointVector::Zero(), {},
                                                 X_WC);
          }};
}

Publication description(const std::string& urdf) {
  return {Topic::Description, 0s, [urdf] { return telemetry::string_message(urdf); }};
}

}  // namespace

TEST_CASE("the camera is in /tf_static alone, and each link has one parent", "[dds][publisher]") {
  const auto publisher = open();
  FastPeer peer(test_domain());
  const auto fixed = peer.reader("rt/tf_static", "tf2_msgs::msg::dds_::TFMessage_", {true, true, 1});
  const auto moving = peer.reader("rt/tf", "tf2_msgs::msg::dds_::TFMessage_");
  std::optional<Bytes> links;
  for (int i = 0; i < 100 && !links; ++i) {
    publisher->publish(transforms(2.0));
    links = moving->next(100ms);
  }
  REQUIRE(links);
  const auto camera = fixed->next(10'000ms);
  REQUIRE(camera);
  const auto rest = transforms_of(*camera);
  REQUIRE(rest.size() == 1);
  CHECK(rest[0].child_frame_id == "camera");
  CHECK(rest[0].header.frame_id == "world");
  CHECK(rest[0].translation == std::array<double, 3>{1.0, 2.0, 3.0});
  CHECK(rest[0].rotation == std::array<double, 4>{0.0, 0.0, 0.0, 1.0});
  std::vector<std::string> children;
  for (const auto& t : transforms_of(*links)) children.push_back(t.child_frame_id);
  std::size_t links_of_robot = 0;
  for (const auto& link : hal::built_in_robot().links) links_of_robot += link.name != "world";
  CHECK(children.size() == links_of_robot);
  std::sort(children.begin(), children.end());
  CHECK(std::adjacent_find(children.begin(), children.end()) == children.end());
  CHECK(std::find(children.begin(), children.end(), "camera") == children.end());
  // it is sent once more only where it differs
  publisher->publish(transforms(2.0));
  publisher->publish(transforms(4.0));
  const auto moved = fixed->next(10'000ms);
  REQUIRE(moved);
  CHECK(transforms_of(*moved)[0].translation[1] == 4.0);
}

TEST_CASE("stamps are the system's time", "[dds][publisher]") {
  const auto publisher = open();
  FastPeer peer(test_domain());
  const auto reader = peer.reader("rt/tf", "tf2_msgs::msg::dds_::TFMessage_");
  std::optional<Bytes> got;
  for (int i = 0; i < 100 && !got; ++i) {
    publisher->publish(transforms(2.0));
    got = reader->next(100ms);
  }
  REQUIRE(got);
  CHECK(std::abs(transforms_of(*got)[0].header.stamp.seconds() - system_stamp().seconds()) < 60.0);
  // of a simulation that ran ahead too
  publisher->publish(transforms(2.0, 5000s));
  auto last = got;
  while (auto next = reader->next(2'000ms)) last = next;
  CHECK(std::abs(transforms_of(*last)[0].header.stamp.seconds() - system_stamp().seconds()) < 60.0);
}

TEST_CASE("a full queue drops the oldest and never waits", "[dds][publisher]") {
  const auto publisher = open(8);
  std::promise<void> begun, go;
  const auto may_go = go.get_future().share();
  // latched, so it is encoded whoever listens
  publisher->publish({Topic::Decision, 0s, [&begun, may_go] {
                        begun.set_value();
                        may_go.wait();
                        return std::string("{}");  // lacks everything
                      }});
  begun.get_future().wait();
  for (int i = 0; i < 100; ++i) publisher->publish({Topic::Joints, 0s, [] { return std::string("{}"); }});
  const auto counts = publisher->counts();
  CHECK(counts.handed_in == 101);
  CHECK(counts.dropped == 92);
  go.set_value();
  CHECK(publisher->flush(10'000ms));
  CHECK(publisher->counts().failed == 1);  // nobody subscribed to the joints
}

TEST_CASE("a flood of joints does not push a decision out of the queue", "[dds][publisher]") {
  const auto publisher = open(8);
  std::promise<void> begun, go;
  const auto may_go = go.get_future().share();
  publisher->publish({Topic::Map, 0s, [&begun, may_go] {
                        begun.set_value();
                        may_go.wait();
                        return std::string("{}");
                      }});
  begun.get_future().wait();
  std::atomic<int> encoded{0};
  for (int i = 0; i < 3; ++i)
    publisher->publish({Topic::Decision, 0s, [&encoded, i] {
                          encoded = i + 1;
                          return std::string("{}");
                        }});
  for (int i = 0; i < 100; ++i) publisher->publish({Topic::Joints, 0s, [] { return std::string("{}"); }});
  go.set_value();
  CHECK(publisher->flush(10'000ms));
  CHECK(encoded == 3);                     // the newest
  CHECK(publisher->counts().failed == 2);  // the map, and one decision: both lack everything
}

TEST_CASE("a subscriber that is dead does not hold up the others", "[dds][publisher]") {
  const auto publisher = open();
  const PeerProcess dead({"read", std::to_string(test_domain()), "rt/tf", "tf2_msgs::msg::dds_::TFMessage_"});
  FastPeer peer(test_domain());
  const auto reader = peer.reader("rt/tf", "tf2_msgs::msg::dds_::TFMessage_");
  std::optional<Bytes> got;
  for (int i = 0; i < 100 && !got; ++i) {
    publisher->publish(transforms(2.0));
    got = reader->next(100ms);
  }
  REQUIRE(got);
  dead.signal(SIGSTOP);  // it acknowledges nothing any more
  for (int i = 0; i < 200; ++i) publisher->publish(transforms(2.0));
  int received = 0;
  while (received < 200 && reader->next(5'000ms)) ++received;
  CHECK(received >= 10);  // what keep last holds, at least
}

TEST_CASE("object and partner are on /tf beside the links, stamped with their frame", "[dds][publisher]") {
  const auto publisher = open();
  FastPeer peer(test_domain());
  const auto reader = peer.reader("rt/tf", "tf2_msgs::msg::dds_::TFMessage_");
  control::TrackedPoses tracked;
  tracked.at = 4s;
  tracked.X_WO = hal::Pose::Identity();
  tracked.X_WO->translation() = hal::Vec3(0.9, 0.0, 0.5);
  tracked.partner_W = hal::Vec3(0.9, -0.6, 0.5);
  std::vector<RosTransform> found;
  bool links = false;
  for (int i = 0; i < 100 && (found.size() < 2 || !links); ++i) {
    publisher->publish(transforms(2.0));
    publisher->publish({Topic::Tracked, 5s, [tracked] { return telemetry::tracked_message(tracked); }});
    while (const auto got = reader->next(50ms)) {
      const auto all = transforms_of(*got);
      if (all.size() > 2)
        links = true;
      else
        found = all;
    }
  }
  CHECK(links);
  REQUIRE(found.size() == 2);
  CHECK(found[0].child_frame_id == "object");
  CHECK(found[0].translation == std::array<double, 3>{0.9, 0.0, 0.5});
  CHECK(found[1].child_frame_id == "partner");
  CHECK(found[1].header.frame_id == "world");
}

TEST_CASE("the robot's model reaches a node that comes later, whatever came in between", "[dds][publisher]") {
  const auto publisher = open(8);
  publisher->publish(description("<robot name=\"first\"/>"));
  publisher->publish(description("<robot name=\"second\"/>"));
  for (int i = 0; i < 200; ++i) publisher->publish(transforms(2.0));
  CHECK(publisher->flush(10'000ms));
  FastPeer peer(test_domain());
  const auto reader = peer.reader("rt/robot_description", "std_msgs::msg::dds_::String_", {true, true, 1});
  const auto got = reader->next(20'000ms);
  REQUIRE(got);
  CHECK(string_of(*got) == "<robot name=\"second\"/>");
}

TEST_CASE("garbage on a published topic changes nothing", "[dds][publisher]") {
  const auto publisher = open();
  publisher->publish(description("<robot/>"));
  const PeerProcess flood(
      {"flood", std::to_string(test_domain()), "rt/tf", "tf2_msgs::msg::dds_::TFMessage_"});
  FastPeer peer(test_domain());
  const auto reader = peer.reader("rt/robot_description", "std_msgs::msg::dds_::String_", {true, true, 1});
  const auto got = reader->next(20'000ms);
  REQUIRE(got);
  CHECK(string_of(*got) == "<robot/>");
}

}  // namespace colift::tests
