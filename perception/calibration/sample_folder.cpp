#include "perception/calibration/sample_folder.hpp"

#include <fmt/format.h>

#include <cmath>
#include <fstream>

#include "hal/config/config_file.hpp"
#include "hal/drivers/recorded/depth_png.hpp"
#include "hal/drivers/recorded/file_bytes.hpp"
#include "hal/lens.hpp"
#include "perception/calibration/grey_png.hpp"
#include "perception/calibration/yaml_places.hpp"

namespace colift::perception {
namespace {

using hal::ErrorCode;

// beyond a joint limit by more than this: not measured on this arm
constexpr double kLimitMargin_rad = 0.1;
constexpr double kMillimetre = 0.001;
constexpr std::size_t kMostSamples = 2000;  // bounds memory and time of a damaged or hostile file

hal::CameraIntrinsics camera_of(const SampleFile& f) {
  return {f.width, f.height, f.fx, f.fy, f.cx, f.cy};
}

/// What is wrong with one entry: the key and the sentence.
struct Flaw {
  const char* key;
  std::string detail;
};

std::optional<Flaw> flaw_of(const SampleEntry& s, const hal::RobotModel& robot) {
  if (s.joints_rad.size() != hal::kArmJoints)
    return Flaw{"joints_rad", fmt::format("found {} numbers; expected the {} joints of the arm",
                                          s.joints_rad.size(), hal::kArmJoints)};
  const hal::JointVector lower = robot.lower_rad(), upper = robot.upper_rad();
  for (int i = 0; i < hal::kArmJoints; ++i) {
    const double q = s.joints_rad[static_cast<std::size_t>(i)];
    if (q < lower[i] - kLimitMargin_rad || q > upper[i] + kLimitMargin_rad)
      return Flaw{"joints_rad", fmt::format("A{} = {:g} is beyond {:.2f} to {:.2f} rad{}", i + 1, q, lower[i],
                                            upper[i], std::abs(q) > 3.2 ? ": are these degrees?" : "")};
  }
  if (s.images.empty() == s.pixel.empty())
    return Flaw{"images", s.images.empty() ? "found neither images nor pixel; expected one of them"
                                           : "found images and pixel; expected one of them"};
  if (!s.pixel.empty() && s.pixel.size() != 2)
    return Flaw{"pixel", fmt::format("found {} numbers; expected [u, v]", s.pixel.size())};
  if (!s.depth.empty() && s.depth_m) return Flaw{"depth_m", "found depth and depth_m; expected one of them"};
  int on = 0, off = 0, unknown = 0;
  for (const SampleImage& image : s.images) {
    if (image.file.empty() || image.file.find("..") != std::string::npos || image.file.front() == '/')
      return Flaw{"images", fmt::format("found the file name \"{}\"; expected one inside this folder",
                                        hal::quotable(image.file))};
    (image.emitter == "on" ? on : image.emitter == "off" ? off : unknown) += 1;
  }
  if (!s.images.empty() && (unknown > 0 ? on + off > 0 || unknown < 4 : on == 0 || off == 0))
    return Flaw{
        "images",
        fmt::format("found {} images on, {} off, {} unknown; expected at least one on and one off, or at "
                    "least four that are all unknown",
                    on, off, unknown)};
  return std::nullopt;
}

hal::Result<hal::InfraredFrame> read_infrared(const std::filesystem::path& path, const SampleFile& f) {
  const auto bytes = hal::load_file(path);
  if (!bytes) return tl::unexpected(bytes.error());
  const auto image = hal::parse_depth_png(*bytes, path.string(), 1.0);
  if (!image) return tl::unexpected(image.error());
  if (image->width != f.width || image->height != f.height)
    return hal::failure(ErrorCode::BadInput, path.string() + ": header",
                        fmt::format("found {} x {} pixels; samples.yaml says {} x {}", image->width,
                                    image->height, f.width, f.height));
  hal::InfraredFrame out;
  out.intrinsics = camera_of(f);
  out.width = f.width;
  out.height = f.height;
  out.brightness.reserve(image->depth_m.size());
  for (const float b : image->depth_m)  // black is "no data" in a depth image
    out.brightness.push_back(b == b ? static_cast<std::uint16_t>(std::lround(b)) : std::uint16_t{0});
  return out;
}

hal::Result<std::optional<double>> read_depth(const std::filesystem::path& path, const SampleFile& f,
                                              const Spot& spot) {
  const auto bytes = hal::load_file(path);
  if (!bytes) return tl::unexpected(bytes.error());
  auto image = hal::parse_depth_png(*bytes, path.string(), kMillimetre);
  if (!image) return tl::unexpected(image.error());
  hal::DepthFrame frame;
  frame.intrinsics = hal::depth_of(camera_of(f));
  frame.intrinsics.width = image->width;
  frame.intrinsics.height = image->height;
  frame.depth_m = std::move(image->depth_m);
  return depth_near(frame, spot.pixel);
}

}  // namespace

Eigen::Vector2d undistorted(const Eigen::Vector2d& pixel, const hal::CameraIntrinsics& k, double k1) {
  hal::LensDistortion lens;
  lens.k1 = k1;
  const auto [x, y] = lens.undistort((pixel.x() - k.cx) / k.fx, (pixel.y() - k.cy) / k.fy);
  return {k.fx * x + k.cx, k.fy * y + k.cy};
}

hal::Result<SampleFile> parse_samples(const std::string& yaml, const std::string& name,
                                      const hal::RobotModel& robot) {
  SampleFile file;
  hal::FieldTable table = hal::table_of(file);
  if (auto done = hal::apply_yaml_text(table, yaml, name); !done) return tl::unexpected(done.error());
  if (auto done = hal::check_fields(table, name); !done) return tl::unexpected(done.error());
  if (file.samples.empty() || file.samples.size() > kMostSamples)
    return hal::failure(ErrorCode::BadConfig, place_of(yaml, name, "samples"),
                        fmt::format("found {} samples; expected 1 to {}", file.samples.size(), kMostSamples));
  for (std::size_t i = 0; i < file.samples.size(); ++i)
    if (const auto flaw = flaw_of(file.samples[i], robot))
      return hal::failure(ErrorCode::BadConfig, place_of(yaml, name, "samples", i, flaw->key),
                          fmt::format("samples[{}].{}: {}", i, flaw->key, flaw->detail));
  return file;
}

hal::Result<SampleSet> load_samples(const std::filesystem::path& folder, const hal::RobotModel& robot,
                                    const SpotConfig& config) {
  const std::filesystem::path path = folder / "samples.yaml";
  const auto text = hal::read_yaml_file(path);
  if (!text) return tl::unexpected(text.error());
  const auto file = parse_samples(*text, path.string(), robot);
  if (!file) return tl::unexpected(file.error());

  SampleSet out;
  out.date = file->date;
  out.camera = camera_of(*file);
  for (std::size_t i = 0; i < file->samples.size(); ++i) {
    const SampleEntry& s = file->samples[i];
    ReadSample read;
    read.index = static_cast<int>(i);
    if (!s.pixel.empty()) {
      read.spot = Spot{};
      read.spot->pixel = {s.pixel[0], s.pixel[1]};
      read.spot->covariance = s.sigma_px * s.sigma_px * Eigen::Matrix2d::Identity();
    } else {
      std::vector<hal::InfraredFrame> on, off, unknown;
      for (const SampleImage& image : s.images) {
        auto frame = read_infrared(folder / image.file, *file);
        if (!frame) return tl::unexpected(frame.error());
        (image.emitter == "on" ? on : image.emitter == "off" ? off : unknown).push_back(std::move(*frame));
      }
      auto spot = unknown.empty() ? find_spot(off, on, config) : find_blinking_spot(unknown, config);
      if (spot)
        read.spot = *spot;
      else
        read.refused = spot.error().reason;
    }
    out.read.push_back(read);
    if (!read.spot) continue;
    EmitterSample sample;
    hal::JointVector q;
    for (int j = 0; j < hal::kArmJoints; ++j) q[j] = s.joints_rad[static_cast<std::size_t>(j)];
    sample.X_BH = hal::hand_pose(robot, q);
    sample.pixel = undistorted(read.spot->pixel, out.camera, file->k1);
    sample.covariance = read.spot->covariance;
    sample.depth_m = s.depth_m;
    if (!s.depth.empty()) {
      const auto depth = read_depth(folder / s.depth, *file, *read.spot);
      if (!depth) return tl::unexpected(depth.error());
      sample.depth_m = *depth;
    }
    out.samples.push_back(sample);
    out.joints_rad.push_back(q);
    out.index.push_back(static_cast<int>(i));
  }
  return out;
}

SampleWriter::SampleWriter(std::filesystem::path folder, const hal::CameraIntrinsics& camera,
                           std::string date)
    : folder_(std::move(folder)) {
  file_.date = std::move(date);
  file_.width = camera.width, file_.height = camera.height;
  file_.fx = camera.fx, file_.fy = camera.fy, file_.cx = camera.cx, file_.cy = camera.cy;
}

hal::Result<> SampleWriter::add(const hal::JointVector& q_rad,
                                const std::vector<hal::InfraredFrame>& blinking,
                                const std::optional<hal::DepthFrame>& depth) {
  std::error_code failed;
  std::filesystem::create_directories(folder_, failed);
  if (failed) return hal::failure(ErrorCode::BadInput, folder_.string(), failed.message());
  SampleEntry entry;
  entry.joints_rad.assign(q_rad.data(), q_rad.data() + q_rad.size());
  const std::size_t pose = file_.samples.size();
  for (std::size_t i = 0; i < blinking.size(); ++i) {
    entry.images.push_back({fmt::format("pose_{:03}_{:02}.png", pose, i), "unknown"});
    const auto& frame = blinking[i];
    if (auto done =
            write_grey_png(folder_ / entry.images.back().file, frame.width, frame.height, frame.brightness);
        !done)
      return done;
  }
  if (depth) {
    entry.depth = fmt::format("pose_{:03}_depth.png", pose);
    std::vector<std::uint16_t> mm;
    mm.reserve(depth->depth_m.size());
    for (const float z : depth->depth_m)
      mm.push_back(z > 0.0f && z < 60.0f ? static_cast<std::uint16_t>(std::lround(1000.0f * z))
                                         : std::uint16_t{0});
    if (auto done =
            write_grey_png(folder_ / entry.depth, depth->intrinsics.width, depth->intrinsics.height, mm);
        !done)
      return done;
  }
  file_.samples.push_back(std::move(entry));
  hal::FieldTable table = hal::table_of(file_);
  const std::filesystem::path path = folder_ / "samples.yaml";
  std::ofstream out(path, std::ios::trunc);
  out << hal::effective_yaml(table, false);
  out.close();
  if (!out) return hal::failure(ErrorCode::BadInput, path.string(), "the file cannot be written");
  return {};
}

}  // namespace colift::perception
