// Bags of ROS 2 made from recordings. That others read them: tests/mcap.

#include <catch2/catch.hpp>
#include <filesystem>
#include <random>

#include "tests/unit/tools/telemetry/made_recording.hpp"
#include "tools/dds/export_ros2.hpp"
#include "tools/dds/message_definition.hpp"
#include "tools/telemetry/channels/string_message.hpp"
#include "tools/telemetry/mcap/mcap_reader.hpp"

namespace bag_trials {

using namespace colift;
using Catch::Contains;
using telemetry::McapReader;

const std::string kJoints =
    R"({"joints": [{"name": "arm_1", "position": 0.5, "effort": null}, {"name": "arm_2", "position": -1}]})";

McapReader opened(std::string bytes) {
  auto reader = McapReader::open(telemetry::source_of(std::move(bytes)), "made");
  REQUIRE(reader);
  return std::move(*reader);
}

struct Folder {
  std::filesystem::path path = std::filesystem::temp_directory_path() / "colift_bag_test";
  Folder() { std::filesystem::remove_all(path); }
  ~Folder() { std::filesystem::remove_all(path); }
};

hal::Result<telemetry::Exported> exported(const tests::MadeRecording& recording, const Folder& folder) {
  return ros2::export_ros2(opened(tests::bytes_of(recording)), folder.path);
}

McapReader bag_in(const Folder& folder) {
  auto source = telemetry::open_file(folder.path / "bag_0.mcap");
  REQUIRE(source);
  auto reader = McapReader::open(std::move(*source), "bag");
  REQUIRE(reader);
  return std::move(*reader);
}

}  // namespace bag_trials

using namespace bag_trials;

TEST_CASE("a definition names its members and every type it is made of, once", "[bag]") {
  const auto tf = ros2::message_definition("tf2_msgs/msg/TFMessage");
  REQUIRE(tf);
  CHECK(*tf == "geometry_msgs/TransformStamped[] transforms\n" + std::string(80, '=') +
                   "\nMSG: geometry_msgs/TransformStamped\nstd_msgs/Header header\nstring child_frame_id\n"
                   "geometry_msgs/Transform transform\n" +
                   std::string(80, '=') +
                   "\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n" +
                   std::string(80, '=') +
                   "\nMSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\n"
                   "geometry_msgs/Quaternion rotation\n" +
                   std::string(80, '=') + "\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n" +
                   std::string(80, '=') + "\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n" +
                   std::string(80, '=') +
                   "\nMSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n");
  CHECK_THAT(*ros2::message_definition("sensor_msgs/msg/CameraInfo"), Contains("float64[12] p\n"));
  CHECK(ros2::message_definition("sensor_msgs/msg/Imu").error().code == hal::ErrorCode::NotFound);
  CHECK(ros2::ros2_type("sensor_msgs::msg::dds_::Image_") == "sensor_msgs/msg/Image");
}

TEST_CASE("an IDL that is none is refused with what was found", "[bag]") {
  using namespace std::string_view_literals;
  for (const auto idl :
       {"struct"sv, "struct A {"sv, "struct A { long"sv, "struct A { long a; }"sv, "} ;"sv,
        "module a { struct B_ { sequence<long a; }; };"sv, "typedef long a;"sv, "enum A {};"sv}) {
    const auto refused = ros2::message_definition(idl, "a/msg/B");
    INFO(idl);
    REQUIRE_FALSE(refused);
    CHECK(refused.error().code == hal::ErrorCode::BadInput);
  }
  std::mt19937 random(3);
  const std::string letters = "struct module typedef long {};<>[]:: a_ sequence @topic // \n";
  for (int i = 0; i < 2000; ++i) {
    std::string idl;
    for (int k = 0; k < 60; ++k) idl += letters[random() % letters.size()];
    (void)ros2::message_definition(idl, "a/msg/B");
  }
}

