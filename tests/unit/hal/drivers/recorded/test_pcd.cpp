#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "hal/drivers/recorded/cloud_files/pcd.hpp"
#include "writers.hpp"

using namespace colift::hal;
using namespace colift::hal::test;

namespace {

PointFile parsed(const std::string& text) {
  auto out = parse_pcd(bytes_of(text), "a.pcd");
  INFO((out ? std::string("parsed") : out.error().text()));
  REQUIRE(out);
  return *out;
}

std::string refusal(const std::string& text) {
  const auto out = parse_pcd(bytes_of(text), "a.pcd");
  REQUIRE_FALSE(out);
  CHECK(out.error().code == ErrorCode::BadInput);
  return out.error().text();
}

}  // namespace

TEST_CASE("every PCD encoding gives back the points that were written", "[pcd]") {
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    const int width = 1 + static_cast<int>(seed * 37 % 61), height = 1 + static_cast<int>(seed % 5);
    const PointFile points = random_points(seed, width, height, seed % 2 == 0);
    for (const PcdData data : {PcdData::Ascii, PcdData::Binary, PcdData::Compressed}) {
      CAPTURE(seed, static_cast<int>(data));
      const PointFile back = parsed(pcd(points, data));
      CHECK(back.width == width);
      CHECK(back.height == height);
      CHECK(same(back.x, points.x));
      CHECK(same(back.y, points.y));
      CHECK(same(back.z, points.z));
      CHECK(back.rgb == points.rgb);
    }
  }
}

TEST_CASE("fields may stand in any order, between others, and have any numeric type", "[pcd]") {
  std::mt19937 random(7);
  for (int round = 0; round < 40; ++round) {
    PointFile points = random_points(random(), 23, 1, true);
    // whole numbers, so that every type can hold them
    for (auto* column : {&points.x, &points.y, &points.z}) {
      for (float& value : *column) value = std::isfinite(value) ? std::round(40.0f * value) : 0.0f;
    }
    const auto type = [&]() -> std::pair<char, int> {
      const std::pair<char, int> kinds[] = {{'F', 4}, {'F', 8}, {'I', 1}, {'I', 2}, {'I', 4}, {'I', 8}};
      return kinds[random() % 6];
    };
    std::vector<Column> columns;
    for (const char* name : {"x", "y", "z", "_", "normal_x", "fpfh"}) {
      const auto [letter, size] = type();
      columns.push_back({name, letter, size, name == std::string("fpfh") ? 33 : 1});
    }
    columns.push_back({round % 2 == 0 ? "rgb" : "rgba", round % 4 < 2 ? 'U' : 'F', 4, 1});
    std::shuffle(columns.begin(), columns.end(), random);
    for (const PcdData data : {PcdData::Ascii, PcdData::Binary, PcdData::Compressed}) {
      CAPTURE(round, static_cast<int>(data));
      const PointFile back = parsed(pcd(points, data, columns));
      CHECK(back.x == points.x);
      CHECK(back.y == points.y);
      CHECK(back.z == points.z);
      CHECK(back.rgb == points.rgb);
    }
  }
}

TEST_CASE("unsigned fields are not taken for signed ones", "[pcd]") {
  std::string text = "VERSION .7\nFIELDS x y z\nSIZE 1 2 4\nTYPE U U U\nWIDTH 1\nHEIGHT 1\nDATA binary\n";
  text += std::string("\xff\xff\xff\xff\xff\xff\xff", 7);
  const PointFile back = parsed(text);
  CHECK(back.x[0] == 255.0f);
  CHECK(back.y[0] == 65535.0f);
  CHECK(back.z[0] == 4294967296.0f);
}

