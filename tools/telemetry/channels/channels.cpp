#include "tools/telemetry/channels/channels.hpp"

#include <vector>

#include "tools/telemetry/channels/image_message.hpp"
#include "tools/telemetry/channels/schema_parts.hpp"
#include "tools/telemetry/channels/string_message.hpp"

namespace colift::telemetry {
namespace {

using namespace schema;

// The shapes named foxglove.* are those of Foxglove's published schemas
// (https://docs.foxglove.dev/docs/visualization/message-schemas/introduction); tests/mcap holds them against
// the package @foxglove/schemas.

Json transforms() {
  return object({{"transforms", list(object({{"timestamp", time()},
                                             {"parent_frame_id", text()},
                                             {"child_frame_id", text()},
                                             {"translation", vector3()},
                                             {"rotation", quaternion()}}))}});
}

Json joints() {
  return object(
      {{"timestamp", time()},
       {"joints", list(object({{"name", text()}, {"position", number("rad")}, {"effort", number("N m")}}))}});
}

Json calibration() {
  return object({{"timestamp", time()},
                 {"frame_id", text()},
                 {"width", integer()},
                 {"height", integer()},
                 {"distortion_model", text()},
                 {"D", list(number())},
                 {"K", list(number())},
                 {"R", list(number())},
                 {"P", list(number())}});
}

Json raw_image() {
  return object({{"timestamp", time()},
                 {"frame_id", text()},
                 {"width", integer()},
                 {"height", integer()},
                 {"encoding", text()},
                 {"step", integer()},
                 {"data", bytes()}});
}

Json cloud() {
  return object({{"timestamp", time()},
                 {"frame_id", text()},
                 {"pose", pose()},
                 {"point_stride", integer()},
                 {"fields", list(object({{"name", text()}, {"offset", integer()}, {"type", integer()}}))},
                 {"data", bytes()}});
}

Json scene() {
  const Json arrow = object({{"pose", pose()},
                             {"shaft_length", number()},
                             {"shaft_diameter", number()},
                             {"head_length", number()},
                             {"head_diameter", number()},
                             {"color", colour()}});
  const Json solid = object({{"pose", pose()}, {"size", vector3()}, {"color", colour()}});
  const Json cylinder = object({{"pose", pose()},
                                {"size", vector3()},
                                {"bottom_scale", number()},
                                {"top_scale", number()},
                                {"color", colour()}});
  const Json line = object({{"type", integer("0 strip, 1 loop, 2 list")},
                            {"pose", pose()},
                            {"thickness", number()},
                            {"scale_invariant", boolean()},
                            {"points", list(vector3())},
                            {"color", colour()},
                            {"colors", list(colour())},
                            {"indices", list(integer())}});
  const Json words = object({{"pose", pose()},
                             {"billboard", boolean()},
                             {"font_size", number()},
                             {"scale_invariant", boolean()},
                             {"color", colour()},
                             {"text", text()}});
  const Json entity = object({{"timestamp", time()},
                              {"frame_id", text()},
                              {"id", text()},
                              {"lifetime", duration()},
                              {"frame_locked", boolean()},
                              {"metadata", list(object({{"key", text()}, {"value", text()}}))},
                              {"arrows", list(arrow)},
                              {"cubes", list(solid)},
                              {"spheres", list(solid)},
                              {"cylinders", list(cylinder)},
                              {"lines", list(line)},
                              {"triangles", list(type("object"))},
                              {"texts", list(words)},
                              {"models", list(type("object"))}});
  const Json deletion =
      object({{"timestamp", time()}, {"type", integer("0 the one with the id, 1 all")}, {"id", text()}});
  return object({{"deletions", list(deletion)}, {"entities", list(entity)}});
}

Json log() {
  return object({{"timestamp", time()},
                 {"level", integer("1 debug, 2 info, 3 warning, 4 error, 5 fatal")},
                 {"message", text()},
                 {"name", text()},
                 {"file", text()},
                 {"line", integer()}});
}

Json maybe_point() {
  return {{"type", {"array", "null"}}, {"items", number("m, in world")}};
}

Json body() {
  return object({{"id", integer()},
                 {"partner", boolean()},
                 {"center", maybe_point()},
                 {"min", maybe_point()},
                 {"max", maybe_point()},
                 {"velocity", maybe_point()},
                 {"distance_m", maybe("to the arm or the rest of its path")}});
}

Json separation() {
  return object({{"on", boolean()},
                 {"speed_scale", number("fraction of the planned speed")},
                 {"waits", boolean()},
                 {"may_confirm", boolean()},
                 {"because", text("why the arm is slowed or waits")},
                 {"distance_m", maybe("of the nearest body")},
                 {"hold_distance_m", number("a person nearer than that stops the arm")},
                 {"slow_distance_m", number("a person nearer than that slows it")},
                 {"bodies", list(body())}});
}

Json force() {
  return object({{"on", boolean()},
                 {"felt", list(number("N, on the hand, in world"))},
                 {"sideways_limit_n", maybe("horizontal; null: the empty hand's contact threshold counts")},
                 {"up_limit_n", maybe()},
                 {"down_limit_n", maybe()},
                 {"exceeded", boolean()}});
}

Json status() {
  return object({{"t", number("s since the start of the run")},
                 {"state", text()},
                 {"in_state_s", number()},
                 {"because", text("why it came into this state")},
                 {"waits_for", text()},
                 {"doing", text()},
                 {"done", maybe("progress of the state, 0 to 1")},
                 {"partner", maybe_point()},
                 {"partner_note", text()},
                 {"separation", separation()},
                 {"force", force()}});
}

Json intent() {
  return object({{"t", number("s since the start of the run")},
                 {"motion", {{"type", {"string", "null"}}, {"description", "null: a request to a person"}}},
                 {"in_s", number("it begins this much later, or later still")},
                 {"says", text()}});
}

Json change() {
  return object({{"t", number("s since the start of the run")}, {"state", text()}, {"because", text()}});
}

Json candidate() {
  return object({{"id", integer()},
                 {"kind", text()},
                 {"position", list(number("m"))},
                 {"approach", list(number())},
                 {"closing", list(number())},
                 {"width", number("m")},
                 {"verdict", text("chosen, ok, collision, unreachable, too-wide, unstable, over-limit or "
                                  "near-partner")},
                 {"because", text()},
                 {"stability", maybe()},
                 {"share", maybe("of the load, for the robot")},
                 {"cost", maybe("N^2")}});
}

Json decision() {
  return object({{"t", number("s since the start of the run")},
                 {"chosen", {{"type", {"integer", "null"}}, {"description", "id of the candidate"}}},
                 {"share", maybe()},
                 {"cost", maybe()},
                 {"because", text()},
                 {"share_text", text("shares of the load that are possible, and the predicted one")},
                 {"optimum", list(number("m"))},
                 {"partner", maybe_point()},
                 {"partner_sigma", maybe_point()},
                 {"partner_points", integer()},
                 {"partner_because", text()},
                 {"cog", maybe_point()},
                 {"candidates", list(candidate())}});
}

Json plan() {
  return object({{"t", number("s since the start of the run")},
                 {"transit_s", number()},
                 {"approach_s", number()},
                 {"postures", list(list(number("rad, A1 to A7")))},
                 {"palm", list(list(number("m, path of the palm in world")))}});
}

Json devices() {
  return object({{"devices", list(object({{"name", text()},
                                          {"state", text()},
                                          {"accepted", integer()},
                                          {"rejected", integer()},
                                          {"last_error", text()}}))}});
}

Json timing() {
  return object({{"cycles", integer("of the arm, since the last message")},
                 {"missed", integer()},
                 {"period_ms_max", maybe("longest time between two states, by their own stamps")},
                 {"answer_us_mean", maybe("from a state to its answer, by the machine's clock")},
                 {"answer_us_max", maybe()},
                 {"lost_samples", integer("cycles that this line does not know of")}});
}

Json stages() {
  return object({{"look_ms", object({{"ground", number()},
                                     {"target", number()},
                                     {"surfaces", number()},
                                     {"candidates", number()},
                                     {"total", number()}})},
                 {"decision_ms", number()},
                 {"decision_compute_ms", number()},
                 {"plan_ms", number()},
                 {"grasp_to_decision_s", maybe()}});
}

Json load() {
  return object(
      {{"force", {{"type", {"array", "null"}}, {"items", number("N, on the hand, in world")}}},
       {"torque", {{"type", {"array", "null"}}, {"items", number("N m, about the palm")}}},
       {"load_n", number("weight that the robot carries")},
       {"share", maybe("of the weight as it is known; null while it is not")},
       {"share_predicted", maybe()},
       {"height_m", maybe()},
       {"tilt_deg", maybe()},
       {"slip_m", maybe()},
       {"energy_j", maybe("that the arm may still put into object and people; passivity margin")},
       {"leads",
        {{"type", {"string", "null"}}, {"description", "robot or partner; null: nothing is held"}}}});
}

Json tactile() {
  return object(
      {{"arrays", list(object({{"name", text("F1, F2, F3 or palm")},
                               {"at", integer("ns")},
                               {"force_n", maybe()},
                               {"cells", list(maybe("N/cm2; fingertip: eight rows of three from its "
                                                    "root, palm: rows of 5, 7, 7, 5"))}}))},
       {"palm_touches", boolean()}});
}

Json truth() {
  return object({{"t", number("s since the start of the run")},
                 {"robot_force_z_n", number()},
                 {"partner_force_z_n", number()},
                 {"floor_force_z_n", number()},
                 {"share", maybe()},
                 {"tilt_deg", number()},
                 {"height_m", number()},
                 {"slip_m", number()}});
}

Json frame() {
  return object({{"number", integer("counts the frames of the run from 0")},
                 {"exposed_at", integer("ns; the stamp of its images")},
                 {"width", integer()},
                 {"height", integer()},
                 {"fx", maybe()},
                 {"fy", maybe()},
                 {"cx", maybe()},
                 {"cy", maybe()},
                 {"up", {{"type", {"array", "null"}}, {"items", number("against gravity, in camera")}}}});
}

Json inputs() {
  const Json error = object({{"code", integer()}, {"where", text()}, {"detail", text()}});
  const Json joint_list = list(number());
  const Json arm = object({{"at", integer("ns")},
                           {"q", joint_list},
                           {"q_commanded", joint_list},
                           {"tau", joint_list},
                           {"tau_external", joint_list},
                           {"may_command", boolean()},
                           {"slow", boolean()},
                           {"error", error}});
  const Json hand = object({{"at", integer("ns")},
                            {"finger", joint_list},
                            {"outer", joint_list},
                            {"spread", number()},
                            {"torque", list(maybe())},
                            {"tip_force", list(maybe())},
                            {"palm_force", maybe()},
                            {"tactile", list(type("object"))},
                            {"moving", boolean()},
                            {"held", boolean()},
                            {"slips", boolean()},
                            {"hot", boolean()},
                            {"warning", text()},
                            {"error", error}});
  const Json camera = object({{"frame", integer("number of a frame on /camera/frame")}, {"error", error}});
  return object({{"cycle", integer("counts up from 0; a gap is a loss")},
                 {"clock", list(integer("ns, each time that was read"))},
                 {"arm", list(arm)},
                 {"view", type("object")},
                 {"arm_health", list(object({{"state", integer()}, {"last_error", text()}}))},
                 {"hand", list(hand)},
                 {"camera", list(camera)},
                 {"answers", list(object({{"error", error}}))},
                 {"interrupted", boolean()},
                 {"lower_confirmed", boolean()},
                 {"continue_confirmed", boolean()}});
}

std::vector<ChannelInfo> all() {
  std::vector<ChannelInfo> list;
  const auto add = [&](Topic id, const char* topic, const char* name, Json schema) {
    list.push_back({id, topic, "json", name, "jsonschema", titled(name, std::move(schema)).dump()});
  };
  add(Topic::Transforms, "/tf", "foxglove.FrameTransforms", transforms());
  add(Topic::Joints, "/joint_states", "foxglove.JointStates", joints());
  add(Topic::Calibration, "/camera/calibration", "foxglove.CameraCalibration", calibration());
  add(Topic::Preview, "/camera/preview", "foxglove.RawImage", raw_image());
  add(Topic::Cloud, "/cloud", "foxglove.PointCloud", cloud());
  add(Topic::Scene, "/scene", "foxglove.SceneUpdate", scene());
  add(Topic::Map, "/map", "foxglove.SceneUpdate", scene());
  add(Topic::Bodies, "/bodies", "foxglove.SceneUpdate", scene());
  add(Topic::Log, "/log", "foxglove.Log", log());
  add(Topic::Status, "/task/status", "colift.TaskStatus", status());
  add(Topic::Intent, "/task/intent", "colift.Intent", intent());
  add(Topic::Change, "/task/change", "colift.TaskChange", change());
  add(Topic::Decision, "/decision", "colift.Decision", decision());
  add(Topic::Plan, "/plan", "colift.Plan", plan());
  add(Topic::Devices, "/devices", "colift.DeviceHealth", devices());
  add(Topic::Timing, "/arm/timing", "colift.CycleTiming", timing());
  add(Topic::Stages, "/stages", "colift.StageTiming", stages());
  add(Topic::Load, "/load", "colift.Load", load());
  add(Topic::Tactile, "/hand/tactile", "colift.Tactile", tactile());
  add(Topic::Truth, "/truth", "colift.Truth", truth());
  add(Topic::Tracked, "/tf/tracked", "foxglove.FrameTransforms", transforms());
  // the name and type under which viewers and RViz look for a robot's model
  list.push_back(
      {Topic::Description, "/robot_description", "cdr", kStringType, "ros2msg", string_definition()});
  const auto add_image = [&](Topic id, const char* topic) {
    list.push_back({id, topic, "cdr", kImageType, "ros2msg", image_definition()});
  };
  add_image(Topic::Depth, "/camera/depth");
  add_image(Topic::Colour, "/camera/color");
  add(Topic::Frame, "/camera/frame", "colift.CameraFrame", frame());
  add_image(Topic::MoreDepth, "/more_cameras/depth");
  add(Topic::MoreFrame, "/more_cameras/frame", "colift.CameraFrame", frame());
  add(Topic::Inputs, "/inputs", "colift.CycleInputs", inputs());
  return list;
}

}  // namespace

std::span<const ChannelInfo> channels() {
  static const std::vector<ChannelInfo> list = all();
  return list;
}

}  // namespace colift::telemetry
