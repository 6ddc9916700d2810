#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "hal/drivers/recorded/cloud_files/pcd.hpp"
#include "hal/drivers/recorded/frame_file.hpp"
#include "writers.hpp"

using namespace colift::hal;
using namespace colift::hal::test;

namespace {

constexpr const char* kLaptop = "real/02_laptop_and_box/";

RecordedFrame frame(const Result<RecordedFrame>& result) {
  INFO((result ? result->note : result.error().text()));
  REQUIRE(result);
  return *result;
}

PointFile laptop_points() {
  const auto bytes = load_file(data(std::string(kLaptop) + "source.pcd"));
  REQUIRE(bytes);
  const auto points = parse_pcd(*bytes, "source.pcd");
  REQUIRE(points);
  return *points;
}

PointFile moved(PointFile points, const Pose& X) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points.seen(i)) continue;
    const Vec3 p = X * Vec3(points.x[i], points.y[i], points.z[i]);
    points.x[i] = static_cast<float>(p.x());
    points.y[i] = static_cast<float>(p.y());
    points.z[i] = static_cast<float>(p.z());
  }
  return points;
}

Pose pose(double roll, double pitch, double yaw, const Vec3& at) {
  Pose X = Pose::Identity();
  X.linear() = (Eigen::AngleAxisd(yaw, Vec3::UnitZ()) * Eigen::AngleAxisd(pitch, Vec3::UnitY()) *
                Eigen::AngleAxisd(roll, Vec3::UnitX()))
                   .toRotationMatrix();
  X.translation() = at;
  return X;
}

// Largest distance between a point of the file and the same pixel of the frame, brought back into the file's
// frame (m).
double worst_distance(const PointFile& points, const RecordedFrame& frame) {
  REQUIRE(frame.frame.depth_m.size() == points.size());
  const CameraIntrinsics& k = frame.frame.intrinsics;
  double worst = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double z = frame.frame.depth_m[i];
    if (std::isnan(z) != !points.seen(i)) return std::numeric_limits<double>::infinity();
    if (std::isnan(z)) continue;
    const double u = static_cast<double>(i % static_cast<std::size_t>(k.width)),
                 v = static_cast<double>(i / static_cast<std::size_t>(k.width));
    const Vec3 p = frame.X_FC * Vec3((u - k.cx) / k.fx * z, (v - k.cy) / k.fy * z, z);
    worst = std::max(worst, (p - Vec3(points.x[i], points.y[i], points.z[i])).norm());
  }
  return worst;
}

}  // namespace

TEST_CASE("a real organised PCD is the depth image that was recorded with it", "[frame][real]") {
  const RecordedFrame image = frame(read_frame(data(std::string(kLaptop) + "depth_0.png")));
  const RecordedFrame cloud = frame(read_frame(data(std::string(kLaptop) + "source.pcd")));
  CHECK(cloud.organised);
  CHECK(image.points == 307200);
  CHECK(cloud.points == 307200);
  CHECK(cloud.valid_points == image.valid_points);
  const CameraIntrinsics &a = image.frame.intrinsics, &b = cloud.frame.intrinsics;
  CHECK(std::abs(a.fx - b.fx) < 0.5);
  CHECK(std::abs(a.fy - b.fy) < 0.5);
  CHECK(std::abs(a.cx - b.cx) < 0.5);
  CHECK(std::abs(a.cy - b.cy) < 0.5);
  // its VIEWPOINT is half a turn about x, but its points are in the optical frame all the same
  CHECK(cloud.X_FC.matrix().isIdentity(0.0));
  CHECK(cloud.frame.rgb.size() == 3 * 307200);
  REQUIRE(image.frame.depth_m.size() == cloud.frame.depth_m.size());
  float worst = 0.0f;
  for (std::size_t i = 0; i < image.frame.depth_m.size(); ++i) {
    REQUIRE(std::isnan(image.frame.depth_m[i]) == std::isnan(cloud.frame.depth_m[i]));
    if (!std::isnan(image.frame.depth_m[i]))
      worst = std::max(worst, std::abs(image.frame.depth_m[i] - cloud.frame.depth_m[i]));
  }
  CHECK(worst < 1e-3f);
}

TEST_CASE("every recorded scene is a frame of 640 x 480 with most pixels seen", "[frame][real]") {
  for (const char* file :
       {"01_office_chair_and_bottles/depth.png", "02_laptop_and_box/depth_1.png",
        "02_laptop_and_box/depth_2.png", "03_desk_and_two_chairs/depth.png", "04_five_people/depth.png",
        "05_can_on_table/depth.png", "06_cereal_box_on_table/depth.png"}) {
    CAPTURE(file);
    const RecordedFrame read = frame(read_frame(data(std::string("real/") + file)));
    CHECK(read.frame.intrinsics.width == 640);
    CHECK(read.frame.intrinsics.height == 480);
    CHECK(read.points == 307200);
    CHECK(read.valid_points > 190000);
    CHECK(read.organised);
  }
}