TEST_CASE("a compressed PCD whose stream refers before its beginning is refused", "[pcd]") {
  const std::string head = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 1\nDATA binary_compressed\n";
  const std::string sizes("\x05\x00\x00\x00\x0c\x00\x00\x00", 8);
  // a literal, then eleven bytes copied from one back, or from six back
  CHECK(parsed(head + sizes + std::string("\x00\x41\xe0\x02\x00", 5)).size() == 1);
  CHECK(refusal(head + sizes + std::string("\x00\x41\xe0\x02\x05", 5)).find("damaged") != std::string::npos);
}

TEST_CASE("a header of an old version with carriage returns and without the optional lines is read",
          "[pcd]") {
  const PointFile points = parsed(
      "# written on another system\r\n\r\nVERSION .5\r\nFIELDS z x y\r\nSIZE 4 4 4\r\nTYPE F F F\r\nPOINTS "
      "2\r\nDATA ascii\r\n1 2 3\r\n+4 -5 6e-1\r\n");
  CHECK(points.width == 2);
  CHECK(points.height == 1);
  CHECK(points.x == std::vector<float>{2.0f, -5.0f});
  CHECK(points.z == std::vector<float>{1.0f, 4.0f});
  CHECK(points.y[1] == Approx(0.6));
}

TEST_CASE("nan and inf are holes in a cloud, not errors", "[pcd]") {
  const PointFile points = parsed(
      "VERSION 0.7\nFIELDS x y z\nWIDTH 3\nHEIGHT 1\nDATA ascii\nnan nan nan\n-inf inf -nan\n1e300 0 1");
  CHECK_FALSE(points.seen(0));
  CHECK_FALSE(points.seen(1));
  CHECK_FALSE(points.seen(2));  // beyond a float
}

TEST_CASE("the viewpoint is the sensor's pose", "[pcd]") {
  const PointFile points =
      parsed("VERSION 0.7\nFIELDS x y z\nWIDTH 1\nHEIGHT 1\nVIEWPOINT 1 2 3 0 0 0 2\nDATA ascii\n1 1 1\n");
  CHECK((points.viewpoint.translation() - Vec3(1, 2, 3)).norm() < 1e-12);
  CHECK((points.viewpoint.linear() * Vec3::UnitX() + Vec3::UnitX()).norm() < 1e-12);
}

TEST_CASE("a wrong PCD header is refused with the line or the key and the numbers", "[pcd]") {
  const std::string head = "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n";
  CHECK(refusal(head + "WIDTH 2\nHEIGHT 2\nPOINTS 5\nDATA ascii\n1 1 1\n") ==
        "a.pcd: header POINTS: POINTS is 5, but WIDTH 2 x HEIGHT 2 is 4");
  CHECK(refusal(head + "WIDTH two\nDATA ascii\n1 1 1\n") ==
        "a.pcd: header WIDTH: WIDTH is 'two'; expected a whole number");
  CHECK(refusal(head + "WIDTH -2\nDATA ascii\n1 1 1\n") ==
        "a.pcd: header WIDTH: WIDTH is '-2'; expected a whole number");
  CHECK(refusal(head + "DATA ascii\n1 1 1\n") == "a.pcd: header POINTS: POINTS is missing, and WIDTH too");
  CHECK(refusal(head + "WIDTH 1\nDATA base64\nAAAA\n") ==
        "a.pcd:6: DATA is 'base64'; expected ascii, binary or binary_compressed");
  CHECK(refusal(head + "WIDTH 1\nWIDTH 1\nDATA ascii\n1 1 1\n") ==
        "a.pcd:6: WIDTH is given a second time, first in line 5");
  CHECK(refusal(head + "COLOUR blue\nDATA ascii\n") ==
        "a.pcd:5: found 'COLOUR blue' where a PCD header line (VERSION, FIELDS, ..., DATA) was expected");
  CHECK(refusal(head + "VIEWPOINT 0 0 0\nPOINTS 1\nDATA ascii\n1 1 1\n") ==
        "a.pcd: header VIEWPOINT: VIEWPOINT has 3 numbers; expected 7 (x y z qw qx qy qz)");
  CHECK(refusal("VERSION 0.9\nFIELDS x y z\nPOINTS 1\nDATA ascii\n1 1 1\n") ==
        "a.pcd: header VERSION: VERSION is '0.9'; expected .5, .6 or .7");
  CHECK(refusal("FIELDS x y z\nSIZE 4 4\nPOINTS 1\nDATA ascii\n1 1 1\n") ==
        "a.pcd: header SIZE: SIZE has 2 entries; expected 3 as in FIELDS");
  CHECK(refusal("FIELDS x y z\nSIZE 3 4 4\nTYPE F F F\nPOINTS 1\nDATA ascii\n1 1 1\n") ==
        "a.pcd: header SIZE: SIZE of field x is 1 x 3 bytes of type F; expected one number");
  CHECK(refusal("FIELDS x y x z\nPOINTS 1\nDATA ascii\n1 1 1 1\n") ==
        "a.pcd: header FIELDS: FIELDS names x twice");
}

