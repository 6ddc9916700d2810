#include "tools/bring_up/hal_camera_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "hal/health_text.hpp"
#include "hal/types/units.hpp"
#include "perception/organised_cloud.hpp"
#include "tools/visualization/scene/scene_picture.hpp"

namespace colift::tools {
namespace {

/// How far the camera looks down, and leans to its right (deg).
std::pair<double, double> attitude_deg(const hal::Vec3& up_C) {
  return {hal::rad_to_deg(std::asin(std::clamp(-up_C.z(), -1.0, 1.0))),
          hal::rad_to_deg(std::atan2(up_C.x(), -up_C.y()))};
}

std::string hangs(const CameraView& v) {
  if (!v.up_C) return "unknown (kinect: {motor: true} reads the accelerometer of the first model)";
  const auto [down, lean] = attitude_deg(*v.up_C);
  return fmt::format("looks {:.1f} deg down, leans {:.1f} deg to the right{}", down, lean,
                     v.report.tilt_deg ? fmt::format(", foot at {:.0f} deg", *v.report.tilt_deg) : "");
}

}  // namespace

void look_at_frame(const hal::DepthFrame& frame, CameraView& view) {
  view.up_C = frame.up_C;
  std::vector<float> seen;
  seen.reserve(frame.depth_m.size() / 4);
  for (std::size_t i = 0; i < frame.depth_m.size(); i += 4)
    if (frame.depth_m[i] > 0.0f) seen.push_back(frame.depth_m[i]);
  view.near_m = view.middle_m = view.far_m = NAN;
  if (seen.empty()) return;
  const auto part = [&](double p) {
    const auto at = static_cast<std::ptrdiff_t>(p * static_cast<double>(seen.size() - 1));
    std::nth_element(seen.begin(), seen.begin() + at, seen.end());
    return static_cast<double>(seen[static_cast<std::size_t>(at)]);
  };
  view.near_m = part(0.02);
  view.middle_m = part(0.5);
  view.far_m = part(0.98);
}

std::string camera_line(const CameraView& v) {
  const hal::KinectReport& r = v.report;
  if (v.health.state == hal::DeviceHealth::State::Lost)
    return fmt::format("{:8.1f} s  lost: {}", v.at_s, v.health.last_error);
  return fmt::format(
      "{:8.1f} s  {:.1f} Hz, {} frames, {} missed, {} suspect, {:.0f} % seen, {:.2f} to {:.2f} m", v.at_s,
      r.rate_hz, r.frames, r.missed, r.suspect, 1e2 * r.seen, v.near_m, v.far_m);
}

std::string camera_screen(const CameraView& v) {
  const hal::KinectReport& r = v.report;
  std::string t;
  t += fmt::format("Kinect     {}{}, {}\n", v.source, r.serial.empty() ? "" : ", serial " + r.serial,
                   to_string(v.health.state));
  t += fmt::format("process    {}, started {} time{}, killed {}\n",
                   r.pid > 0 ? fmt::format("pid {}", r.pid) : "none", r.starts, r.starts == 1 ? "" : "s",
                   r.kills);
  t += fmt::format(
      "frames     {} at {:.1f} Hz; {} missed, {} suspect ({} packets lost), {} old, {} broken; late by "
      "{:.1f} ms\n",
      r.frames, r.rate_hz, r.missed, r.suspect, r.lost_packets, r.old, r.broken, r.late_ms);
  t += fmt::format("depth      {:.1f} % of the pixels: {:.2f} m, {:.2f} m in the middle, up to {:.2f} m\n",
                   1e2 * r.seen, v.near_m, v.middle_m, v.far_m);
  t += fmt::format("mounting   {}\n", hangs(v));
  t += fmt::format("depth from {}: emitter {:.3f} cm, reference {:.1f} cm, pixel {:.4f} cm, shift {:.0f}\n",
                   r.own_constants ? "the device's own constants" : "nominal constants",
                   r.constants.emitter_cm, r.constants.reference_cm, r.constants.pixel_cm, r.constants.shift);
  t += fmt::format("infrared   {}; motor {}\n", r.infrared ? "yes" : "no", r.motor ? "open" : "not open");
  if (!v.health.last_error.empty()) t += fmt::format("last       {}\n", v.health.last_error);
  if (!r.last_words.empty()) t += fmt::format("library    {}\n", r.last_words);
  return t;
}

std::string camera_document(const std::string& verb, const CameraView& v, const std::string& end,
                            const std::string& reason) {
  using Json = nlohmann::ordered_json;
  const hal::KinectReport& r = v.report;
  // before the first frame nothing of it is known
  const auto number = [&](double x) { return r.frames > 0 && std::isfinite(x) ? Json(x) : Json(nullptr); };
  Json j = {{"schema", "colift.hal.camera/1"},
            {"verb", verb},
            {"end", end},
            {"because", reason},
            {"source", v.source},
            {"state", to_string(v.health.state)},
            {"serial", r.serial},
            {"process", {{"pid", r.pid}, {"starts", r.starts}, {"kills", r.kills}}},
            {"frames",
             {{"handed_out", r.frames},
              {"rate_hz", number(r.rate_hz)},
              {"missed", r.missed},
              {"suspect", r.suspect},
              {"lost_packets", r.lost_packets},
              {"old", r.old},
              {"broken", r.broken},
              {"late_ms", number(r.late_ms)}}},
            {"seen", number(r.seen)},
            {"depth_m", {number(v.near_m), number(v.middle_m), number(v.far_m)}},
            {"infrared", r.infrared},
            {"motor", r.motor},
            {"constants",
             {{"own", r.own_constants},
              {"emitter_cm", r.constants.emitter_cm},
              {"reference_cm", r.constants.reference_cm},
              {"pixel_cm", r.constants.pixel_cm},
              {"shift", r.constants.shift}}},
            {"last_error", v.health.last_error},
            {"library", r.last_words}};
  if (v.up_C) {
    const auto [down, lean] = attitude_deg(*v.up_C);
    j["up"] = {v.up_C->x(), v.up_C->y(), v.up_C->z()};
    j["looks_down_deg"] = down;
    j["leans_deg"] = lean;
  }
  if (r.tilt_deg) j["foot_deg"] = *r.tilt_deg;
  return j.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string camera_advice(hal::ErrorCode code, const std::string& source) {
  if (source.starts_with("emulated"))
    return "is the emulator there? colift emulate camera --live prints the address that belongs behind "
           "\"emulated:\"";
  if (source.starts_with("fakenect"))
    return "a recording is a folder with INDEX.txt, as fakenect-record makes it";
  switch (code) {
    case hal::ErrorCode::BadConfig:
      return "look at kinect: {...} of the file behind --robot, and at --source";
    case hal::ErrorCode::LinkLost:
      return "its own 12 V supply plugged in, and USB 2 or 3 of the machine itself, without hub? then: "
             "colift doctor";
    default:
      return "colift doctor names permissions and the webcam driver; another program may have it: "
             "fuser -v /dev/bus/usb/*/*";
  }
}

hal::Result<> write_camera_picture(const std::filesystem::path& png, const hal::DepthFrame& frame,
                                   const CameraView& view) {
  const auto cloud = perception::deproject(frame, hal::Pose::Identity());
  picture::ScenePicture what;
  what.cloud = &cloud;
  what.title = "Kinect";
  what.reason = fmt::format("{:.1f} % of the pixels have depth, {:.2f} to {:.2f} m. The camera {}.",
                            1e2 * view.report.seen, view.near_m, view.far_m, hangs(view));
  what.figures = {{"source", view.source},
                  {"rate", fmt::format("{:.1f} Hz", view.report.rate_hz)},
                  {"exposed", fmt::format("{:.3f} s", hal::seconds(frame.exposed_at))}};
  return picture::write_scene_picture(png, what);
}

}  // namespace colift::tools
