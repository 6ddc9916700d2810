#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/calibrate/calibrate.hpp"

namespace colift::tools {
namespace {

using nlohmann::ordered_json;

ordered_json numbers(const hal::Vec3& v) {
  return ordered_json::array({v.x(), v.y(), v.z()});
}
ordered_json finite(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
}

}  // namespace

std::string calibration_document(const CalibrationView& view) {
  ordered_json j = {
      {"schema", "colift.calibrate/1"},
      {"accepted", view.refused_kind.empty()},
      {"because", view.reason},
      {"refused", view.refused_kind.empty() ? ordered_json(nullptr) : ordered_json(view.refused_kind)},
      {"method", view.method},
      {"date", view.date}};
  j["camera"] = nullptr;
  if (const auto* c = view.solved) {
    const hal::Pose X = c->model.X_BC();
    const Eigen::Quaterniond q(X.linear());
    j["camera"] = {{"position", numbers(X.translation())},
                   {"quaternion", {q.x(), q.y(), q.z(), q.w()}},
                   {"fx", c->model.camera.fx},
                   {"fy", c->model.camera.fy},
                   {"cx", c->model.camera.cx},
                   {"cy", c->model.camera.cy}};
    j["emitter"] = numbers(c->model.p_H);
    j["depth"] = {{"scale", c->model.depth_scale}, {"offset_m", c->model.depth_offset_m}};
    j["quality"] = {{"inliers", c->inliers},
                    {"poses", c->samples.size()},
                    {"rms_px", c->rms_px},
                    {"held_out_px", c->held_out_px},
                    {"error_m", finite(c->error_m)},
                    {"worst_error_m", finite(c->worst_error_m)},
                    {"emitter_sigma_m", finite(c->emitter_sigma_m)},
                    {"condition", finite(c->condition)},
                    {"diversity",
                     {{"score", c->diversity.score},
                      {"rotation_deg", numbers(c->diversity.rotation_deg)},
                      {"position_m", numbers(c->diversity.position_m)}}}};
    j["remarks"] = c->remarks;
  }
  j["poses"] = ordered_json::array();
  std::size_t used = 0;
  for (const auto& read : view.set->read) {
    ordered_json pose = {{"index", read.index}};
    if (!read.spot) {
      pose["refused"] = read.refused;
    } else {
      pose["pixel"] = {read.spot->pixel.x(), read.spot->pixel.y()};
      if (view.solved && used < view.solved->samples.size()) {
        const auto& v = view.solved->samples[used];
        pose["residual_px"] = {finite(v.residual_px.x()), finite(v.residual_px.y())};
        pose["held_out_px"] = finite(v.held_out_px);
        pose["shift_m"] = finite(v.shift_m);
        pose["inlier"] = v.inlier;
      }
      ++used;
    }
    j["poses"].push_back(std::move(pose));
  }
  j["next_pose"] = nullptr;
  if (view.next) {
    std::vector<double> q(view.next->q_rad.data(), view.next->q_rad.data() + view.next->q_rad.size());
    j["next_pose"] = {
        {"joints_rad", q}, {"palm", numbers(view.next->X_BH.translation())}, {"error_m", view.next->error_m}};
  }
  if (view.true_error_m) j["truth"] = {{"error_m", *view.true_error_m}};
  return j.dump();
}

std::string calibration_text(const CalibrationView& view) {
  std::string out;
  const auto line = [&](const std::string& text) { out += text + "\n"; };
  line(fmt::format("{}: {}", view.refused_kind.empty() ? "calibrated" : "refused", view.reason));
  if (const auto* c = view.solved) {
    const hal::Pose X = c->model.X_BC();
    const Eigen::Quaterniond q(X.linear());
    line(fmt::format("camera    x {:.4f}  y {:.4f}  z {:.4f} m, quaternion {:.5f} {:.5f} {:.5f} {:.5f}",
                     X.translation().x(), X.translation().y(), X.translation().z(), q.x(), q.y(), q.z(),
                     q.w()));
    line(fmt::format("emitter   ({:.1f}, {:.1f}, {:.1f}) mm in the palm, +- {:.1f} mm",
                     1e3 * c->model.p_H.x(), 1e3 * c->model.p_H.y(), 1e3 * c->model.p_H.z(),
                     1e3 * c->emitter_sigma_m));
    line(fmt::format("poses     {} of {} agree, residual {:.2f} px, each predicted by the others {:.2f} px",
                     c->inliers, c->samples.size(), c->rms_px, c->held_out_px));
    line(fmt::format("error     {:.1f} mm predicted over the workspace, {:.1f} mm at its worst corner",
                     1e3 * c->error_m, 1e3 * c->worst_error_m));
    line(fmt::format(
        "diversity {:.2f}: rotation {:.0f}, {:.0f}, {:.0f} deg, position {:.0f}, {:.0f}, {:.0f} mm",
        c->diversity.score, c->diversity.rotation_deg[0], c->diversity.rotation_deg[1],
        c->diversity.rotation_deg[2], 1e3 * c->diversity.position_m[0], 1e3 * c->diversity.position_m[1],
        1e3 * c->diversity.position_m[2]));
    for (const std::string& remark : c->remarks) line("remark    " + remark);
  }
  for (const auto& read : view.set->read)
    if (!read.spot) line(fmt::format("left out  pose {}: {}", read.index, read.refused));
  if (view.true_error_m) line(fmt::format("truth     {:.1f} mm off", 1e3 * *view.true_error_m));
  if (view.next) {
    std::string joints;
    for (int i = 0; i < hal::kArmJoints; ++i) joints += fmt::format(" {:.3f}", view.next->q_rad[i]);
    line(fmt::format("next      the pose that would help most: A1 to A7{} rad (error then {:.1f} mm)", joints,
                     1e3 * view.next->error_m));
  }
  return out;
}

}  // namespace colift::tools
