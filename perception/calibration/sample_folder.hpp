#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hal/config/range.hpp"
#include "hal/depth_camera.hpp"
#include "hal/infrared_camera.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "hal/types/result.hpp"
#include "perception/calibration/emitter_model.hpp"
#include "perception/calibration/spot_finder.hpp"

namespace colift::perception {

/// An image of one pose, a file beside samples.yaml.
struct SampleImage {
  std::string file;
  std::string emitter = "unknown";

  template <class Visitor>
  void visit(Visitor& v) {
    v("file", file, "16-bit grey PNG, one unit for one step of brightness.", hal::Presence::Required);
    v("emitter", emitter, hal::Choices{"on", "off", "unknown"},
      "Whether it is lit; unknown for one that blinks by itself, in all images of a pose or in none.");
  }
};

/// One pose of the arm: its joints, and the images or the spot that was found in them.
struct SampleEntry {
  std::vector<double> joints_rad;
  std::vector<SampleImage> images;
  std::vector<double> pixel;
  double sigma_px = 0.0;
  std::string depth;
  std::optional<double> depth_m;

  template <class Visitor>
  void visit(Visitor& v) {
    v("joints_rad", joints_rad, hal::Range{-400, 400}, "A1 to A7 as measured (rad).",
      hal::Presence::Required);
    v("images", images, "Infrared images of this pose.");
    v("pixel", pixel, hal::Range{-100, 10000}, "The spot [u, v] instead of images (px).");
    v("sigma_px", sigma_px, hal::Range{0, 50}, "How well that is known (px); 0: as usual.");
    v("depth", depth, "16-bit grey PNG with the depth in mm, emitter off.");
    v("depth_m", depth_m, hal::Range{0.1, 10}, "Depth near the emitter instead of that image (m).");
  }
};

/// samples.yaml (schema colift.calibration_samples/1).
struct SampleFile {
  std::string schema = "colift.calibration_samples/1";
  std::string date;
  int width = 640, height = 488;
  double fx = 575.8, fy = 575.8, cx = 325.0, cy = 244.0, k1 = 0.0;
  std::vector<SampleEntry> samples;

  template <class Visitor>
  void visit(Visitor& v) {
    v("schema", schema, hal::Choices{"colift.calibration_samples/1"}, "What this file is.",
      hal::Presence::Required);
    v("date", date, "When the samples were taken.");
    v("width", width, hal::Range{16, 8192}, "Of the infrared images (px).");
    v("height", height, hal::Range{16, 8192}, "Of the infrared images (px).");
    v("fx", fx, hal::Range{10, 20000}, "Intrinsics of the infrared image (px).");
    v("fy", fy, hal::Range{10, 20000}, "The same.");
    v("cx", cx, hal::Range{-1000, 9000}, "The same.");
    v("cy", cy, hal::Range{-1000, 9000}, "The same.");
    v("k1", k1, hal::Range{-0.5, 0.5}, "First radial distortion of the lens.");
    v("samples", samples, "One for each pose of the arm.", hal::Presence::Required);
  }
};

/// What became of the images of one pose.
struct ReadSample {
  int index = 0;  ///< In the file.
  std::optional<Spot> spot;
  std::string refused;  ///< Why there is no spot; the pose is left out then.
};

/// The samples of a folder, ready to be solved.
struct SampleSet {
  std::string date;
  hal::CameraIntrinsics camera;
  std::vector<EmitterSample> samples;
  std::vector<hal::JointVector> joints_rad;
  std::vector<int> index;        ///< For each sample, its place in the file.
  std::vector<ReadSample> read;  ///< For each pose of the file.
};

/// Checks a samples.yaml: joints (seven, within the robot's limits: degrees are told from radians), images or
/// a pixel, not both. Errors: BadConfig with file:line:column, what was found and what was expected.
[[nodiscard]] hal::Result<SampleFile> parse_samples(const std::string& yaml, const std::string& name,
                                                    const hal::RobotModel& robot);

/// Reads a folder with samples.yaml and its images. Errors: as parse_samples(), and those of the images. A
/// pose in whose images no spot is found is left out, with the reason.
[[nodiscard]] hal::Result<SampleSet> load_samples(const std::filesystem::path& folder,
                                                  const hal::RobotModel& robot, const SpotConfig& config);

/// The pixel that a lens without distortion k1 would have shown: x_d = x (1 + k1 r^2).
[[nodiscard]] Eigen::Vector2d undistorted(const Eigen::Vector2d& pixel, const hal::CameraIntrinsics& camera,
                                          double k1);

/// Writes samples as they are taken, for load_samples(): images at once, samples.yaml after every pose.
/// Errors: BadInput with the path.
class SampleWriter {
 public:
  SampleWriter(std::filesystem::path folder, const hal::CameraIntrinsics& camera, std::string date);
  [[nodiscard]] hal::Result<> add(const hal::JointVector& q_rad,
                                  const std::vector<hal::InfraredFrame>& blinking,
                                  const std::optional<hal::DepthFrame>& depth);

 private:
  std::filesystem::path folder_;
  SampleFile file_;
};

}  // namespace colift::perception