TEST_CASE("wrong lines of an ascii PCD are named by their number", "[pcd]") {
  const std::string head = "FIELDS x y z\nPOINTS 3\nDATA ascii\n";
  CHECK(refusal(head + "1 1 1\n1 1\n1 1 1\n1 1 1\n") == "a.pcd:5: has 2 values; expected 3");
  CHECK(refusal(head + "1 1 1\n1 1 1 1\n1 1 1\n") == "a.pcd:5: has too many values; expected 3");
  CHECK(refusal(head + "1 1 1\n1 1e 1\n1 1 1\n") == "a.pcd:5: found '1e' where field y needs a number");
  CHECK(refusal(head + "1 1 1.0000000\n1 1 1.0000000\n") == "a.pcd:5: the file ends after 2 of 3 points");
}

TEST_CASE("sizes whose products overflow 64 bits are refused without allocating", "[pcd]") {
  const std::string points = "POINTS 2147483647\n";
  CHECK(refusal("FIELDS x y z a\nSIZE 4 4 4 1048576\nTYPE F F F F\nCOUNT 1 1 1 1048576\n" + points +
                "DATA binary\nxxxx")
            .find("header SIZE") != std::string::npos);
  CHECK(refusal("FIELDS x y z\nSIZE 8 8 8\nTYPE F F F\n" + points + "DATA binary\nxxxx") ==
        "a.pcd: byte 69: 4 bytes follow the header; expected 2147483647 points of 24 bytes = 51539607528");
  CHECK(refusal("FIELDS x y z\n" + points + "DATA ascii\n1 1 1\n").find("can hold") != std::string::npos);
  CHECK(refusal("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\n" + points +
                "DATA binary_compressed\n\x01\x01\x01\x01\x01\x01\x01\x01xxxx")
            .find("16843009 points") == std::string::npos);
}

TEST_CASE("a PCD cut at any place is refused or read, never more than it holds", "[pcd]") {
  const PointFile points = random_points(1, 64, 8, true);
  for (const PcdData data : {PcdData::Ascii, PcdData::Binary, PcdData::Compressed}) {
    const std::string whole = pcd(points, data);
    for (std::size_t cut = 0; cut + 2 < whole.size(); cut += 97) {
      CHECK_FALSE(parse_pcd(bytes_of(whole.substr(0, cut)), "cut.pcd"));
    }
  }
}

TEST_CASE("a PCD with any byte changed does not break the parser", "[pcd]") {
  const PointFile points = random_points(2, 32, 4, true);
  std::mt19937 random(5);
  for (const PcdData data : {PcdData::Ascii, PcdData::Binary, PcdData::Compressed}) {
    const std::string whole = pcd(points, data);
    for (int round = 0; round < 300; ++round) {
      std::string damaged = whole;
      damaged[random() % damaged.size()] = static_cast<char>(random());
      const auto out = parse_pcd(bytes_of(damaged), "damaged.pcd");
      CHECK((!out || out->size() <= 4 * points.size()));
    }
  }
}
