// What `colift hal camera` says of a Kinect in JSON.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tools/bring_up/hal_camera_view.hpp"

namespace colift {

TEST_CASE("a camera from which no frame came yet reports no rate and no depth", "[hal][camera]") {
  tools::CameraView view;
  const auto before = nlohmann::json::parse(tools::camera_document("info", view, "failed", "no device"));
  CHECK(before["frames"]["handed_out"] == 0);
  for (const auto& value : {before["frames"]["rate_hz"], before["frames"]["late_ms"], before["seen"]})
    CHECK(value.is_null());
  for (const auto& depth : before["depth_m"]) CHECK(depth.is_null());

  view.report.frames = 3;
  view.report.rate_hz = 30.0;
  view.near_m = 0.8, view.middle_m = 1.5, view.far_m = 3.0;
  const auto after = nlohmann::json::parse(tools::camera_document("info", view, "done", ""));
  CHECK(after["frames"]["rate_hz"] == 30.0);
  CHECK(after["depth_m"] == nlohmann::json({0.8, 1.5, 3.0}));
}

}  // namespace colift
