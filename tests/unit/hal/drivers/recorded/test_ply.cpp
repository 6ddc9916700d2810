#include <catch2/catch.hpp>
#include <random>

#include "hal/drivers/recorded/cloud_files/ply.hpp"
#include "writers.hpp"

using namespace colift::hal;
using namespace colift::hal::test;

namespace {

std::string refusal(const std::string& text) {
  const auto out = parse_ply(bytes_of(text), "a.ply");
  REQUIRE_FALSE(out);
  CHECK(out.error().code == ErrorCode::BadInput);
  return out.error().text();
}

}  // namespace

TEST_CASE("every PLY encoding gives back the points between lists and other elements", "[ply]") {
  for (std::uint32_t seed = 0; seed < 20; ++seed) {
    const PointFile points = random_points(seed, 1 + static_cast<int>(seed * 53 % 97), 1, seed % 2 == 0);
    for (const PlyData data : {PlyData::Ascii, PlyData::Little, PlyData::Big}) {
      CAPTURE(seed, static_cast<int>(data));
      const auto back = parse_ply(bytes_of(ply(points, data)), "a.ply");
      REQUIRE(back);
      CHECK(back->height == 1);
      CHECK(same(back->x, points.x));
      CHECK(same(back->y, points.y));
      CHECK(same(back->z, points.z));
      CHECK(back->rgb == points.rgb);
    }
  }
}

TEST_CASE("a PLY that states its columns and rows is organised", "[ply]") {
  const std::string head = "ply\nformat ascii 1.0\nobj_info num_cols 2\nobj_info num_rows 3\nelement vertex ";
  const std::string properties = "\nproperty double x\nproperty double y\nproperty double z\nend_header\n";
  const auto whole =
      parse_ply(bytes_of(head + "6" + properties + "1 1 1\n2 2 2\n3 3 3\n4 4 4\n5 5 5\n6 6 6\n"), "a.ply");
  REQUIRE(whole);
  CHECK(whole->width == 2);
  CHECK(whole->height == 3);
  // a range image that leaves out its holes has no order any more
  const auto sparse = parse_ply(bytes_of(head + "2" + properties + "1 1 1\n2 2 2\n"), "a.ply");
  REQUIRE(sparse);
  CHECK(sparse->height == 1);
}

TEST_CASE("the camera element of a PLY is its viewpoint and size", "[ply]") {
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float "
      "z\nelement camera 1\n";
  for (const char* name : {"view_px", "view_py", "view_pz", "x_axisx", "x_axisy", "x_axisz", "y_axisx",
                           "y_axisy", "y_axisz", "z_axisx", "z_axisy", "z_axisz"}) {
    text += std::string("property float ") + name + "\n";
  }
  text += "property int viewportx\nproperty int viewporty\nend_header\n1 1 1\n2 2 2\n3 3 3\n4 4 4\n";
  text += "1 2 3 0 1 0 -1 0 0 0 0 1 2 2\n";
  const auto out = parse_ply(bytes_of(text), "a.ply");
  REQUIRE(out);
  CHECK(out->width == 2);
  CHECK(out->height == 2);
  CHECK((out->viewpoint.translation() - Vec3(1, 2, 3)).norm() < 1e-12);
  CHECK((out->viewpoint.linear() * Vec3::UnitX() - Vec3::UnitY()).norm() < 1e-12);
}

TEST_CASE("colours of other types become bytes", "[ply]") {
  const auto out = parse_ply(
      bytes_of(
          "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float "
          "z\nproperty float red\nproperty float green\nproperty float blue\nend_header\n0 0 1 0.5 2 -1\n"),
      "a.ply");
  REQUIRE(out);
  CHECK(out->rgb == std::vector<std::uint8_t>{128, 255, 0});
}

TEST_CASE("a wrong PLY is refused with the line or byte and the reason", "[ply]") {
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  CHECK(refusal("solid cube\n") == "a.ply:1: found 'solid cube'; a PLY file begins with ply");
  CHECK(refusal("ply\nformat binary 1.0\n") ==
        "a.ply:2: format is 'binary'; expected ascii, binary_little_endian or binary_big_endian");
  CHECK(refusal("ply\nformat ascii 2.0\n") == "a.ply:2: format version is '2.0'; expected 1.0");
  CHECK(refusal("ply\nformat ascii 1.0\nelement vertex many\n") ==
        "a.ply:3: element 'vertex' has count 'many'; expected a name and a whole number");
  CHECK(refusal("ply\nformat ascii 1.0\nproperty float x\n") ==
        "a.ply:3: found a property before the first element");
  CHECK(refusal("ply\nelement vertex 1\n" + xyz + "end_header\n1 1 1\n") ==
        "a.ply:6: the header ends without a line format");
  CHECK(
      refusal(
          "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n1 1\n") ==
      "a.ply: header: element vertex has no property z; expected x, y and z");
  CHECK(refusal("ply\nformat ascii 1.0\nelement vertex 2\n" + xyz + "end_header\n1 1 1\n1 x 1\n") ==
        "a.ply:9: found 'x' in vertex 1; expected a number");
  CHECK(refusal("ply\nformat ascii 1.0\nelement vertex 1\nproperty list float int x\n") ==
        "a.ply:4: the length of a list has type 'float'; expected a whole number's type");
  CHECK(refusal("ply\nformat binary_little_endian 1.0\nelement junk 4000000000000000000\nproperty double "
                "a\nelement vertex 1\n" +
                xyz + "end_header\nxxxxxxxxxxxxxxxxxxx") ==
        "a.ply: byte 166: the file ends after 2 of 4000000000000000000 entries of element 'junk'");
}

TEST_CASE("a PLY cut at any place is refused, or whole but for what nobody reads", "[ply]") {
  const PointFile points = random_points(1, 300, 1, true);
  for (const PlyData data : {PlyData::Ascii, PlyData::Little, PlyData::Big}) {
    const std::string whole = ply(points, data);
    for (std::size_t cut = 0; cut + 8 < whole.size(); cut += 97) {
      CHECK_FALSE(parse_ply(bytes_of(whole.substr(0, cut)), "cut.ply"));
    }
  }
}

TEST_CASE("a PLY with any byte changed does not break the parser", "[ply]") {
  const PointFile points = random_points(2, 100, 1, true);
  std::mt19937 random(5);
  for (const PlyData data : {PlyData::Ascii, PlyData::Little, PlyData::Big}) {
    const std::string whole = ply(points, data);
    for (int round = 0; round < 300; ++round) {
      std::string damaged = whole;
      damaged[random() % damaged.size()] = static_cast<char>(random());
      const auto out = parse_ply(bytes_of(damaged), "damaged.ply");
      CHECK((!out || out->size() <= 10 * points.size()));
    }
  }
}