TEST_CASE("a bag's times are the recording's, moved to the date of the run", "[bag]") {
  const Folder folder;
  const auto done = exported({{{"/joint_states", 2.5, kJoints}, {"/joint_states", 4.0, kJoints}}}, folder);
  REQUIRE(done);
  const McapReader bag = bag_in(folder);
  CHECK(bag.info().profile == "ros2");
  // 2026-01-02 03:04:05 UTC
  CHECK(bag.info().statistics.start_time == 1767323045'000000000u);
  CHECK(bag.info().statistics.end_time == 1767323046'500000000u);
  REQUIRE(bag.info().channel("/joint_states"));
  CHECK(bag.info().channel("/joint_states")->message_encoding == "cdr");
  CHECK(bag.info().statistics.messages == 3);  // the robot's description is the third
  CHECK(std::filesystem::exists(folder.path / "metadata.yaml"));
}

TEST_CASE("a recording without a date gives a bag of 1970, and says so", "[bag]") {
  for (const char* started : {"", "yesterday", "2026-01-02T03:04:05Z and more"}) {
    const Folder folder;
    const auto done = exported({.messages = {{"/joint_states", 2.5, kJoints}}, .started = started}, folder);
    REQUIRE(done);
    REQUIRE(done->notes.size() == 1);
    CHECK_THAT(done->notes[0], Contains("1970"));
    CHECK(bag_in(folder).info().statistics.start_time == 2'500'000'000u);
  }
}

TEST_CASE("messages that are not what their topic says are counted and left out", "[bag]") {
  std::vector<tests::MadeMessage> lies{{"/joint_states", 1.0, kJoints}};
  for (const char* topic : {"/joint_states", "/tf", "/cloud", "/scene", "/map", "/bodies", "/task/status",
                            "/decision", "/devices", "/camera/frame", "/tf/tracked", "/robot_description"})
    for (const char* lie : {"", "[", "null", "3", "[]", "{}", R"({"transforms": []})", R"({"transforms": 3})",
                            R"({"joints": {"a": 1}})", R"({"entities": [3]})",
                            R"({"timestamp": {"sec": 9223372036854775807, "nsec": 9223372036854775807},
              "frame_id": "a", "point_stride": 1, "data": "AAAA", "fields": []})",
                            R"({"exposed_at": -9223372036854775808, "width": -1, "height": 1e300, "fx": 1})",
                            R"({"chosen": 1e99, "candidates": "none"})", R"({"devices": [[]]})"})
      lies.push_back({topic, 2.0, lie});
  std::mt19937 random(4);
  for (int i = 0; i < 200; ++i) {
    std::string image(random() % 80, '\0');
    for (char& byte : image) byte = static_cast<char>(random() % 8 == 0 ? random() : 0);
    lies.push_back({"/camera/depth", 2.0, image, "cdr"});
  }
  lies.push_back({"/load", 3.0, "{}"});
  const Folder folder;
  const auto done = exported({lies}, folder);
  REQUIRE(done);
  REQUIRE(done->notes.size() == 2);
  CHECK_THAT(done->notes[0], Contains("messages could not be converted"));
  CHECK_THAT(done->notes[1], Contains("left out: /load"));
  CHECK(bag_in(folder).info().damage.empty());
}

TEST_CASE("the robot's model is the recording's own message, and that of an old recording its attachment",
          "[bag]") {
  const auto description_in = [](const Folder& folder) {
    const McapReader bag = bag_in(folder);
    auto cursor = bag.messages({"/robot_description"});
    std::vector<std::string> all;
    while (const auto message = cursor.next()) {
      const auto text = telemetry::parse_string(message->data);
      REQUIRE(text);
      all.emplace_back(*text);
    }
    CHECK_THAT(bag.info().channel("/robot_description")->metadata.at("offered_qos_profiles"),
               Contains("durability: 1"));
    return all;
  };
  const Folder folder;
  const std::string urdf = telemetry::string_message("<robot name=\"its own\"/>");
  const auto done =
      exported({{{"/robot_description", 0.5, urdf, "cdr"}, {"/joint_states", 1.0, kJoints}}}, folder);
  REQUIRE(done);
  CHECK(done->notes.empty());
  CHECK(description_in(folder) == std::vector<std::string>{"<robot name=\"its own\"/>"});
  const Folder old_folder;
  REQUIRE(exported({{{"/joint_states", 1.0, kJoints}}}, old_folder));
  const auto built_in = description_in(old_folder);
  REQUIRE(built_in.size() == 1);
  CHECK_THAT(built_in[0], Contains("<robot"));
  // what is no text is counted, as every lie, and the attachment serves
  const Folder lie_folder;
  const auto lie =
      exported({{{"/robot_description", 0.5, urdf.substr(0, 12), "cdr"}, {"/joint_states", 1.0, kJoints}}},
               lie_folder);
  REQUIRE(lie);
  REQUIRE(lie->notes.size() == 1);
  CHECK_THAT(lie->notes[0], Contains("1 messages could not be converted"));
  CHECK(description_in(lie_folder) == built_in);
}

TEST_CASE("object and partner share /tf with the links: one topic of the bag", "[bag]") {
  const auto moving = [](const char* child) {
    return std::string(
               R"({"transforms": [{"timestamp": {"sec": 1, "nsec": 5}, "parent_frame_id": "world",)") +
           R"("child_frame_id": ")" + child +
           R"(", "translation": {"x": 1, "y": 2, "z": 3}, "rotation": {"x": 0, "y": 0, "z": 0, "w": 1}}]})";
  };
  const Folder folder;
  const auto done =
      exported({{{"/tf", 1.0, moving("arm_1")}, {"/tf/tracked", 1.01, moving("object")}}}, folder);
  REQUIRE(done);
  CHECK(done->notes.empty());
  const McapReader bag = bag_in(folder);
  std::size_t channels = 0;
  for (const auto& [id, channel] : bag.info().channels) channels += channel.topic == "/tf";
  CHECK(channels == 1);
  CHECK(bag.info().statistics.per_channel.at(bag.info().channel("/tf")->id) == 2);
}

TEST_CASE("no bag is left of a recording that has nothing for one", "[bag]") {
  const Folder folder;
  const auto none = exported({{{"/load", 1.0, "{}"}}}, folder);
  REQUIRE_FALSE(none);
  CHECK(none.error().code == hal::ErrorCode::BadInput);
  CHECK_FALSE(std::filesystem::exists(folder.path / "bag_0.mcap"));
  CHECK_FALSE(ros2::export_ros2(opened(tests::bytes_of({{{"/joint_states", 1.0, kJoints}}})),
                                "/proc/no/such/folder"));
}
