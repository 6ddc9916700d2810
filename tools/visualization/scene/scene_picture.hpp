#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hal/types/result.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"
#include "planner/grasp_candidate.hpp"
#include "tools/visualization/canvas.hpp"

namespace colift::picture {

using hal::Vec3;

/// All that a picture shows. What is unset or null is left out. Frame W, SI units. Pointers are borrowed for
/// the call.
struct ScenePicture {
  const perception::OrganisedCloud* cloud = nullptr;  ///< Without it only panel and top view are drawn.
  const std::vector<std::uint8_t>* rgb =
      nullptr;  ///< 3 bytes for each pixel of the cloud; any other size is ignored.
  const perception::Scene* scene = nullptr;
  const std::vector<planner::GraspCandidate>* candidates = nullptr;
  std::optional<perception::PartnerGrasp> partner;
  std::vector<std::uint32_t> partner_pixels;  ///< Pixels that changed; what lies outside is ignored.
  std::optional<double> share;                ///< The robot's part of the load, 0 to 1.
  std::optional<Vec3> optimum;                ///< Best grasp of the closed form, anywhere in space.
  double hand_opening_m = 0.19;               ///< Of the gripper that is sketched at the chosen grasp.
  double palm_gap_m = 0.03;                   ///< Palm to grasp point, against the approach.
  std::string title;
  std::string reason;  ///< What was decided and why, in a sentence or two.
  std::vector<std::pair<std::string, std::string>> figures;  ///< More key figures: name, value.
  std::vector<std::string> notes;
};

/// The frame as a shaded image with all that was found in it, a legend beneath, and a panel at the right with
/// the reason, the load share, key figures and a top view. About 1740 pixels wide; as high as its text needs.
[[nodiscard]] Canvas draw_scene_picture(const ScenePicture& what);

/// The same as the bytes of a PNG file.
[[nodiscard]] std::vector<std::uint8_t> scene_picture_png(const ScenePicture& what);

/// The same written to a file. Errors: BadInput when it cannot be written.
[[nodiscard]] hal::Result<> write_scene_picture(const std::filesystem::path& png, const ScenePicture& what);

/// Where the image of the frame lies in the picture of a cloud: output pixels for each pixel of the frame.
/// The image's top left corner is the picture's.
[[nodiscard]] int picture_scale(const perception::OrganisedCloud& cloud);

}  // namespace colift::picture
