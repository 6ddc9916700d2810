// What the thesis's method makes of the real recordings. Where it stays inside a truth file's tolerance, the
// tolerance is asserted; where it does not, the test says what it does instead, so that a change for better
// or worse shows.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "hal/drivers/recorded/frame_file.hpp"
#include "perception/thesis/thesis_target.hpp"

using namespace colift::perception;
using nlohmann::json;

namespace {

Vec3 vector_of(const json& list) {
  return Vec3(list.at(0).get<double>(), list.at(1).get<double>(), list.at(2).get<double>());
}

struct Recording {
  OrganisedCloud frame;
  json truth;

  explicit Recording(const std::string& folder, const std::string& image = "depth.png") {
    const std::string path = COLIFT_TEST_DATA "/real/" + folder + "/";
    const auto read = colift::hal::read_frame(path + image);
    REQUIRE(read);
    frame = deproject(read->frame, Pose::Identity());
    truth = json::parse(std::ifstream(path + "truth.json"));
  }

  [[nodiscard]] double tolerance(const char* what) const { return truth.at("tolerance").at(what); }

  [[nodiscard]] double plane_error_deg(const Plane& plane) const {
    const Vec3 n = vector_of(truth.at("support_plane").at("normal"));
    return std::atan2(n.cross(plane.normal).norm(), n.dot(plane.normal)) * 180 / M_PI;
  }
  [[nodiscard]] double plane_error_m(const Plane& plane) const {
    return std::abs(plane.offset - truth.at("support_plane").at("d").get<double>());
  }
  void check_ground(const Scene& scene) const {
    REQUIRE(scene.ground);
    CHECK(plane_error_deg(scene.ground->plane) < tolerance("plane_normal_deg"));
    CHECK(plane_error_m(scene.ground->plane) < tolerance("plane_d_m"));
  }

  [[nodiscard]] const json& object(const std::string& name) const {
    for (const json& o : truth.at("objects"))
      if (o.at("name") == name) return o;
    FAIL("no object " << name);
    return truth;
  }
  [[nodiscard]] double center_error_m(const Target& target, const std::string& name) const {
    return (target.obb.center - vector_of(object(name).at("obb_center"))).norm();
  }
  [[nodiscard]] double size_error_m(const Target& target, const std::string& name) const {
    return (target.obb.size - vector_of(object(name).at("obb_size_L_W_H"))).cwiseAbs().maxCoeff();
  }
};

}  // namespace

TEST_CASE("the ground of a real frame does not depend on the seed", "[thesis][real]") {
  const Recording office("01_office_chair_and_bottles");
  ThesisConfig config;
  const PclCloud cloud = voxel_grid(points_in_depth_range(office.frame, config), config);
  const auto first = split_at_ground(cloud, Vec3::Zero(), config);
  REQUIRE(first);
  for (const int seed : {2, 3, 4}) {
    config.seed = seed;
    const auto other = split_at_ground(cloud, Vec3::Zero(), config);
    REQUIRE(other);
    CHECK((other->ground.plane.normal - first->ground.plane.normal).norm() < 0.001);
    CHECK(std::abs(other->ground.plane.offset - first->ground.plane.offset) < 0.001);
  }
}

TEST_CASE("the can on the table is found within its tolerances", "[thesis][real]") {
  const Recording can("05_can_on_table");
  const Scene scene = thesis_scene(can.frame, ThesisConfig{});
  can.check_ground(scene);
  REQUIRE(scene.target);
  CHECK(can.center_error_m(*scene.target, "can") < can.tolerance("obb_centre_m"));
  CHECK(can.size_error_m(*scene.target, "can") < can.tolerance("obb_size_m"));
}

TEST_CASE("outlier removal eats the edges of the cereal box; without it the tolerances are met",
          "[thesis][real]") {
  const Recording box("06_cereal_box_on_table");
  ThesisConfig config;
  const Scene eaten = thesis_scene(box.frame, config);
  box.check_ground(eaten);
  REQUIRE(eaten.target);
  CHECK(box.size_error_m(*eaten.target, "cereal box") > box.tolerance("obb_size_m"));
  CHECK(box.size_error_m(*eaten.target, "cereal box") < 0.05);
  CHECK(box.center_error_m(*eaten.target, "cereal box") < 0.025);

  config.outlier_neighbours = 0;
  config.ground_distance_m = 0.008;
  const Scene whole = thesis_scene(box.frame, config);
  box.check_ground(whole);
  REQUIRE(whole.target);
  CHECK(box.size_error_m(*whole.target, "cereal box") < box.tolerance("obb_size_m"));
  CHECK(box.center_error_m(*whole.target, "cereal box") < box.tolerance("obb_centre_m"));
}

TEST_CASE("objects that touch, laptop and carton, are one target", "[thesis][real]") {
  const Recording touching("02_laptop_and_box", "depth_0.png");
  const Scene scene = thesis_scene(touching.frame, ThesisConfig{});
  touching.check_ground(scene);
  REQUIRE(scene.target);
  for (const char* name : {"laptop", "box"}) {
    const Vec3 off = scene.target->obb.axes.transpose() *
                     (vector_of(touching.object(name).at("obb_center")) - scene.target->obb.center);
    CHECK((off.cwiseAbs().array() < 0.5 * scene.target->obb.size.array() + 0.02).all());
  }
  CHECK(scene.target->obb.size.x() == Approx(0.57).margin(0.03));
}

TEST_CASE("among chair, bottles and a drawer unit cut by the border, the drawer unit has the most points",
          "[thesis][real]") {
  const Recording office("01_office_chair_and_bottles");
  ThesisConfig config;
  config.depth_max_m = 2.0;  // the clutter at three metres would be larger still
  const Scene scene = thesis_scene(office.frame, config);
  office.check_ground(scene);
  REQUIRE(scene.target);
  CHECK(office.center_error_m(*scene.target, "drawer unit") < office.tolerance("obb_centre_m"));
  CHECK(office.size_error_m(*scene.target, "drawer unit") < 0.05);
}

TEST_CASE("the desk, seen with its partition and shelves, is one cluster of 2.4 m", "[thesis][real]") {
  const Recording desk("03_desk_and_two_chairs");
  ThesisConfig config;
  config.voxel_leaf_m = 0.02;
  config.surface_min_points = 1000000;  // no rectangles: hundreds, of which nothing is asked here
  const Scene scene = thesis_scene(desk.frame, config);
  REQUIRE(scene.ground);
  // outside the tolerances (1.5 degrees, 0.04 m): far, noisy floor and what stands on it weigh as much as the
  // near floor
  CHECK(desk.plane_error_deg(scene.ground->plane) < 2.5);
  CHECK(desk.plane_error_m(scene.ground->plane) < 0.065);
  REQUIRE(scene.target);
  CHECK(scene.target->obb.size.x() == Approx(2.4).margin(0.15));
  CHECK(scene.target->obb.size.z() > 0.8);
}

TEST_CASE("five people and no object: the thesis takes a person for the target", "[thesis][real]") {
  const Recording people("04_five_people");
  ThesisConfig config;
  config.voxel_leaf_m = 0.02;
  config.surface_min_points = 1000000;
  const Scene scene = thesis_scene(people.frame, config);
  people.check_ground(scene);
  REQUIRE(scene.target);
  CHECK(scene.target->obb.size.z() == Approx(1.7).margin(0.15));
}
