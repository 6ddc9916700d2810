// What `colift check` says of a calibration without a camera, and with one picture of it.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "sim_hal/synthetic/kinect/kinect_noise.hpp"
#include "sim_hal/synthetic/ray_caster.hpp"
#include "tools/check/check_calibration.hpp"
#include "tools/doctor/doctor_usb_capture.hpp"

using namespace colift;
using tools::check_calibration;
using tools::check_ground;

namespace {

constexpr std::int64_t kDay = 86400;

perception::CalibrationFile calibration_at(const hal::Pose& X_BC) {
  perception::CalibrationFile file;
  file.date = "2026-05-01T12:00:00Z";
  file.camera_xyz_m = X_BC.translation();
  const Eigen::Quaterniond q(X_BC.linear());
  file.camera_quaternion = {q.x(), q.y(), q.z(), q.w()};
  file.rms_px = 0.41;
  file.error_m = 0.0016;
  file.inliers = 20;
  return file;
}

const hal::Pose kGood = sim_hal::look_at({2.1, -0.7, 1.3}, {0.65, 0.0, 0.45});

std::int64_t days_later(double days) {
  return *tools::seconds_of_date("2026-05-01T12:00:00Z") + static_cast<std::int64_t>(days * kDay);
}

bool warns(const tools::CalibrationCheck& c, const std::string& words) {
  for (const std::string& w : c.warnings)
    if (w.find(words) != std::string::npos) return true;
  return false;
}

/// The floor and a box, as a camera at X_WC sees them.
hal::DepthFrame floor_image(const hal::Pose& X_WC) {
  sim_hal::World world;
  world.shapes.push_back(sim_hal::half_space(hal::Vec3::Zero(), hal::Vec3::UnitZ(), sim_hal::Label::Ground));
  world.shapes.push_back(sim_hal::box({0.8, 0.1, 0.2}, {0.4, 0.4, 0.4}, 0.2, sim_hal::Label::Target));
  return sim_hal::measure(sim_hal::cast_rays(world, hal::CameraIntrinsics{}, X_WC), sim_hal::KinectNoise{},
                          5);
}

}  // namespace

TEST_CASE("a calibration says how old and how good it is, and where the camera is", "[check]") {
  const auto c = check_calibration(calibration_at(kGood), {}, {}, days_later(3.2));
  INFO(c.summary);
  CHECK_FALSE(c.reason);
  CHECK(c.warnings.empty());
  CHECK(c.summary.find("3 days old") != std::string::npos);
  CHECK(c.summary.find("0.41 px by 20 poses") != std::string::npos);
  CHECK(c.summary.find("1.6 mm") != std::string::npos);
  CHECK(c.summary.find("(2.10, -0.70, 1.30)") != std::string::npos);
  CHECK(c.height_m == Approx(1.3));
  CHECK(c.down_deg ==
        Approx(std::atan2(1.3 - 0.45, std::hypot(2.1 - 0.65, 0.7)) * 180.0 / M_PI).margin(0.01));
}

TEST_CASE("a calibration that no camera beside a robot can have is refused", "[check]") {
  const auto below = check_calibration(calibration_at(sim_hal::look_at({2.1, -0.7, -0.3}, {0.65, 0, 0.45})),
                                       {}, {}, days_later(1));
  REQUIRE(below.reason);
  CHECK_THAT(*below.reason, Catch::Contains("-0.30 m above the robot's floor"));
  const auto away = check_calibration(calibration_at(sim_hal::look_at({2.1, -0.7, 1.3}, {4.0, 0, 0.45})), {},
                                      {}, days_later(1));
  REQUIRE(away.reason);
  CHECK_THAT(*away.reason, Catch::Contains("looks past") || Catch::Contains("look past the workspace"));
}

