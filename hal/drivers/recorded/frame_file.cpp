#include "hal/drivers/recorded/frame_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>

#include "hal/drivers/recorded/camera_file.hpp"
#include "hal/drivers/recorded/cloud_files/pcd.hpp"
#include "hal/drivers/recorded/cloud_files/ply.hpp"
#include "hal/drivers/recorded/depth_png.hpp"
#include "hal/drivers/recorded/file_bytes.hpp"
#include "hal/drivers/recorded/pinhole_fit.hpp"
#include "hal/drivers/recorded/virtual_camera.hpp"

namespace colift::hal {
namespace {

namespace fs = std::filesystem;

constexpr double kMinAgreeing = 0.95;  // points in their own pixel, for a cloud to be one camera's image
constexpr float kFarthest_m = 100.0f;  // median depth beyond which the unit cannot be metres

enum class Kind { Png, Pcd, Ply };

const char* words(Kind kind) {
  switch (kind) {
    case Kind::Png:
      return "a PNG image";
    case Kind::Pcd:
      return "a PCD point cloud";
    case Kind::Ply:
      return "a PLY file";
  }
  return "";
}

std::optional<Kind> kind_of_name(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  if (extension == ".png") return Kind::Png;
  if (extension == ".pcd") return Kind::Pcd;
  if (extension == ".ply") return Kind::Ply;
  return std::nullopt;
}

std::optional<Kind> kind_of_content(Bytes bytes) {
  const std::string_view text = as_text(bytes);
  if (text.starts_with("\x89PNG")) return Kind::Png;
  if (text.starts_with("ply\n") || text.starts_with("ply\r")) return Kind::Ply;
  LineScanner lines(bytes.first(std::min<std::size_t>(bytes.size(), 4096)));
  while (const auto line = lines.next()) {
    std::string_view rest = *line;
    const std::string_view key = next_word(rest);
    if (key.starts_with("#") || key.empty()) continue;
    constexpr std::array<std::string_view, 10> kFirst = {
        "VERSION", "FIELDS", "COLUMNS", "SIZE", "TYPE", "COUNT", "WIDTH", "VIEWPOINT", "HEIGHT", "POINTS"};
    return std::find(kFirst.begin(), kFirst.end(), key) != kFirst.end() ? std::optional(Kind::Pcd)
                                                                        : std::nullopt;
  }
  return std::nullopt;
}

// What else people hand over by mistake.
std::string guess(Bytes bytes) {
  const std::string_view text = as_text(bytes);
  const std::array<std::pair<std::string_view, const char*>, 6> known = {{{"\xff\xd8\xff", "a JPEG image"},
                                                                          {"%PDF", "a PDF document"},
                                                                          {"PK\x03\x04", "a ZIP archive"},
                                                                          {"\x1f\x8b", "a gzip archive"},
                                                                          {"P5", "a PGM image"},
                                                                          {"{", "JSON"}}};
  for (const auto& [start, what] : known) {
    if (text.starts_with(start)) return what;
  }
  return "a file that begins with " + shown(text.substr(0, 16));
}

Result<RecordedFrame> check_range(RecordedFrame out, const std::string& name, const char* unit_hint) {
  std::vector<float> seen;
  for (const float z : out.frame.depth_m) {
    if (!std::isnan(z)) seen.push_back(z);
  }
  if (seen.empty()) {
    return failure(ErrorCode::BadInput, name,
                   fmt::format("none of the {} points lies before the camera", out.points));
  }
  const auto middle = seen.begin() + static_cast<std::ptrdiff_t>(seen.size() / 2);
  std::nth_element(seen.begin(), middle, seen.end());
  if (*middle > kFarthest_m) {
    return failure(ErrorCode::BadInput, name,
                   fmt::format("the median depth is {:.0f} m; a depth camera sees less than {:.0f} m: {}",
                               *middle, kFarthest_m, unit_hint));
  }
  return out;
}

Result<RecordedFrame> read_png(Bytes bytes, const fs::path& file,
                               const std::optional<fs::path>& camera_json) {
  const std::string name = file.string();
  fs::path camera_path;
  if (camera_json) {
    camera_path = *camera_json;
  } else {
    camera_path = file.parent_path() / "camera.json";
    std::error_code error;
    if (!fs::exists(camera_path, error)) {
      return failure(ErrorCode::BadInput, name,
                     "a depth image needs its camera: there is no camera.json beside it and none was named");
    }
  }
  const auto camera_bytes = load_file(camera_path);
  if (!camera_bytes) return tl::unexpected(camera_bytes.error());
  const auto camera = parse_camera_json(*camera_bytes, camera_path.string());
  if (!camera) return tl::unexpected(camera.error());
  auto image = parse_depth_png(bytes, name, camera->depth_scale_m);
  if (!image) return tl::unexpected(image.error());
  if (camera->width.value_or(image->width) != image->width ||
      camera->height.value_or(image->height) != image->height) {
    return failure(ErrorCode::BadInput, name + ": header",
                   fmt::format("the image has {} x {} pixels, but {} is for {} x {}", image->width,
                               image->height, camera_path.string(), camera->width.value_or(image->width),
                               camera->height.value_or(image->height)));
  }
  if (camera->cx >= image->width || camera->cy >= image->height) {
    return failure(ErrorCode::BadInput, camera_path.string() + ": cx, cy",
                   fmt::format("the centre {}, {} lies outside the image of {} x {} pixels", camera->cx,
                               camera->cy, image->width, image->height));
  }

  RecordedFrame out;
  out.frame.intrinsics = camera->intrinsics(image->width, image->height);
  out.frame.depth_m = std::move(image->depth_m);
  if (!camera->lens.none()) {
    if (!camera->lens.unique_within(out.frame.intrinsics))
      return failure(
          ErrorCode::BadInput, camera_path.string() + ": distortion",
          "folds the image over itself within its rim; expected the coefficients of this camera, in the "
          "order k1 k2 p1 p2 k3 k4 k5 k6");
    out.frame.depth_m = rectify(out.frame.depth_m, out.frame.intrinsics, camera->lens);
  }
  out.points = out.frame.depth_m.size();
  out.valid_points = static_cast<std::size_t>(std::count_if(
      out.frame.depth_m.begin(), out.frame.depth_m.end(), [](float z) { return !std::isnan(z); }));
  if (out.valid_points == 0) {
    return failure(ErrorCode::BadInput, name,
                   fmt::format("no finite point: all {} pixels are 0 (no data)", out.points));
  }
  out.note = fmt::format("depth image of {} x {} pixels with the camera of {}", image->width, image->height,
                         camera_path.string());
  if (!camera->lens.none()) out.note += ", its lens distortion taken out";
  return check_range(std::move(out), name, "depth_scale_m should be metres per unit");
}

RecordedFrame frame_of_image(const PointFile& file, const PinholeFit& fit) {
  RecordedFrame out;
  out.frame.intrinsics = fit.intrinsics;
  out.X_FC = fit.X_FC;
  out.frame.rgb = file.rgb;
  out.frame.depth_m.resize(file.size());
  // the row of the pose that gives depth; for the identity it leaves z as it is, to the bit
  const Pose X_CF = fit.X_FC.inverse();
  const bool own = fit.X_FC.matrix().isIdentity(0.0);
  for (std::size_t i = 0; i < file.size(); ++i) {
    float depth_m = std::numeric_limits<float>::quiet_NaN();
    if (file.seen(i)) {
      depth_m = own ? file.z[i] : static_cast<float>((X_CF * Vec3(file.x[i], file.y[i], file.z[i])).z());
    }
    out.frame.depth_m[i] = depth_m > 0.0f ? depth_m : std::numeric_limits<float>::quiet_NaN();
  }
  return out;
}

struct NamedFit {
  PinholeFit fit;
  const char* words;
};

// As given, then without the pose that the file states, then from any pose.
std::optional<NamedFit> find_camera(const PointFile& file) {
  if (const auto fit = fit_pinhole(file, Pose::Identity()); fit && fit->agreeing >= kMinAgreeing) {
    return NamedFit{*fit, "in the camera's own frame"};
  }
  if (!file.viewpoint.matrix().isIdentity(1e-9)) {
    if (const auto fit = fit_pinhole(file, file.viewpoint); fit && fit->agreeing >= kMinAgreeing) {
      return NamedFit{*fit, "seen from the file's VIEWPOINT"};
    }
  }
  if (const auto fit = fit_projection(file); fit && fit->agreeing >= kMinAgreeing) {
    return NamedFit{*fit, "in another frame, in which the camera's pose was found from the points"};
  }
  return std::nullopt;
}

}  // namespace

Result<RecordedFrame> frame_from_points(const PointFile& file, const std::string& name) {
  std::size_t valid = 0;
  for (std::size_t i = 0; i < file.size(); ++i) valid += file.seen(i) ? 1 : 0;
  if (valid == 0) {
    return failure(ErrorCode::BadInput, name,
                   fmt::format("no finite point: all {} points are NaN or (0, 0, 0)", file.size()));
  }
  RecordedFrame out;
  if (const auto camera = file.organised() ? find_camera(file) : std::nullopt) {
    out = frame_of_image(file, camera->fit);
    const CameraIntrinsics& k = camera->fit.intrinsics;
    out.note = fmt::format("organised cloud of {} x {} points {}: fx {:.2f}, fy {:.2f}, cx {:.2f}, cy {:.2f}",
                           k.width, k.height, camera->words, k.fx, k.fy, k.cx, k.cy);
  } else {
    auto view = view_points(file, name);
    if (!view) return tl::unexpected(view.error());
    out.frame = std::move(view->frame);
    out.X_FC = view->X_FC;
    out.organised = false;
    out.note = fmt::format("{} points without {}image order; {}; {:.1f} % of them can be seen", valid,
                           file.organised() ? "a camera's " : "", view->note, 100.0 * view->visible);
  }
  out.points = file.size();
  out.valid_points = valid;
  return check_range(std::move(out), name, "the file should be in metres, perhaps it is in millimetres");
}

Result<RecordedFrame> read_frame(const fs::path& file, const std::optional<fs::path>& camera_json) {
  const auto bytes = load_file(file);
  if (!bytes) return tl::unexpected(bytes.error());
  const std::string name = file.string();
  const auto by_name = kind_of_name(file), by_content = kind_of_content(*bytes);
  if (by_name && by_content && *by_name != *by_content) {
    return failure(ErrorCode::BadInput, name + ": byte 0",
                   fmt::format("this is {}, but its name ends in {}; expected {}, or the right extension",
                               words(*by_content), file.extension().string(), words(*by_name)));
  }
  if (!by_content) {
    // a damaged PCD header still begins with text that its parser can point at
    if (by_name == Kind::Pcd && as_text(*bytes).starts_with("#")) {
      return parse_pcd(*bytes, name).and_then([&](const PointFile& points) {
        return frame_from_points(points, name);
      });
    }
    return failure(ErrorCode::BadInput, name + ": byte 0",
                   fmt::format("found {}; expected {}", guess(*bytes),
                               by_name ? words(*by_name) : "a 16-bit depth PNG, a PCD or a PLY file"));
  }
  if (*by_content == Kind::Png) return read_png(*bytes, file, camera_json);
  const auto points = *by_content == Kind::Pcd ? parse_pcd(*bytes, name) : parse_ply(*bytes, name);
  if (!points) return tl::unexpected(points.error());
  auto out = frame_from_points(*points, name);
  if (out && !by_name) out->note = fmt::format("{} by its content; {}", words(*by_content), out->note);
  return out;
}

}  // namespace colift::hal
