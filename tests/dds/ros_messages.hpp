#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tests/dds/fast_peer.hpp"

namespace colift::tests {

// Messages of ROS 2, written from the public .msg files and encoded with Fast CDR: a second opinion on every
// byte.

struct Stamp {
  std::int32_t sec = 0;
  std::uint32_t nanosec = 0;
  [[nodiscard]] double seconds() const { return sec + 1e-9 * nanosec; }
};
struct RosHeader {
  Stamp stamp;
  std::string frame_id;
};
struct RosJointState {
  RosHeader header;
  std::vector<std::string> name;
  std::vector<double> position, velocity, effort;
};
struct RosTransform {
  RosHeader header;
  std::string child_frame_id;
  std::array<double, 3> translation{};
  std::array<double, 4> rotation{};  ///< x, y, z, w
};
struct RosImage {
  RosHeader header;
  std::uint32_t height = 0, width = 0;
  std::string encoding;
  std::uint8_t is_bigendian = 0;
  std::uint32_t step = 0;
  std::vector<std::uint8_t> data;
};
struct RosCameraInfo {
  RosHeader header;
  std::uint32_t height = 0, width = 0;
  std::string distortion_model;
  std::vector<double> d;
  std::array<double, 9> k{}, r{};
  std::array<double, 12> p{};
  std::uint32_t binning_x = 0, binning_y = 0;
  std::array<std::uint32_t, 4> roi{};  ///< x, y, height, width
  bool do_rectify = false;
};
struct RosPointCloud {
  RosHeader header;
  std::uint32_t height = 0, width = 0;
  std::vector<std::string> fields;
  std::uint32_t point_step = 0, row_step = 0;
  std::vector<std::uint8_t> data;
};
struct RosMarker {
  RosHeader header;
  std::string ns;
  std::int32_t id = 0, type = 0, action = 0;
  std::array<double, 7> pose{};
  std::array<double, 3> scale{};
  std::vector<std::array<double, 3>> points;
  std::string text;
};
struct RosTaskStatus {
  RosHeader header;
  std::string state, because;
};
struct RosCandidate {
  std::int32_t id = 0;
  std::string verdict;
  double share = 0.0;
  std::array<double, 3> position{};
};
struct RosDecision {
  RosHeader header;
  bool decided = false;
  std::int32_t chosen = 0;
  double share = 0.0, cost = 0.0;
  std::string because;
  std::array<double, 3> partner{}, cog{};
  std::vector<RosCandidate> candidates;
};
struct RosDecideRequest {
  RosHeader header;
  std::string client;
  std::uint64_t sequence_number = 0;
  RosImage depth;
  RosCameraInfo info;
  std::array<double, 3> partner{};
  double share = 0.0;
};
struct RosDecideReply {
  std::string client;
  std::uint64_t sequence_number = 0;
  bool ok = false;
  std::string error;
  RosDecision decision;
};
struct RosDiagnostic {
  std::uint8_t level = 0;
  std::string name, message;
};
struct RosNode {
  std::string name_space, name;
  std::vector<Bytes> readers, writers;
};

// Each throws where the message is no such one, or has bytes left over.
[[nodiscard]] RosJointState joint_state_of(const Bytes& message);
[[nodiscard]] std::vector<RosTransform> transforms_of(const Bytes& message);
[[nodiscard]] RosImage image_of(const Bytes& message);
[[nodiscard]] RosCameraInfo camera_info_of(const Bytes& message);
[[nodiscard]] RosPointCloud cloud_of(const Bytes& message);
[[nodiscard]] std::vector<RosMarker> markers_of(const Bytes& message);
[[nodiscard]] std::string string_of(const Bytes& message);
[[nodiscard]] RosTaskStatus task_status_of(const Bytes& message);
[[nodiscard]] RosDecision decision_of(const Bytes& message);
[[nodiscard]] RosDecideReply decide_reply_of(const Bytes& message);
[[nodiscard]] std::vector<RosDiagnostic> diagnostics_of(const Bytes& message);
/// Nodes of one participant.
[[nodiscard]] std::vector<RosNode> nodes_of(const Bytes& message);

[[nodiscard]] Bytes bytes_of(const RosImage& image);
[[nodiscard]] Bytes bytes_of(const RosCameraInfo& info);
[[nodiscard]] Bytes bytes_of(const RosDecideRequest& request);
[[nodiscard]] Bytes bytes_of(const RosJointState& joints);
[[nodiscard]] Bytes clock_bytes(Stamp clock);

[[nodiscard]] Stamp system_stamp(double later_s = 0.0);

}  // namespace colift::tests
