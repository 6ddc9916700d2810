#include <fmt/format.h>

#include <catch2/catch.hpp>

#include "hal/drivers/recorded/camera_file.hpp"
#include "writers.hpp"

using namespace colift::hal;
using namespace colift::hal::test;

namespace {

std::string refusal(const std::string& text) {
  const auto out = parse_camera_json(bytes_of(text), "camera.json");
  REQUIRE_FALSE(out);
  CHECK(out.error().code == ErrorCode::BadInput);
  return out.error().text();
}

}  // namespace

TEST_CASE("the camera files of all recordings are read, each with its own scale", "[camera_json]") {
  struct Expected {
    const char* folder;
    double fx, cy, scale_m;
  };
  for (const Expected& e : {Expected{"01_office_chair_and_bottles", 525.0, 240.0, 0.001},
                            Expected{"03_desk_and_two_chairs", 535.4, 247.6, 0.001},
                            Expected{"05_can_on_table", 616.365, 236.6, 0.0001}}) {
    const auto bytes = load_file(data("real") / e.folder / "camera.json");
    REQUIRE(bytes);
    const auto camera = parse_camera_json(*bytes, e.folder);
    REQUIRE(camera);
    CHECK(camera->fx == e.fx);
    CHECK(camera->cy == e.cy);
    CHECK(camera->depth_scale_m == e.scale_m);
    CHECK(camera->width == 640);
    CHECK(camera->height == 480);
  }
}

TEST_CASE("width and height of a camera file are optional", "[camera_json]") {
  const auto camera = parse_camera_json(
      bytes_of(R"({"fx":500,"fy":501,"cx":320,"cy":240,"depth_scale_m":0.001,"maker":null})"), "camera.json");
  REQUIRE(camera);
  CHECK_FALSE(camera->width);
  CHECK(camera->intrinsics(640, 480).fy == 501.0);
}

TEST_CASE("a wrong camera file is refused with the place and what was expected", "[camera_json]") {
  const auto with = [](const std::string& key, const std::string& value) {
    std::string text = "{";
    for (const auto& [name, good] :
         {std::pair{"fx", "500"}, {"fy", "500"}, {"cx", "320"}, {"cy", "240"}, {"depth_scale_m", "0.001"}}) {
      if (name == key && value.empty()) continue;
      text += fmt::format("\"{}\": {}, ", name, name == key ? value : good);
    }
    return text + "\"end\": 0}";
  };
  CHECK(refusal(with("fx", "")) ==
        "camera.json: fx: fx is missing; expected a number from 1 to 100000 (pixels)");
  CHECK(refusal(with("fy", "-500")) ==
        "camera.json: fy: fy is -500; expected a number from 1 to 100000 (pixels)");
  CHECK(refusal(with("cx", "\"wide\"")) ==
        "camera.json: cx: cx is '\"wide\"'; expected a number from 0.001 to 8192 (pixels)");
  CHECK(refusal(with("cy", "[240]")) ==
        "camera.json: cy: cy is an array; expected a number from 0.001 to 8192 (pixels)");
  CHECK(refusal(with("depth_scale_m", "0")) ==
        "camera.json: depth_scale_m: depth_scale_m is 0; expected a number from 1e-07 to 0.1 (metres per "
        "unit)");
  CHECK(refusal(with("depth_scale_m", "1000")).find("metres per unit") != std::string::npos);
  CHECK(refusal(with("fx", "NaN")) ==
        "camera.json:1:8: not valid JSON at 'NaN, \"fy\": 500, \"cx\": 320, \"cy\": 240, \"d...'");
  CHECK(refusal(with("fx", "1e999")).find("camera.json") == 0);
  CHECK(refusal("[1, 2]") ==
        "camera.json:1:1: found JSON of type array; expected an object with fx, fy, cx, cy, depth_scale_m");
  CHECK(refusal("{\n \"fx\": 1,\n \"fy\" 2\n}") == "camera.json:3:7: not valid JSON at '2'");
  CHECK(refusal("{\"fx\": 1,") == "camera.json:1:10: the JSON text ends too early");
  CHECK(refusal("").find("ends too early") != std::string::npos);
}

TEST_CASE("a centre outside the stated image is refused", "[camera_json]") {
  CHECK(refusal(R"({"fx":500,"fy":500,"cx":320,"cy":240,"depth_scale_m":0.001,"width":320,"height":480})") ==
        "camera.json: width: the image's centre 320 lies outside its width of 320 pixels");
  CHECK(refusal(R"({"fx":500,"fy":500,"cx":320,"cy":240,"depth_scale_m":0.001,"width":640.5})") ==
        "camera.json: width: width is 640.5; expected a whole number of pixels");
}

TEST_CASE("JSON nested a hundred thousand deep does not overflow the stack", "[camera_json]") {
  const std::string deep = std::string(100000, '[') + std::string(100000, ']');
  CHECK(refusal(R"({"fx":)" + deep + "}") ==
        "camera.json: fx: fx is an array; expected a number from 1 to 100000 (pixels)");
  CHECK(refusal(std::string(100000, '[')).find("ends too early") != std::string::npos);
}
