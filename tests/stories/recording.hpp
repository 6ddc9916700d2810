#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "control/session/decide.hpp"
#include "control/session/scene_analysis.hpp"
#include "hal/drivers/recorded/frame_file.hpp"

namespace colift::stories {

using hal::Vec3;

/// A recording of tests/data/real with its measured truth.
struct Recording {
  std::filesystem::path folder;
  nlohmann::json truth;

  explicit Recording(const std::string& name)
      : folder(std::filesystem::path(COLIFT_TEST_DATA) / "real" / name) {
    std::ifstream file(folder / "truth.json");
    REQUIRE(file);
    file >> truth;
  }

  [[nodiscard]] hal::DepthFrame frame(const std::string& image = "depth.png") const {
    auto read = hal::read_frame(folder / image);
    REQUIRE(read);
    return read->frame;
  }

  [[nodiscard]] control::SceneAnalysis analysis(std::optional<Vec3> at = std::nullopt,
                                                control::Method method = control::Method::Fast,
                                                const std::string& image = "depth.png") const {
    control::SceneAnalysisInput input;
    input.frame = frame(image);
    input.at_W = at;
    control::Config config;
    control::set_method_defaults(method, config);
    auto seen = control::analyse_scene(std::move(input), method, config, {}, hal::ManualClock());
    REQUIRE(seen);
    return std::move(*seen);
  }

  [[nodiscard]] double tolerance(const char* what) const { return truth["tolerance"][what]; }

  [[nodiscard]] nlohmann::json object(const std::string& name) const {
    for (const auto& o : truth["objects"])
      if (o["name"] == name) return o;
    FAIL("no object " << name << " in the truth");
    return {};
  }
};

inline Vec3 vec(const nlohmann::json& j) {
  return Vec3(j[0].get<double>(), j[1].get<double>(), j[2].get<double>());
}

inline double angle_deg(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180.0 / M_PI;
}

inline void check_ground(const Recording& r, const perception::Scene& scene) {
  REQUIRE(scene.ground);
  const Vec3 normal = vec(r.truth["support_plane"]["normal"]).normalized();
  CHECK(angle_deg(scene.ground->plane.normal, normal) <= r.tolerance("plane_normal_deg"));
  CHECK(std::abs(scene.ground->plane.offset - r.truth["support_plane"]["d"].get<double>()) <=
        r.tolerance("plane_d_m"));
}

/// Visible box within the truth's tolerance; which of two nearly equal sides is the longer one is left open.
inline void check_box(const Recording& r, const perception::Target& t, const nlohmann::json& object) {
  const Vec3 size = vec(object["obb_size_L_W_H"]);
  INFO(object["name"].get<std::string>()
       << ": size " << t.obb.size.transpose() << " truth " << size.transpose() << ", centre "
       << t.obb.center.transpose() << " truth " << vec(object["obb_center"]).transpose());
  CHECK((t.obb.size - size).cwiseAbs().maxCoeff() <= r.tolerance("obb_size_m"));
  CHECK((t.obb.center - vec(object["obb_center"])).norm() <= r.tolerance("obb_centre_m"));
}

}  // namespace colift::stories
