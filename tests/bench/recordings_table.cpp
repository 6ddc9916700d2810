// What both methods find on the real recordings, against the truth that was measured by hand: the table of
// docs/perception.md.
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <string>

#include "bench_timing.hpp"
#include "hal/drivers/recorded/frame_file.hpp"
#include "perception/ground/ground.hpp"
#include "perception/target/target.hpp"
#include "perception/thesis/thesis_target.hpp"

namespace {

using namespace colift;
using namespace colift::perception;
using nlohmann::json;

Vec3 vec(const json& j) {
  return {j[0].get<double>(), j[1].get<double>(), j[2].get<double>()};
}

Scene fast_scene(const OrganisedCloud& cloud) {
  const NoiseModel noise;
  Scene scene;
  const auto blocks = fit_block_planes(cloud, noise);
  scene.ground = find_ground(cloud, blocks, std::nullopt, noise, {}).ground;
  if (!scene.ground) return scene;
  scene.target = find_target(cloud, blocks, *scene.ground, noise, {}).target;
  return scene;
}

std::string mark(bool within) {
  return within ? "" : " **!**";
}

// errors of the ground, each with its tolerance's verdict
std::string ground_cells(const Scene& scene, const json& truth) {
  if (!scene.ground) return "none **!** | |";
  const Vec3 normal = vec(truth["support_plane"]["normal"]).normalized();
  const double angle =
      std::atan2(scene.ground->plane.normal.cross(normal).norm(), scene.ground->plane.normal.dot(normal)) *
      180.0 / std::numbers::pi;
  const double offset = std::abs(scene.ground->plane.offset - truth["support_plane"]["d"].get<double>());
  return fmt::format("{:.2f}{} | {:.1f}{} |", angle,
                     mark(angle <= truth["tolerance"]["plane_normal_deg"].get<double>()), 1e3 * offset,
                     mark(offset <= truth["tolerance"]["plane_d_m"].get<double>()));
}

// the object of the truth whose box is nearest to a point
const json* nearest(const json& truth, const Vec3& p) {
  const json* best = nullptr;
  for (const json& o : truth["objects"])
    if (!best || (vec(o["obb_center"]) - p).norm() < (vec((*best)["obb_center"]) - p).norm()) best = &o;
  return best;
}

std::string target_cells(const Scene& scene, const json& truth) {
  const json& largest = truth["largest_object"];
  if (!scene.target) return fmt::format("none{} | | |", mark(largest.is_null()));
  const OrientedBox& box = scene.target->obb;
  const std::string size =
      fmt::format("{:.2f} x {:.2f} x {:.2f} m", box.size.x(), box.size.y(), box.size.z());
  if (largest.is_null()) return fmt::format("{} where there is no object **!** | | |", size);
  // the desk is known by its top alone
  if (truth.contains("desk_top") && largest == "desk") {
    const json& top = truth["desk_top"];
    const double above = std::abs(scene.ground ? scene.ground->plane.height(vec(top["center"])) -
                                                     top["height_over_floor"].get<double>()
                                               : 1.0);
    const bool on_top = scene.target->aabb.contains(vec(top["center"]));
    const double length = std::abs(box.size.x() - top["visible_extent_L_W"][0].get<double>());
    return fmt::format("{}{} | length {:.0f}{} | top's height {:.0f}{} |", on_top ? "desk, " + size : size,
                       mark(on_top), 1e3 * length,
                       mark(length <= truth["tolerance"]["obb_size_m"].get<double>()), 1e3 * above,
                       mark(above <= truth["tolerance"]["desk_top_height_m"].get<double>()));
  }
  const json& object = *nearest(truth, box.center);
  const bool there = (box.center - vec(object["obb_center"])).norm() < 0.5;
  const std::string name = there ? object["name"].get<std::string>() : "another object";
  const double size_error = (box.size - vec(object["obb_size_L_W_H"])).cwiseAbs().maxCoeff();
  const double center_error = (box.center - vec(object["obb_center"])).norm();
  const bool right = name == largest.get<std::string>();
  return fmt::format("{}, {}{} | {:.0f}{} | {:.0f}{} |", name, size, mark(right), 1e3 * size_error,
                     mark(size_error <= truth["tolerance"]["obb_size_m"].get<double>()), 1e3 * center_error,
                     mark(center_error <= truth["tolerance"]["obb_centre_m"].get<double>()));
}

}  // namespace

int main() {
  bench::keep_memory();
  const std::filesystem::path real = std::filesystem::path(COLIFT_TEST_DATA) / "real";
  const ThesisConfig thesis;
  fmt::print(
      "| recording | method | ground: angle (deg) | offset (mm) | target, visible box | size error (mm) | "
      "centre error (mm) | time (ms) |\n"
      "| --- | --- | ---: | ---: | --- | ---: | ---: | ---: |\n");
  for (const char* folder : {"01_office_chair_and_bottles", "02_laptop_and_box", "03_desk_and_two_chairs",
                             "04_five_people", "05_can_on_table", "06_cereal_box_on_table"}) {
    json truth;
    std::ifstream(real / folder / "truth.json") >> truth;
    const bool several = std::filesystem::exists(real / folder / "depth_0.png");
    const auto read = hal::read_frame(real / folder / (several ? "depth_0.png" : "depth.png"));
    if (!read) {
      fmt::print(stderr, "{}: cannot be read\n", folder);
      return 1;
    }
    const auto row = [&](const char* method, const Scene& scene, double ms) {
      fmt::print("| {} | {} | {} {} {:.{}f} |\n", folder, method, ground_cells(scene, truth),
                 target_cells(scene, truth), ms, ms < 20 ? 1 : 0);
    };
    const auto fast = [&] { return fast_scene(deproject(read->frame, read->X_FC)); };
    const auto slow = [&] { return thesis_scene(deproject(read->frame, read->X_FC), thesis); };
    row("fast", fast(), bench::time_ms(21, [&] { (void)fast(); }));
    row("thesis", slow(), bench::time_ms(3, [&] { (void)slow(); }));
  }
}
