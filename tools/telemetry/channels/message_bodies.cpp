// Everybody near the arm as Foxglove's entities.

#include <fmt/format.h>

#include "tools/telemetry/channels/scene_parts.hpp"

namespace colift::telemetry {
namespace {

constexpr double kAhead_s = 0.5;        // length of the velocity's arrow
constexpr double kMinSpeed_m_s = 0.05;  // slower is noise

Colour colour_of(const control::SeparationStatus::Body& body, const control::SeparationStatus& all) {
  if (body.partner) return {0.8, 0.47, 0.65};
  if (!body.distance_m || *body.distance_m > all.slow_distance_m) return {0.34, 0.71, 0.91};
  return *body.distance_m > all.hold_distance_m ? Colour{0.9, 0.62, 0.0} : Colour{0.84, 0.2, 0.0};
}

std::string words_of(const control::SeparationStatus::Body& body) {
  const std::string who = body.partner ? "partner" : fmt::format("body {}", body.id);
  return body.distance_m ? fmt::format("{}, {:.2f} m", who, *body.distance_m) : who;
}

}  // namespace

std::string bodies_message(hal::Timestamp at, const control::SeparationStatus& separation) {
  Entities out(at);
  for (const control::SeparationStatus::Body& body : separation.bodies) {
    if (body.box.isEmpty()) continue;
    Colour colour = colour_of(body, separation);
    const std::string words = words_of(body);
    Json& entity = out.add(fmt::format("body {}", body.id), Json::array({pair_json("label", words)}));
    const double speed = body.velocity_m_s.norm();
    if (speed > kMinSpeed_m_s) {
      const auto [u, v] = hal::tangents(body.velocity_m_s / speed);
      Eigen::Matrix3d axes;
      axes << body.velocity_m_s / speed, u, v;
      entity["arrows"].push_back(arrow_json(pose_of(body.center_W, axes), kAhead_s * speed, 0.02, colour));
    }
    entity["texts"].push_back(
        {{"pose", pose_json(pose_of({body.center_W.x(), body.center_W.y(), body.box.max().z() + 0.1}))},
         {"billboard", true},
         {"font_size", 14.0},
         {"scale_invariant", true},
         {"color", colour_json(colour)},
         {"text", words}});
    colour.a = 0.2;
    entity["cubes"].push_back(
        solid_json(pose_of(hal::Vec3(body.box.center())), hal::Vec3(body.box.sizes()), colour));
  }
  return dumped(out.take());
}

}  // namespace colift::telemetry
