#include <catch2/catch.hpp>
#include <filesystem>
#include <set>

#include "hal/drivers/recorded/frame_file.hpp"
#include "writers.hpp"

using namespace colift::hal;
using namespace colift::hal::test;

namespace {

struct Case {
  const char* file;
  const char* where;   // behind the folder
  const char* detail;  // part of the sentence
};

constexpr Case kCases[] = {
    {"bad_number.pcd", "bad_number.pcd:16", "found 'one' where field z needs a number"},
    {"bad_number.ply", "bad_number.ply:22", "found 'one' in vertex 4; expected a number"},
    {"bad_type.ply", "bad_type.ply:9", "property type 'half' is not one of PLY's"},
    {"beyond_limits.png", "beyond_limits.png: header",
     "100000 x 100000 pixels; expected 1 x 1 to 8192 x 8192"},
    {"colour16.png", "colour16.png: header", "16-bit colour; a depth image is 16-bit grey"},
    {"damaged.png", "damaged.png: byte 161", "the PNG image is damaged"},
    {"damaged_compressed.pcd", "damaged_compressed.pcd: byte 197", "compressed data are damaged"},
    {"empty.pcd", "empty.pcd", "the file is empty (0 bytes)"},
    {"empty.ply", "empty.ply", "the file is empty (0 bytes)"},
    {"empty.png", "empty.png", "the file is empty (0 bytes)"},
    {"grey8.png", "grey8.png: header", "8-bit grey; a depth image is 16-bit grey"},
    {"huge_compressed.pcd", "huge_compressed.pcd: byte 201",
     "3168 compressed bytes cannot expand to 4294705152"},
    {"huge_count.pcd", "huge_count.pcd: header COUNT", "'99999999999999999999'; expected 1 to 1048576"},
    {"huge_header.png", "huge_header.png: header", "8000 x 8000 pixels, more than 177 bytes can hold"},
    {"huge_list.ply", "huge_list.ply: byte 299", "ends after 0 of 2 entries of element 'edge'"},
    {"huge_points.pcd", "huge_points.pcd: header POINTS",
     "POINTS is 1000000000000, more than any file holds"},
    {"huge_points_ascii.pcd", "huge_points_ascii.pcd: header POINTS",
     "POINTS is 2000000000 with 4 values each"},
    {"huge_vertices.ply", "huge_vertices.ply: header",
     "element vertex is 1000000000000, more than the 2893 bytes"},
    {"millimetres.pcd", "millimetres.pcd", "perhaps it is in millimetres"},
    {"nan_only.pcd", "nan_only.pcd", "no finite point: all 192 points are NaN"},
    {"nan_only.ply", "nan_only.ply", "no finite point: all 192 points are NaN"},
    {"no_vertex.ply", "no_vertex.ply: header", "no element vertex"},
    {"no_z.pcd", "no_z.pcd: header FIELDS", "has no field z; expected x, y and z"},
    {"pcd_renamed.ply", "pcd_renamed.ply: byte 0", "this is a PCD point cloud, but its name ends in .ply"},
    {"pcd_renamed.png", "pcd_renamed.png: byte 0", "this is a PCD point cloud, but its name ends in .png"},
    {"png_renamed.pcd", "png_renamed.pcd: byte 0", "this is a PNG image, but its name ends in .pcd"},
    {"points_mismatch.pcd", "points_mismatch.pcd: header POINTS",
     "POINTS is 100, but WIDTH 16 x HEIGHT 12 is 192"},
    {"signature_only.png", "signature_only.png: byte 8", "the file ends too early"},
    {"text.pcd", "text.pcd: byte 0", "begins with 'Dear reader,\\x0athi'; expected a PCD point cloud"},
    {"text.ply", "text.ply: byte 0", "begins with 'ply me with wine'; expected a PLY file"},
    {"text.txt", "text.txt: byte 0", "expected a 16-bit depth PNG, a PCD or a PLY file"},
    {"truncated.png", "truncated.png: byte 41", "the file ends too early"},
    {"truncated_ascii.pcd", "truncated_ascii.pcd: header POINTS",
     "the file is cut off or the header is wrong"},
    {"truncated_ascii.ply", "truncated_ascii.ply: header", "the file is cut off or the header is wrong"},
    {"truncated_big.ply", "truncated_big.ply: byte 294", "ends after 0 of 2 entries of element 'edge'"},
    {"truncated_binary.pcd", "truncated_binary.pcd: byte 1179", "expected 192 points of 16 bytes = 3072"},
    {"truncated_compressed.pcd", "truncated_compressed.pcd: byte 889",
     "692 bytes of compressed data follow; expected 3168"},
    {"truncated_header.pcd", "truncated_header.pcd:5", "the file ends inside the header: no line DATA"},
    {"truncated_header.ply", "truncated_header.ply:5", "a property has no name"},
    {"truncated_little.ply", "truncated_little.ply: header", "the file is cut off or the header is wrong"},
    {"zero_only.pcd", "zero_only.pcd", "no finite point: all 192 points are NaN or (0, 0, 0)"},
    {"zero_only.png", "zero_only.png", "no finite point: all 192 pixels are 0"},
    {"zero_size.pcd", "zero_size.pcd: header WIDTH", "WIDTH is 0: the file holds no points"},
    {"zero_size.ply", "zero_size.ply: header", "element vertex is 0: the file holds no points"},
    {"zero_size.png", "zero_size.png: header", "the header says 0 x 0 pixels"},
};

constexpr Case kCameras[] = {
    {"camera_array.json", "camera_array.json:1:1", "found JSON of type array"},
    {"camera_infinite.json", "camera_infinite.json", "not "},
    {"camera_missing.json", "camera_missing.json: cy", "cy is missing; expected a number"},
    {"camera_nan.json", "camera_nan.json:1:8", "not valid JSON at"},
    {"camera_negative.json", "camera_negative.json: fy", "fy is -20; expected a number from 1"},
    {"camera_other_size.json", "depth.png: header", "16 x 12 pixels, but "},
    {"camera_string.json", "camera_string.json: cx", "cx is '\"7.5\"'; expected a number"},
    {"camera_syntax.json", "camera_syntax.json:3:7", "not valid JSON at '20'"},
    {"camera_truncated.json", "camera_truncated.json:1:31", "the JSON text ends too early"},
    {"camera_units_per_metre.json", "camera_units_per_metre.json: depth_scale_m",
     "is 1000; expected a number from 1e-07 to 0.1"},
    {"camera_zero.json", "camera_zero.json: depth_scale_m", "depth_scale_m is 0; expected a number"},
    {"empty_camera.json", "empty_camera.json", "the file is empty (0 bytes)"},
};

void check(const Result<RecordedFrame>& read, const Case& expected) {
  REQUIRE_FALSE(read);
  CAPTURE(read.error().text());
  CHECK(read.error().code == ErrorCode::BadInput);
  CHECK(read.error().where.find(std::string("/") + expected.where) != std::string::npos);
  CHECK(read.error().detail.find(expected.detail) != std::string::npos);
  CHECK(read.error().detail.find('\n') == std::string::npos);
}

}  // namespace

