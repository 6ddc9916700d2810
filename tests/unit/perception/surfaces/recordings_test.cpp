// Real frames: what the surfaces of the can and of the cereal box are.
#include <catch2/catch.hpp>

#include "hal/drivers/recorded/frame_file.hpp"
#include "perception/ground/block_planes.hpp"
#include "perception/ground/ground.hpp"
#include "perception/target/target.hpp"
#include "views.hpp"

using namespace colift;
using namespace colift::perception;

namespace {

struct Recording {
  OrganisedCloud cloud;
  Ground ground;
  Target target;

  explicit Recording(const std::string& folder) {
    const auto frame = hal::read_frame(std::string(COLIFT_TEST_DATA) + "/real/" + folder + "/depth.png");
    REQUIRE(frame);
    cloud = deproject(frame->frame, hal::Pose::Identity());
    const NoiseModel noise;
    const auto blocks = fit_block_planes(cloud, noise);
    const GroundResult g = find_ground(cloud, blocks, std::nullopt, noise, GroundConfig{});
    REQUIRE(g.ground);
    ground = *g.ground;
    const TargetResult t = find_target(cloud, blocks, ground, noise, TargetConfig{});
    INFO(t.reason);
    REQUIRE(t.target);
    target = *t.target;
  }
  [[nodiscard]] std::vector<Surface> surfaces() const {
    return find_surfaces(cloud, target, ground, NoiseModel{}, SurfaceConfig{});
  }
};

}  // namespace

TEST_CASE("the can on the table is an upright cylinder of 35 mm", "[surfaces][real]") {
  const Recording can("05_can_on_table");
  const auto cylinders = cylinders_of(can.surfaces());
  REQUIRE(cylinders.size() == 1);
  CHECK(cylinders[0].radius == Approx(0.035).margin(0.003));
  CHECK(angle_deg(cylinders[0].axis, can.ground.plane.normal) < 2.0);
  // the truth's point on the axis
  const Vec3 d = cylinders[0].center - Vec3(0.0193, -0.0277, 0.6433);
  CHECK((d - cylinders[0].axis * cylinders[0].axis.dot(d)).norm() < 0.004);
  CHECK(cylinders[0].length == Approx(0.148).margin(0.02));
  const CompletedShape shape =
      complete_shape(can.cloud, can.target, can.surfaces(), can.ground, NoiseModel{});
  CHECK(shape.kind == CompletedShape::Kind::Cylinder);
}

TEST_CASE("the cereal box on the table is two or more faces at right angles, and no cylinder",
          "[surfaces][real]") {
  const Recording box("06_cereal_box_on_table");
  const auto surfaces = box.surfaces();
  CHECK(cylinders_of(surfaces).empty());
  const auto faces = rectangles_of(surfaces);
  REQUIRE(faces.size() >= 2);
  CHECK(angle_deg(faces[0].normal, faces[1].normal) == Approx(90).margin(5));
  // nominal 60 x 158 x 210 mm; the lowest centimetre belongs to the table
  CHECK(faces[0].size.x() == Approx(0.19).margin(0.03));
  CHECK(faces[0].size.y() == Approx(0.158).margin(0.02));
}

TEST_CASE("a desk with things on it is no chair", "[surfaces][completion][real]") {
  const Recording desk("03_desk_and_two_chairs");
  const CompletedShape shape =
      complete_shape(desk.cloud, desk.target, desk.surfaces(), desk.ground, NoiseModel{});
  CHECK(shape.kind == CompletedShape::Kind::Plate);
  CHECK(shape.reason.find("stand on it") != std::string::npos);
  // its top, measured by hand
  CHECK(desk.ground.plane.height(shape.box.center) + 0.5 * shape.box.size.z() == Approx(0.70).margin(0.03));
}

TEST_CASE("no rectangle of a real frame is smaller than a hand can use", "[surfaces][real]") {
  for (const char* folder : {"01_office_chair_and_bottles", "03_desk_and_two_chairs"})
    for (const Rectangle& r : rectangles_of(Recording(folder).surfaces()))
      CHECK(r.size.prod() >= SurfaceConfig{}.min_area_m2);
}

TEST_CASE("the office chair is seen without a rectangle or cylinder larger than itself", "[surfaces][real]") {
  const Recording office("01_office_chair_and_bottles");
  const auto surfaces = office.surfaces();
  REQUIRE_FALSE(surfaces.empty());
  for (const Rectangle& r : rectangles_of(surfaces)) CHECK(r.size.x() < 0.8);
  for (const Cylinder& c : cylinders_of(surfaces)) CHECK(c.length < 0.8);
}