TEST_CASE("what makes a calibration doubtful is said, with its numbers", "[check]") {
  auto file = calibration_at(kGood);
  CHECK(warns(check_calibration(file, {}, {}, days_later(200)), "200 days old"));
  CHECK(warns(check_calibration(file, {}, {}, days_later(-30)), "future"));
  file.date = "yesterday";
  const auto undated = check_calibration(file, {}, {}, days_later(0));
  CHECK_FALSE(undated.age_days);
  CHECK(undated.summary.find("unknown day") != std::string::npos);
  file = calibration_at(kGood);
  file.fx = file.fy = 585.6;
  CHECK(warns(check_calibration(file, {}, {}, days_later(1)), "585.6"));
  hal::KinectConfig same;
  same.fx = same.fy = 585.6;
  CHECK(check_calibration(file, {}, same, days_later(1)).warnings.empty());
  file = calibration_at(kGood);
  file.cx += 9.0;
  CHECK(warns(check_calibration(file, {}, {}, days_later(1)), "principal point"));
  CHECK(warns(check_calibration(calibration_at(sim_hal::look_at({3.9, -2.7, 2.3}, {0.65, 0, 0.45})), {}, {},
                                days_later(1)),
              "from the workspace's middle"));
  const hal::Pose turned = kGood * Eigen::AngleAxisd(M_PI, hal::Vec3::UnitZ());
  CHECK(warns(check_calibration(calibration_at(turned), {}, {}, days_later(1)), "upside down"));
  for (const char* no_date : {"", "2026-13-01T00:00:00Z", "2026-05-01", "2026-05-01T12:00:00Zx"})
    CHECK_FALSE(tools::seconds_of_date(no_date));
}

TEST_CASE("one picture shows whether the ground is where the calibration has it", "[check]") {
  const control::Config config;
  const auto good = check_ground(floor_image(kGood), kGood, config);
  INFO(good.reason);
  CHECK(good.good);
  CHECK(*good.tilt_deg < 1.0);
  CHECK(std::abs(*good.height_m) < 0.02);

  const auto tilted =
      check_ground(floor_image(kGood * Eigen::AngleAxisd(0.09, hal::Vec3::UnitX())), kGood, config);
  CHECK_FALSE(tilted.good);
  CHECK_THAT(tilted.reason, Catch::Contains("tilted by") && Catch::Contains("calibrate again"));
  const auto far =
      check_ground(floor_image(kGood * Eigen::AngleAxisd(0.4, hal::Vec3::UnitX())), kGood, config);
  CHECK_FALSE(far.good);
  hal::Pose higher = kGood;
  higher.translation().z() += 0.1;
  const auto low = check_ground(floor_image(higher), kGood, config);
  CHECK_FALSE(low.good);
  CHECK_THAT(low.reason, Catch::Contains("below the"));
  hal::DepthFrame blind = floor_image(kGood);
  std::fill(blind.depth_m.begin(), blind.depth_m.end(), std::numeric_limits<float>::quiet_NaN());
  const auto nothing = check_ground(blind, kGood, config);
  CHECK_FALSE(nothing.good);
  CHECK_THAT(nothing.reason, Catch::Contains("no ground"));
}

TEST_CASE("the doctor says whether the capture process is there and starts with its library", "[doctor]") {
  using tools::CaptureAnswer;
  using Verdict = tools::DoctorRow::Verdict;
  const auto fine = [](const std::filesystem::path&) {
    return CaptureAnswer{true, "11-bit depth, infrared"};
  };
  const auto broken = [](const std::filesystem::path&) {
    return CaptureAnswer{false, "error while loading shared libraries: libfreenect.so.0.5"};
  };
  // any file will do for one that is there
  const std::filesystem::path here = "/proc/self/exe", missing = "/nowhere/colift-kinect";
  CHECK(tools::capture_rows(missing, false, fine).front().verdict == Verdict::Warn);
  CHECK(tools::capture_rows(missing, true, fine).front().verdict == Verdict::Bad);
  CHECK(tools::capture_rows(here, true, fine).front().verdict == Verdict::Ok);
  const auto row = tools::capture_rows(here, true, broken).front();
  CHECK(row.verdict == Verdict::Bad);
  CHECK(row.found.find("libfreenect.so.0.5") != std::string::npos);
  CHECK(row.repair.find("apt install libfreenect0.5") != std::string::npos);
  // a program that is none, asked in earnest
  CHECK_FALSE(tools::ask_capture("/bin/false").fine);
  CHECK(tools::ask_capture("/bin/true").fine);
}
