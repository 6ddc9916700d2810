#include <dds/dds.h>
#include <netinet/in.h>
#include <ros2_messages.h>
#include <sys/socket.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "hal/dds/participant.hpp"
#include "hal/dds/ros2_names.hpp"
#include "hal/dds/samples.hpp"
#include "tests/dds/peer_process.hpp"
#include "tests/dds/ros_messages.hpp"

namespace colift::tests {
namespace {

using namespace std::chrono_literals;
using hal::dds::Participant;
using hal::dds::Qos;
using hal::dds::Sample;

constexpr auto kSoon = 20'000ms;

std::unique_ptr<Participant> open() {
  auto made = Participant::open({test_domain(), "lo", "colift"});
  if (!made) FAIL(made.error().text());
  return std::move(*made);
}

template <class T>
void fill(Sample<T>& s, int sec) {
  s->header.stamp = {sec, 5};
}

}  // namespace

TEST_CASE("a message arrives at another implementation byte for byte", "[dds]") {
  FastPeer peer(test_domain());
  const auto reader = peer.reader("rt/joint_states", "sensor_msgs::msg::dds_::JointState_");
  const auto participant = open();
  const auto writer =
      participant->writer("/joint_states", sensor_msgs_msg_dds__JointState__desc, Qos::Latched);
  REQUIRE(writer);
  RosJointState wanted{{{7, 5}, "base"}, {"a", "joint_two", ""}, {1.5, -2.25, 1e-300}, {}, {3.0}};
  Sample<sensor_msgs_msg_dds__JointState_> s(sensor_msgs_msg_dds__JointState__desc);
  s->header.stamp = {7, 5};
  hal::dds::set(s->header.frame_id, "base");
  char** names = hal::dds::resize(s->name, 3);
  for (int i = 0; i < 2; ++i) hal::dds::set(names[i], wanted.name[static_cast<std::size_t>(i)]);
  std::copy(wanted.position.begin(), wanted.position.end(), hal::dds::resize(s->position, 3));
  *hal::dds::resize(s->effort, 1) = 3.0;
  REQUIRE(dds_write(*writer, &*s) == DDS_RETCODE_OK);
  // a volatile reader misses what was written before it was found: again until it is there
  std::optional<Bytes> got;
  for (int i = 0; i < 100 && !got; ++i) {
    (void)dds_write(*writer, &*s);
    got = reader->next(200ms);
  }
  REQUIRE(got);
  const Bytes expected = bytes_of(wanted);
  REQUIRE(got->size() >= expected.size());
  CHECK(got->size() - expected.size() < 4);  // padding to four bytes
  CHECK(std::equal(expected.begin(), expected.end(), got->begin()));
}

TEST_CASE("a depth image of 640 x 480 arrives whole", "[dds]") {
  FastPeer peer(test_domain());
  const auto reader = peer.reader("rt/depth", "sensor_msgs::msg::dds_::Image_", {false, false, 5});
  const auto participant = open();
  const auto writer = participant->writer("/depth", sensor_msgs_msg_dds__Image__desc, Qos::Frames);
  REQUIRE(writer);
  Sample<sensor_msgs_msg_dds__Image_> s(sensor_msgs_msg_dds__Image__desc);
  s->height = 480, s->width = 640, s->step = 1280;
  hal::dds::set(s->encoding, "16UC1");
  std::uint8_t* data = hal::dds::resize(s->data, 614400);
  for (std::size_t i = 0; i < 614400; ++i) data[i] = static_cast<std::uint8_t>(i * 7 + i / 251);
  std::optional<Bytes> got;
  for (int i = 0; i < 100 && !got; ++i) {
    REQUIRE(dds_write(*writer, &*s) == DDS_RETCODE_OK);
    got = reader->next(200ms);
  }
  REQUIRE(got);
  const RosImage image = image_of(*got);
  CHECK(image.encoding == "16UC1");
  REQUIRE(image.data.size() == 614400);
  CHECK(std::equal(image.data.begin(), image.data.end(), data));
}

TEST_CASE("a latched message reaches a reader that comes later", "[dds]") {
  const auto participant = open();
  const auto writer = participant->writer("/robot_description", std_msgs_msg_dds__String__desc, Qos::Latched);
  REQUIRE(writer);
  Sample<std_msgs_msg_dds__String_> s(std_msgs_msg_dds__String__desc);
  const std::string text(200'000, 'x');
  hal::dds::set(s->data, text);
  REQUIRE(dds_write(*writer, &*s) == DDS_RETCODE_OK);
  FastPeer peer(test_domain());
  const auto reader = peer.reader("rt/robot_description", "std_msgs::msg::dds_::String_", {true, true, 1});
  const auto got = reader->next(kSoon);
  REQUIRE(got);
  CHECK(string_of(*got) == text);
}

TEST_CASE("a node is found by its name, with the endpoints that others see", "[dds]") {
  const auto participant = open();
  const auto writer = participant->writer("/chatter", std_msgs_msg_dds__String__desc, Qos::Reliable);
  REQUIRE(writer);
  REQUIRE(participant->reader("/heard", std_msgs_msg_dds__String__desc, Qos::Reliable));
  FastPeer peer(test_domain());
  const auto heard = peer.reader("rt/chatter", "std_msgs::msg::dds_::String_");
  const auto graph = peer.reader("ros_discovery_info", "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_",
                                 {true, true, 1});
  const auto got = graph->next(kSoon);
  REQUIRE(got);
  const auto nodes = nodes_of(*got);
  REQUIRE(nodes.size() == 1);
  CHECK(nodes[0].name_space == "/");
  CHECK(nodes[0].name == "colift");
  REQUIRE(nodes[0].writers.size() == 1);
  CHECK(nodes[0].readers.size() == 1);
  Bytes matched;
  for (int i = 0; i < 200 && matched.empty(); ++i) {
    (void)heard->next(50ms);
    matched = heard->matched_writer();
  }
  CHECK(matched == nodes[0].writers[0]);
}

TEST_CASE("every socket of a domain takes packets of this machine alone", "[dds]") {
  const auto participant = open();
  const int first = 7400 + 250 * test_domain();
  int sockets = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    const int fd = std::stoi(entry.path().filename().string());
    sockaddr_in address{};
    socklen_t size = sizeof address;
    if (::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) != 0 || address.sin_family != AF_INET)
      continue;
    const int port = ntohs(address.sin_port);
    if (port == 0) continue;  // not bound: nothing comes
    const bool loopback = (ntohl(address.sin_addr.s_addr) >> 24) == 127;
    char device[16] = {};
    socklen_t length = sizeof device;
    ::getsockopt(fd, SOL_SOCKET, SO_BINDTODEVICE, device, &length);
    INFO("port " << port << " device " << device);
    CHECK((loopback || std::string(device) == "lo"));
    sockets += port >= first && port < first + 250;
  }
  CHECK(sockets >= 2);
}

TEST_CASE("names, domains and interfaces are checked before anything is opened", "[dds]") {
  CHECK(hal::dds::dds_topic_name("/camera/depth_2/image").value() == "rt/camera/depth_2/image");
  for (const char* wrong : {"", "/", "image", "/a//b", "/a/", "/2a", "/a b", "/a/../b", "/a\n"})
    CHECK_FALSE(hal::dds::dds_topic_name(wrong));
  CHECK_FALSE(hal::dds::dds_topic_name("/" + std::string(300, 'a')));
  CHECK_FALSE(Participant::open({102, "lo", "colift"}));
  const auto no_interface = Participant::open({test_domain() == 10 ? 11 : 10, "nic0", "colift"});
  REQUIRE_FALSE(no_interface);
  CHECK(no_interface.error().code == hal::ErrorCode::BadConfig);
  const auto participant = open();
  CHECK_FALSE(Participant::open({test_domain(), "eth7", "colift"}));
}

}  // namespace colift::tests