TEST_CASE("every bad recording is refused in one sentence with its place", "[bad_input]") {
  for (const Case& expected : kCases) {
    CAPTURE(expected.file);
    check(read_frame(data("bad") / expected.file), expected);
  }
}

TEST_CASE("every bad camera file is refused in one sentence with its place", "[bad_input]") {
  const TemporaryFolder folder;
  const auto image =
      folder.write("depth.png", png(16, 12, 16, false, false, std::vector<std::uint16_t>(192, 1000)));
  for (const Case& expected : kCameras) {
    CAPTURE(expected.file);
    check(read_frame(image, data("bad") / expected.file), expected);
  }
}

TEST_CASE("no bad file is without a test", "[bad_input]") {
  std::set<std::string> named = {"camera.json"};
  for (const Case& c : kCases) named.insert(c.file);
  for (const Case& c : kCameras) named.insert(c.file);
  for (const auto& entry : std::filesystem::directory_iterator(data("bad"))) {
    const std::string extension = entry.path().extension().string();
    if (extension == ".pcd" || extension == ".ply" || extension == ".png" || extension == ".json" ||
        extension == ".txt") {
      CAPTURE(entry.path());
      CHECK(named.count(entry.path().filename().string()) == 1);
    }
  }
}

TEST_CASE("what is no file is refused in words", "[bad_input]") {
  const TemporaryFolder folder;
  CHECK(read_frame(folder.path() / "none.pcd").error().detail == "there is no such file");
  CHECK(read_frame(folder.path()).error().detail == "this is a directory; expected a file");
  CHECK(read_frame("/dev/null").error().detail == "this is not a regular file");
}

TEST_CASE("a real recording cut at any place does not break the reader", "[bad_input][real]") {
  const auto bytes = load_file(data("real/02_laptop_and_box/depth_0.png"));
  REQUIRE(bytes);
  const TemporaryFolder folder;
  folder.write("camera.json", R"({"fx":525,"fy":525,"cx":320,"cy":240,"depth_scale_m":0.001})");
  for (std::size_t cut = 1; cut < bytes->size(); cut += 97 * 20) {
    CHECK_FALSE(read_frame(folder.write("cut.png", std::string(as_text(*bytes).substr(0, cut)))));
  }
}
