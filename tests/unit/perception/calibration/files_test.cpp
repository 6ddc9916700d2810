#include <fmt/format.h>
#include <catch2/catch.hpp>

#include "perception/calibration/calibration_file.hpp"
#include "perception/calibration/pose_check.hpp"
#include "perception/calibration/sample_folder.hpp"
#include "sim_hal/synthetic/kinect/kinect_noise.hpp"
#include "tests/support/calibration_trial.hpp"
#include "tests/unit/perception/self_filter/robot_view.hpp"

using namespace colift;

namespace {

std::string sample(const std::string& rest) {
  return "schema: colift.calibration_samples/1\nsamples:\n  - " + rest + "\n";
}
std::string why_not(const std::string& yaml) {
  const auto file = perception::parse_samples(yaml, "s.yaml", hal::built_in_robot());
  return file ? "" : file.error().text();
}

}  // namespace

TEST_CASE("a calibration comes back from its file as it went in") {
  const auto t = tests::make_trial({}, 2);
  const auto c = perception::calibrate(t.samples, t.camera, {}, 2);
  REQUIRE(c);
  const auto text = perception::text_of(perception::file_of(*c, "2026-01-02", "a test"));
  const auto back = perception::parse_calibration(text, "c.yaml");
  if (!back) FAIL(back.error().text() << "\n" << text);
  CHECK((back->X_BC().matrix() - c->model.X_BC().matrix()).cwiseAbs().maxCoeff() < 1e-12);
  CHECK(back->date == "2026-01-02");
  CHECK(back->covariance.size() == 81);
  CHECK(back->poses.size() == t.samples.size());
  CHECK(text.find("default") == std::string::npos);
}

TEST_CASE("a calibration file that is not good enough, or none, is refused at its place") {
  const std::string good =
      "schema: colift.calibration/1\ncamera_xyz_m: [2, 0, 1]\ncamera_quaternion: [0, 0, 0, 1]\n"
      "error_m: 0.002\nrms_px: 0.4\ninliers: 20\n";
  REQUIRE(perception::parse_calibration(good, "c.yaml"));
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string yaml = good;
    yaml.replace(yaml.find(from), from.size(), to);
    const auto file = perception::parse_calibration(yaml, "c.yaml");
    REQUIRE_FALSE(file);
    CHECK(file.error().code == hal::ErrorCode::BadConfig);
    return file.error().text();
  };
  CHECK(changed("0.002", "0.009").find("c.yaml:4:10: points are placed 9.0 mm off") == 0);
  CHECK(changed("[0, 0, 0, 1]", "[0, 0, 0, 2]").find("c.yaml:3:") == 0);
  CHECK(changed("[0, 0, 0, 1]", "[0, 0, 1]").find("found 3 numbers") != std::string::npos);
  CHECK(changed("inliers: 20", "inliers: 9").find("c.yaml:6:") == 0);
  CHECK(changed("error_m", "eror_m").find("error_m") != std::string::npos);
  CHECK(changed("colift.calibration/1", "colift.run/1").find("c.yaml:1:") == 0);
}

TEST_CASE("samples are checked before an image is opened") {
  const std::string joints = "joints_rad: [0, 0.5, 0, -1, 0, 1, 0]";
  CHECK(why_not(sample("{" + joints + ", pixel: [300, 200]}")).empty());
  CHECK(why_not(sample("{joints_rad: [0, 30, 0, -60, 0, 45, 0], pixel: [300, 200]}")).find("degrees") !=
        std::string::npos);
  CHECK(why_not(sample("{joints_rad: [0, 1], pixel: [300, 200]}")).find("s.yaml:3:") == 0);
  CHECK(why_not(sample("{" + joints + "}")).find("neither images nor pixel") != std::string::npos);
  CHECK(
      why_not(sample("{" + joints + ", images: [{file: a.png, emitter: on}]}")).find("1 images on, 0 off") !=
      std::string::npos);
  CHECK(why_not(sample("{" + joints + ", images: [{file: ../a.png, emitter: on}]}"))
            .find("inside this folder") != std::string::npos);
  CHECK(why_not(sample("{" + joints + ", pixel: [.nan, 1]}")).find("s.yaml:3:") == 0);
  CHECK_FALSE(why_not("").empty());
}

TEST_CASE("a lens's distortion is taken out") {
  const auto k = tests::infrared_intrinsics();
  const Eigen::Vector2d ideal(100, 80);
  const double x = (ideal.x() - k.cx) / k.fx, y = (ideal.y() - k.cy) / k.fy;
  const double grow = 1.0 - 0.1 * (x * x + y * y);
  const Eigen::Vector2d seen(k.fx * x * grow + k.cx, k.fy * y * grow + k.cy);
  CHECK((perception::undistorted(seen, k, -0.1) - ideal).norm() < 1e-6);
}

TEST_CASE("a camera that was pushed is noticed by ground and arm, one that was not is believed") {
  using perception::test::RobotView;
  const perception::PoseCheckConfig config;
  int seen = 0, blamed = 0, noticed = 0, tried = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const RobotView view(seed);
    const auto check = [&](const hal::Pose& X) {
      return perception::check_pose(view.frame, X, std::nullopt, view.model, view.q_rad, view.hand, config);
    };
    const auto right = check(view.scene.X_WC);
    blamed += right.good ? 0 : 1;
    if (right.arm_points == 0) continue;
    ++seen;
    hal::Pose pushed = view.scene.X_WC;
    pushed.translation() += hal::Vec3(0.0, 0.0, 0.05);
    ++tried;
    noticed += check(pushed).good ? 0 : 1;
  }
  INFO(seen << " with the arm in view, " << noticed << " of " << tried << " noticed, " << blamed
            << " blamed");
  CHECK(seen >= 6);
  CHECK(blamed == 0);
  CHECK(noticed >= tried - 2);
}

TEST_CASE("ground that is tilted or below the floor is named") {
  const hal::DepthFrame none;
  const auto check = [&](const hal::Plane& ground) {
    return perception::check_pose(none, hal::Pose::Identity(), ground, hal::built_in_robot(),
                                  hal::JointVector::Zero(), {}, {});
  };
  CHECK(check({hal::Vec3::UnitZ(), 0.0}).good);
  CHECK(check({hal::Vec3::UnitZ(), -0.4}).good);  // a table top may be the ground
  const auto low = check({hal::Vec3::UnitZ(), 0.06});
  CHECK_FALSE(low.good);
  CHECK(low.reason.find("60 mm below") != std::string::npos);
  CHECK_FALSE(check({hal::Vec3(0.06, 0.0, 1.0).normalized(), 0.0}).good);
}