TEST_CASE("the camera is found wherever an organised cloud was moved to", "[frame]") {
  const PointFile own = laptop_points();
  const Pose X_FC = pose(-2.1, 0.2, 0.9, Vec3(1.4, -0.8, 1.1));
  PointFile points = moved(own, X_FC);

  SECTION("with the pose in the file") {
    points.viewpoint = X_FC;
    const RecordedFrame read = frame(frame_from_points(points, "moved"));
    CHECK(read.organised);
    CHECK(read.note.find("VIEWPOINT") != std::string::npos);
    CHECK((read.X_FC.inverse() * X_FC).matrix().isIdentity(1e-9));
    CHECK(worst_distance(points, read) < 1e-3);
  }
  SECTION("without a pose in the file") {
    points.viewpoint = Pose::Identity();
    const RecordedFrame read = frame(frame_from_points(points, "moved"));
    CHECK(read.organised);
    CHECK((read.X_FC.translation() - X_FC.translation()).norm() < 2e-3);
    CHECK(std::abs(Eigen::AngleAxisd(read.X_FC.linear().transpose() * X_FC.linear()).angle()) < 2e-3);
    CHECK(std::abs(read.frame.intrinsics.fx - 525.0) < 1.0);
    CHECK(worst_distance(points, read) < 1e-3);
  }
}

TEST_CASE("a tenth of wild points does not change the camera of an organised cloud by half a pixel",
          "[frame]") {
  PointFile points = laptop_points();
  for (std::size_t i = 0; i < points.size(); i += 25) {
    if (points.seen(i)) points.x[i] += 0.3f;
  }
  const RecordedFrame read = frame(frame_from_points(points, "wild"));
  CHECK(read.organised);
  CHECK(std::abs(read.frame.intrinsics.fx - 525.0) < 0.5);
  CHECK(std::abs(read.frame.intrinsics.cx - 320.0) < 0.5);
}

TEST_CASE("zeros in an organised cloud are holes as NaN is", "[frame]") {
  PointFile points = laptop_points();
  const RecordedFrame with_nan = frame(frame_from_points(points, "nan"));
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points.seen(i)) points.x[i] = points.y[i] = points.z[i] = 0.0f;
  }
  const RecordedFrame with_zero = frame(frame_from_points(points, "zero"));
  CHECK(with_zero.valid_points == with_nan.valid_points);
  CHECK(same(with_zero.frame.depth_m, with_nan.frame.depth_m));
}

TEST_CASE("an organised cloud in millimetres is refused with the unit in the sentence", "[frame]") {
  PointFile points = laptop_points();
  for (auto* column : {&points.x, &points.y, &points.z}) {
    for (float& value : *column) value *= 1000.0f;
  }
  const auto read = frame_from_points(points, "mm.pcd");
  REQUIRE_FALSE(read);
  CHECK(read.error().detail.find("millimetres") != std::string::npos);
}

TEST_CASE("a depth image takes the camera that is named before the one beside it", "[frame]") {
  const TemporaryFolder folder;
  const std::vector<std::uint16_t> values(8 * 6, 1234);
  const auto image = folder.write("depth.png", png(8, 6, 16, false, false, values));
  const auto alone = read_frame(image);
  REQUIRE_FALSE(alone);
  CHECK(alone.error().detail ==
        "a depth image needs its camera: there is no camera.json beside it and none was named");
  folder.write("camera.json", R"({"fx":10,"fy":10,"cx":4,"cy":3,"depth_scale_m":0.001})");
  CHECK(frame(read_frame(image)).frame.depth_m[0] == 1.234f);
  const auto other = folder.write("other.json", R"({"fx":20,"fy":20,"cx":4,"cy":3,"depth_scale_m":0.0001})");
  const RecordedFrame named = frame(read_frame(image, other));
  CHECK(named.frame.depth_m[0] == 0.1234f);
  CHECK(named.frame.intrinsics.fx == 20.0);
  const auto missing = read_frame(image, folder.path() / "none.json");
  REQUIRE_FALSE(missing);
  CHECK(missing.error().detail == "there is no such file");
}

TEST_CASE("content decides what an unnamed file is, and the note says so", "[frame]") {
  const TemporaryFolder folder;
  const auto bytes = load_file(data(std::string(kLaptop) + "source.pcd"));
  REQUIRE(bytes);
  const RecordedFrame read = frame(read_frame(folder.write("cloud.dat", std::string(as_text(*bytes)))));
  CHECK(read.note.find("a PCD point cloud by its content") == 0);
}
