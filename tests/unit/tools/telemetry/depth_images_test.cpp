// Depth frames in recordings: images that others read, and the old form.

#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "sim_hal/synthetic/kinect/kinect_code.hpp"
#include "tools/telemetry/channels/depth_cdt1.hpp"
#include "tools/telemetry/channels/image_message.hpp"
#include "tools/telemetry/channels/recorded_frame.hpp"
#include "tools/telemetry/replay/export.hpp"
#include "tools/telemetry/replay/replay_robot.hpp"

namespace {

using namespace colift;
using namespace colift::telemetry;

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// The same numbers to the bit, and NaN where it was; of a NaN only that it is one.
bool same_depth(const std::vector<float>& a, const std::vector<float>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](float x, float y) {
    return std::bit_cast<std::uint32_t>(x) == std::bit_cast<std::uint32_t>(y) ||
           (std::isnan(x) && std::isnan(y));
  });
}

hal::DepthFrame frame_of(int width, int height) {
  hal::DepthFrame f;
  f.exposed_at = hal::Timestamp(12'123456789);
  f.intrinsics = {width, height, 575.8, 575.9, 320.1, 0.1 + 0.2};
  f.up_C = hal::Vec3(0.1, -0.9, 1.0 / 3.0);
  f.depth_m.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), kNone);
  return f;
}

/// Through the messages of a recording and back.
hal::Result<NumberedFrame> recorded(std::uint64_t number, const hal::DepthFrame& f) {
  FrameJoiner joiner;
  CHECK_FALSE(joiner.add("/camera/frame", frame_message(number, f)));
  if (!f.rgb.empty()) CHECK_FALSE(joiner.add("/camera/color", colour_image(f)));
  const auto encoded = joiner.add("/camera/depth", depth_image(f));
  REQUIRE(encoded);
  CHECK(encoded->number == number);
  return decode_frame(*encoded);
}

void check_round_trip(const hal::DepthFrame& f) {
  const auto back = recorded(41, f);
  REQUIRE(back);
  CHECK(back->number == 41);
  CHECK(back->frame.exposed_at == f.exposed_at);
  CHECK(back->frame.intrinsics.width == f.intrinsics.width);
  CHECK(back->frame.intrinsics.fy == f.intrinsics.fy);
  CHECK(back->frame.intrinsics.cy == f.intrinsics.cy);
  CHECK(back->frame.up_C == f.up_C);
  CHECK(back->frame.rgb == f.rgb);
  CHECK(same_depth(back->frame.depth_m, f.depth_m));
}

std::string encoding_of(const hal::DepthFrame& f) {
  const std::string message = depth_image(f);
  return std::string(parse_image(message).value().encoding);
}

}  // namespace

TEST_CASE("a Kinect's frame is an image in millimetres and comes back to the bit", "[depth]") {
  std::mt19937 random(5);
  const auto& table = sim_hal::kinect_depths_m();
  hal::DepthFrame f = frame_of(64, 48);
  for (float& d : f.depth_m) d = table[random() % table.size()];
  for (float& d : f.depth_m)
    if (!(d > 0.0f) || d > 10.0f) d = kNone;  // as far as a Kinect reports
  CHECK(encoding_of(f) == "16UC1");
  check_round_trip(f);
  f.rgb.resize(3 * f.depth_m.size());
  for (std::uint8_t& c : f.rgb) c = static_cast<std::uint8_t>(random());
  f.up_C.reset();
  check_round_trip(f);
  // every whole millimetre that 16 bits hold
  f = frame_of(256, 256);
  for (std::size_t mm = 1; mm < f.depth_m.size(); ++mm)
    f.depth_m[mm] = static_cast<float>(static_cast<double>(mm) / 1000.0);
  CHECK(encoding_of(f) == "16UC1");
  check_round_trip(f);
}

TEST_CASE("depths that are no whole millimetres are floats, to the bit", "[depth]") {
  for (const float odd :
       {1.0005f, 0.0f, -0.0f, -1.0f, 70.0f, 0.0001f, std::numeric_limits<float>::infinity()}) {
    hal::DepthFrame f = frame_of(10, 8);
    f.depth_m[3] = 1.25f;
    f.depth_m[7] = odd;
    CHECK(encoding_of(f) == "32FC1");
    check_round_trip(f);
  }
  std::mt19937 random(6);
  hal::DepthFrame f = frame_of(100, 80);
  for (float& d : f.depth_m) d = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
  check_round_trip(f);
}

TEST_CASE("a frame of the wrong size is recorded as it is", "[depth]") {
  hal::DepthFrame f = frame_of(10, 8);
  f.depth_m.resize(13, 1.0f);
  f.rgb = {1, 2, 3, 4};
  check_round_trip(f);
  f.depth_m.clear();
  check_round_trip(f);
}

