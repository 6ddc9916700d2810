#include <catch2/catch.hpp>
#include <fstream>
#include <limits>
#include <sstream>

#include "hal/robot_model/robot_model.hpp"

using namespace colift::hal;

namespace {

std::string good() {
  std::ifstream in(COLIFT_SOURCE_DIR "/config/robot/lwr_bhand.urdf");
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// The shipped URDF with the first `from` after `behind` replaced.
std::string spoilt(const std::string& behind, const std::string& from, const std::string& to) {
  std::string text = good();
  const std::size_t start = text.find(behind);
  REQUIRE(start != std::string::npos);
  const std::size_t at = text.find(from, start);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

void check_refused(const std::string& urdf, ErrorCode code, const std::string& where,
                   const std::string& says) {
  const auto robot = parse_robot(urdf, "r.urdf");
  REQUIRE_FALSE(robot);
  CHECK(robot.error().code == code);
  CHECK_THAT(robot.error().where, Catch::Matchers::StartsWith(where));
  CHECK_THAT(robot.error().detail, Catch::Matchers::Contains(says));
}

}  // namespace

TEST_CASE("the shipped file is the built-in robot") {
  const auto robot = load_robot(COLIFT_SOURCE_DIR "/config/robot/lwr_bhand.urdf");
  REQUIRE(robot);
  CHECK(robot->name == "lwr_bhand");
  CHECK(robot->links.size() == built_in_robot().links.size());
  for (std::size_t i = 0; i < robot->links.size(); ++i) CHECK(robot->links[i].parent < static_cast<int>(i));
}

TEST_CASE("what is no URDF is refused with the place") {
  check_refused("", ErrorCode::BadInput, "r.urdf", "empty");
  check_refused(" \n\t", ErrorCode::BadInput, "r.urdf", "empty");
  check_refused("length: 3", ErrorCode::BadInput, "r.urdf", "");
  check_refused("<robot name='a'>\n<link name='b'>\n</robot>", ErrorCode::BadInput, "r.urdf:", "is no XML");
  check_refused("<mujoco/>", ErrorCode::BadInput, "r.urdf", "<robot>");
  check_refused("<robot name='a'/>", ErrorCode::BadConfig, "r.urdf", "link");
  check_refused(good().substr(0, good().size() / 2), ErrorCode::BadInput, "r.urdf", "");
  std::string deep;
  for (int i = 0; i < 200000; ++i) deep += "<a>";
  check_refused(deep, ErrorCode::BadInput, "r.urdf", "deep");
}

TEST_CASE("a file that is not there is refused") {
  const auto robot = load_robot("/nowhere/robot.urdf");
  REQUIRE_FALSE(robot);
  CHECK(robot.error().code == ErrorCode::BadInput);
  CHECK(robot.error().where == "/nowhere/robot.urdf");
}

TEST_CASE("a joint without limits is refused by name") {
  const std::string limit = R"(<limit lower="-2.0943951023932" upper="2.0943951023932" )";
  const auto bad = [&](const std::string& to, const std::string& says) {
    check_refused(spoilt("name=\"arm_4\"", limit, to), ErrorCode::BadConfig, "r.urdf", says);
  };
  bad(R"(<limits lower="-2.0943951023932" upper="2.0943951023932" )", "arm_4");
  bad(R"(<limit lower="2" upper="-2" )", "joint arm_4: limits are 2 to -2 rad");
  bad(R"(<limit lower="nan" upper="1" )", "arm_4");
  bad(R"(<limit )", "joint arm_4: limits are 0 to 0 rad");
  bad(R"(<limit lower="-2" upper="two" )", "");
}

TEST_CASE("the place of a wrong element is its line") {
  const std::string text = spoilt("name=\"forearm\"", R"(<mass value="2.3034"/>)", R"(<mass value="-2.3"/>)");
  const auto robot = parse_robot(text, "r.urdf");
  REQUIRE_FALSE(robot);
  CHECK(robot.error().detail == "link forearm: mass is -2.3, expected more than 0 kg");
  int line = 1;
  for (const char c : text.substr(0, text.find("<link name=\"forearm\""))) line += c == '\n';
  CHECK(robot.error().where == "r.urdf:" + std::to_string(line));
}

TEST_CASE("bodies that cannot be are refused") {
  const auto bad = [](const std::string& from, const std::string& to, const std::string& says) {
    check_refused(spoilt("<link name=\"elbow\"", from, to), ErrorCode::BadConfig, "r.urdf", says);
  };
  bad(R"(<mass value="2.3034"/>)", R"(<mass value="0"/>)", "link elbow: mass is 0");
  bad(R"(<mass value="2.3034"/>)", R"(<mass value="nan"/>)", "");
  bad(R"(ixx="0.01561")", R"(ixx="-0.01561")", "link elbow: no body has such an inertia");
  bad(R"(ixx="0.01561")", R"(ixx="1.5")", "link elbow: no body has such an inertia");
}

TEST_CASE("shapes that are meshes or have no size are refused") {
  const std::string shape = R"(<cylinder radius="0.0625" length="0.17"/>)";
  const auto bad = [&](const std::string& to, const std::string& says) {
    check_refused(spoilt("<link name=\"forearm\"", shape, to), ErrorCode::BadConfig, "r.urdf", says);
  };
  bad(R"(<mesh filename="package://forearm.stl"/>)", "link forearm: a collision shape is a mesh");
  bad(R"(<cylinder radius="-0.06" length="0.17"/>)", "link forearm");
  bad(R"(<cylinder radius="0.06" length="0"/>)", "link forearm");
  bad(R"(<capsule radius="0.06"/>)", "");
}

TEST_CASE("a robot that is no LWR with a BarrettHand is refused") {
  check_refused(spoilt("name=\"arm_5\"", "arm_5", "wheel"), ErrorCode::BadConfig, "r.urdf",
                "revolute joint arm_5 is missing");
  check_refused(spoilt("name=\"arm_5\"", "revolute", "prismatic"), ErrorCode::BadConfig,
                "r.urdf:", "joint arm_5 is neither revolute nor fixed");
  check_refused(spoilt("name=\"finger_3_outer\"", "name=\"finger_3_outer\"", "name=\"thumb\""),
                ErrorCode::BadConfig, "r.urdf", "finger_3_outer is missing");
  check_refused(spoilt("name=\"arm_1\"", "0 0 1", "0 0 2"), ErrorCode::BadConfig,
                "r.urdf:", "joint arm_1: the axis");
  // A2 and A3 with their names exchanged
  std::string swapped = spoilt("name=\"arm_2\"", "arm_2", "arm_x");
  swapped.replace(swapped.find("\"arm_3\""), 7, "\"arm_2\"");
  swapped.replace(swapped.find("\"arm_x\""), 7, "\"arm_3\"");
  check_refused(swapped, ErrorCode::BadConfig, "r.urdf:", "is carried by");
}

TEST_CASE("links in a circle are refused") {
  check_refused(R"(<robot name="r"><link name="a"/><link name="b"/><link name="c"/>
    <joint name="1" type="fixed"><parent link="a"/><child link="b"/></joint>
    <joint name="2" type="fixed"><parent link="b"/><child link="c"/></joint>
    <joint name="3" type="fixed"><parent link="c"/><child link="b"/></joint></robot>)",
                ErrorCode::BadConfig, "r.urdf", "link b is carried by two joints");
  check_refused(R"(<robot name="r"><link name="a"/><link name="b"/>
    <joint name="1" type="fixed"><parent link="a"/><child link="b"/></joint>
    <joint name="2" type="fixed"><parent link="b"/><child link="a"/></joint></robot>)",
                ErrorCode::BadConfig, "r.urdf", "link a hangs on itself");
}

TEST_CASE("every cut of the file is refused without a crash") {
  const std::string text = good();
  for (std::size_t n = 0; n < text.size() - 20; n += 97) {
    const auto robot = parse_robot(text.substr(0, n), "r.urdf");
    REQUIRE_FALSE(robot);
    REQUIRE_FALSE(robot.error().detail.empty());
  }
}