TEST_CASE("a depth image has the bytes that ROS 2 writes", "[depth]") {
  hal::DepthFrame f = frame_of(2, 1);
  f.exposed_at = hal::Timestamp(3'000'000'007);
  f.depth_m = {1.25f, kNone};
  const unsigned char expected[] = {0, 1, 0, 0,                      // CDR, little endian
                                    3, 0, 0, 0, 7,    0,    0,   0,  // header.stamp
                                    7, 0, 0, 0, 'c',  'a',  'm', 'e', 'r', 'a',
                                    0, 0,  // header.frame_id, and one byte to a multiple of four
                                    1, 0, 0, 0, 2,    0,    0,   0,            // height, width
                                    6, 0, 0, 0, '1',  '6',  'U', 'C', '1', 0,  // encoding
                                    0, 0,        // is_bigendian, one byte to a multiple of four
                                    4, 0, 0, 0,  // step
                                    4, 0, 0, 0, 0xe2, 0x04, 0,   0};  // data: 1250, 0
  CHECK(depth_image(f) == std::string(reinterpret_cast<const char*>(expected), sizeof expected));
}

TEST_CASE("an image without its description, or of another frame, is left out", "[depth]") {
  hal::DepthFrame f = frame_of(4, 3), other = f;
  other.exposed_at += std::chrono::milliseconds(33);
  FrameJoiner joiner;
  CHECK_FALSE(joiner.add("/camera/depth", depth_image(f)));
  CHECK_FALSE(joiner.add("/camera/frame", frame_message(1, f)));
  const auto wrong = joiner.add("/camera/depth", depth_image(other));
  REQUIRE(wrong);
  CHECK_FALSE(decode_frame(*wrong));
  CHECK_FALSE(joiner.add("/camera/depth", depth_image(f)));  // a description is for one image
  CHECK_FALSE(joiner.add("/camera/frame", "{"));
  CHECK_FALSE(joiner.add("/camera/depth", depth_image(f)));
}

TEST_CASE("an image cut anywhere is refused, and a damaged one survived", "[depth]") {
  hal::DepthFrame f = frame_of(16, 4);
  for (std::size_t i = 0; i < f.depth_m.size(); ++i)
    f.depth_m[i] = static_cast<float>((500.0 + static_cast<double>(i % 7)) / 1000.0);
  const std::string bytes = depth_image(f);
  for (std::size_t cut = 0; cut < bytes.size(); ++cut)
    REQUIRE_FALSE(parse_image(std::string_view(bytes).substr(0, cut)));
  std::mt19937 random(7);
  for (int i = 0; i < 20000; ++i) {
    std::string bad = bytes;
    bad[random() % bad.size()] = static_cast<char>(random());
    if (const auto image = parse_image(bad)) (void)depth_of(*image);
  }
}

TEST_CASE("a recording in the old form is still replayed", "[depth]") {
  // three cycles with a frame each, written by the encoder that is gone: table, floats, and one with colour
  const std::string path = COLIFT_TEST_DATA "/recordings/cdt1.mcap";
  auto bytes = open_file(path);
  REQUIRE(bytes);
  const auto file = McapReader::open(std::move(*bytes), path);
  REQUIRE(file);
  Tape tape(*file);
  for (std::uint64_t n = 0; n < 3; ++n) {
    REQUIRE(tape.advance());
    const auto frame = tape.next_camera();
    REQUIRE(frame);
    const bool floats = n == 1;
    std::vector<float> depth_m(floats ? 96 * 64 : 64 * 48);
    for (std::size_t i = 0; i < depth_m.size(); ++i)
      depth_m[i] = i % 11 == 0 ? kNone
                   : floats
                       ? 0.5f + 0.0001234f * static_cast<float>(i)
                       : static_cast<float>(static_cast<double>(500 + (37 * i + 1000 * n) % 3000) / 1000.0);
    CHECK(same_depth(frame->depth_m, depth_m));
    CHECK(frame->intrinsics.width == (floats ? 96 : 64));
    CHECK(frame->exposed_at == hal::Timestamp(1'000'000'007LL * static_cast<std::int64_t>(n + 1)));
    CHECK(frame->up_C.has_value() == (n != 2));
    CHECK(frame->rgb.size() == (n == 2 ? 3 * depth_m.size() : 0));
  }
  CHECK_FALSE(tape.advance());
  CHECK(tape.notes().empty());
}

TEST_CASE("a frame in the old form, damaged anywhere, is survived", "[depth]") {
  std::string bytes(118, '\0');
  std::mt19937 random(8);
  for (int i = 0; i < 2000; ++i) {
    for (char& c : bytes) c = static_cast<char>(random() % 9);
    bytes.replace(0, 4, "CDT1");
    (void)decode_cdt1(bytes);
  }
}

TEST_CASE("every depth of a Kinect finds a code that has this depth", "[depth]") {
  const auto& table = sim_hal::kinect_depths_m();
  int checked = 0;
  for (int raw = 400; raw < sim_hal::kKinectCodes; ++raw) {
    const float depth = table[static_cast<std::size_t>(raw) + 1];
    const std::uint16_t code = kinect_code(depth);
    if (code == 2047) continue;
    REQUIRE(code < sim_hal::kKinectCodes);
    CHECK(table[static_cast<std::size_t>(code) + 1] == depth);
    ++checked;
  }
  CHECK(checked > 600);
  CHECK(kinect_code(std::nanf("")) == 2047);
  CHECK(kinect_code(0.0f) == 2047);
}
