#include "hal/drivers/kuka_fri/wire/fri_codec.hpp"

#include <bit>
#include <cmath>
#include <type_traits>

#include "hal/drivers/kuka_fri/wire/fri_layout.hpp"

namespace colift::hal {
namespace {

// one layout, walked by a reader and by a writer: both see the same offsets

class Reader {
 public:
  explicit Reader(const std::byte* bytes) : bytes_(bytes) {}

  void operator()(std::size_t at, std::uint16_t& v) {
    v = static_cast<std::uint16_t>(byte(at) | byte(at + 1) << 8);
  }
  void operator()(std::size_t at, std::uint32_t& v) {
    v = byte(at) | byte(at + 1) << 8 | byte(at + 2) << 16 | byte(at + 3) << 24;
  }
  void operator()(std::size_t at, std::int32_t& v) {
    std::uint32_t u = 0;
    (*this)(at, u);
    v = std::bit_cast<std::int32_t>(u);
  }
  void operator()(std::size_t at, float& v) {
    std::uint32_t u = 0;
    (*this)(at, u);
    v = std::bit_cast<float>(u);
  }
  template <class E>
  requires std::is_enum_v<E>
  void operator()(std::size_t at, E& v) {
    std::uint16_t u = 0;
    (*this)(at, u);
    v = static_cast<E>(u);
  }
  template <class T, std::size_t n>
  void operator()(std::size_t at, std::array<T, n>& v) {
    for (std::size_t i = 0; i < n; ++i) (*this)(at + i * sizeof(T), v[i]);
  }

 private:
  [[nodiscard]] std::uint32_t byte(std::size_t at) const {
    return std::to_integer<std::uint32_t>(bytes_[at]);
  }
  const std::byte* bytes_;
};

class Writer {
 public:
  explicit Writer(std::byte* bytes) : bytes_(bytes) {}

  void operator()(std::size_t at, const std::uint16_t& v) {
    bytes_[at] = static_cast<std::byte>(v & 0xFF);
    bytes_[at + 1] = static_cast<std::byte>(v >> 8);
  }
  void operator()(std::size_t at, const std::uint32_t& v) {
    for (std::size_t i = 0; i < 4; ++i) bytes_[at + i] = static_cast<std::byte>(v >> (8 * i) & 0xFF);
  }
  void operator()(std::size_t at, const std::int32_t& v) { (*this)(at, std::bit_cast<std::uint32_t>(v)); }
  void operator()(std::size_t at, const float& v) { (*this)(at, std::bit_cast<std::uint32_t>(v)); }
  template <class E>
  requires std::is_enum_v<E>
  void operator()(std::size_t at, const E& v) { (*this)(at, static_cast<std::uint16_t>(v)); }
  template <class T, std::size_t n>
  void operator()(std::size_t at, const std::array<T, n>& v) {
    for (std::size_t i = 0; i < n; ++i) (*this)(at + i * sizeof(T), v[i]);
  }

 private:
  std::byte* bytes_;
};

// NaN fails every comparison and is caught by each of these
template <std::size_t n>
bool within(const std::array<float, n>& v, float low, float high) {
  bool good = true;
  for (const float x : v) good &= x >= low && x <= high;
  return good;
}

bool within(float x, float low, float high) {
  return x >= low && x <= high;
}

template <std::size_t n>
bool finite(const std::array<float, n>& v) {
  bool good = true;
  for (const float x : v) good &= (std::bit_cast<std::uint32_t>(x) & 0x7F800000u) != 0x7F800000u;
  return good;
}

bool finite(float x) {
  return std::isfinite(x);
}

// the stops are at 170 and 120 deg; what a sensor tells beyond them and 0.2 rad is not a joint's position
constexpr FriJoints kJointEnd_rad{3.17f, 2.30f, 3.17f, 2.30f, 3.17f, 2.30f, 3.17f};

bool joints_possible(const FriJoints& q) {
  bool good = true;
  for (std::size_t i = 0; i < q.size(); ++i) good &= std::abs(q[i]) <= kJointEnd_rad[i];
  return good;
}

bool frame_possible(const FriFrame& f) {
  bool good = true;
  for (std::size_t i = 0; i < f.size(); ++i) good &= std::abs(f[i]) <= (i % 4 == 3 ? 10.0f : 1.01f);
  return good;
}

}  // namespace

std::string_view to_string(FriRefusal refusal) noexcept {
  switch (refusal) {
    case FriRefusal::None:
      return "none";
    case FriRefusal::Size:
      return "wrong number of bytes";
    case FriRefusal::HeaderId:
      return "datagram id of another protocol or version";
    case FriRefusal::HeaderSize:
      return "size in the header is wrong";
    case FriRefusal::NotFinite:
      return "a number is not finite";
    case FriRefusal::NotFiniteKrl:
      return "a real variable of the KRL program is not finite";
    case FriRefusal::NotFiniteLink:
      return "time stamp, sample time or statistics of the link are not finite";
    case FriRefusal::NotFiniteTemperature:
      return "a drive's temperature is not finite";
    case FriRefusal::NotFiniteJoint:
      return "a joint position is not finite";
    case FriRefusal::NotFiniteFrame:
      return "a frame is not finite";
    case FriRefusal::NotFiniteTorque:
      return "a joint torque or the wrench is not finite";
    case FriRefusal::NotFiniteModel:
      return "Jacobian, mass matrix or gravity is not finite";
    case FriRefusal::State:
      return "no such state of the interface";
    case FriRefusal::Quality:
      return "no such quality";
    case FriRefusal::Control:
      return "no such controller";
    case FriRefusal::SampleTime:
      return "sample time is not 0 to 1 s";
    case FriRefusal::SafetyLimits:
      return "safety limits are not 0 to 1";
    case FriRefusal::Statistics:
      return "statistics of the link cannot be";
    case FriRefusal::Temperature:
      return "a drive's temperature cannot be";
    case FriRefusal::JointPosition:
      return "a joint position is beyond its stop";
    case FriRefusal::CartesianPose:
      return "a frame is no pose of the arm";
    case FriRefusal::JointTorque:
      return "a joint torque is beyond the range of the arm's sensors";
    case FriRefusal::Wrench:
      return "a wrench is beyond the range of the arm's sensors";
    case FriRefusal::Jacobian:
      return "the Jacobian cannot be this arm's";
    case FriRefusal::MassMatrix:
      return "mass matrix or gravity cannot be this arm's";
    case FriRefusal::Flags:
      return "a flag that FRI does not have";
    case FriRefusal::Stiffness:
      return "a stiffness is out of range";
    case FriRefusal::Damping:
      return "a damping is out of range";
  }
  return "unknown";
}

FriRefusal implausible(const FriMeasurement& m) noexcept {
  using enum FriRefusal;
  // a number that is none says that the sender is not sound, also where this driver does not read it
  if (!finite(m.krl.real)) return NotFiniteKrl;
  if (!finite(m.timestamp_s) || !finite(m.measurement_period_s) || !finite(m.command_period_s) ||
      !finite(m.safety_limits) || !finite(m.answer_rate) || !finite(m.latency_s) || !finite(m.jitter_s) ||
      !finite(m.miss_rate))
    return NotFiniteLink;
  if (!finite(m.temperature_c)) return NotFiniteTemperature;
  if (!finite(m.q_measured_rad) || !finite(m.q_commanded_rad) || !finite(m.q_commanded_fri_rad))
    return NotFiniteJoint;
  if (!finite(m.cart_measured) || !finite(m.cart_commanded) || !finite(m.cart_commanded_fri))
    return NotFiniteFrame;
  if (!finite(m.tau_measured_nm) || !finite(m.tau_external_nm) || !finite(m.wrench_external))
    return NotFiniteTorque;
  if (!finite(m.jacobian) || !finite(m.mass_matrix) || !finite(m.gravity_nm)) return NotFiniteModel;
  if (m.state != FriState::Off && m.state != FriState::Monitor && m.state != FriState::Command) return State;
  if (m.quality > FriQuality::Perfect) return Quality;
  if (m.control > FriControl::JointImpedance) return Control;
  if (!within(m.measurement_period_s, 0, 1) || !within(m.command_period_s, 0, 1)) return SampleTime;
  if (!within(m.safety_limits, 0, 1)) return SafetyLimits;
  if (!within(m.answer_rate, 0, 1000) || !within(m.miss_rate, 0, 1000) || !within(m.latency_s, 0, 1000) ||
      !within(m.jitter_s, 0, 1000))
    return Statistics;
  if (!within(m.temperature_c, -60, 250)) return Temperature;
  FriJoints sum{};
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = m.q_commanded_rad[i] + m.q_commanded_fri_rad[i];
  if (!joints_possible(m.q_measured_rad) || !joints_possible(m.q_commanded_rad) || !joints_possible(sum))
    return JointPosition;
  // the offset may be given as a frame or as a difference of frames
  if (!frame_possible(m.cart_measured) || !frame_possible(m.cart_commanded) ||
      !within(m.cart_commanded_fri, -20, 20))
    return CartesianPose;
  if (!within(m.tau_measured_nm, -1000, 1000) || !within(m.tau_external_nm, -1000, 1000)) return JointTorque;
  // projected through a Jacobian that may be near singular: only garbage is larger
  if (!within(m.wrench_external, -1e5f, 1e5f)) return Wrench;
  if (!within(m.jacobian, -10, 10)) return Jacobian;
  if (!within(m.mass_matrix, -1000, 1000) || !within(m.gravity_nm, -1000, 1000)) return MassMatrix;
  return None;
}

FriRefusal implausible(const FriCommand& c) noexcept {
  using enum FriRefusal;
  const bool all = finite(c.krl.real) && finite(c.q_rad) && finite(c.cart) && finite(c.tau_nm) &&
                   finite(c.wrench) && finite(c.stiffness_nm_rad) && finite(c.damping) &&
                   finite(c.cart_stiffness) && finite(c.cart_damping);
  if (!all) return NotFinite;
  if ((c.flags & ~fri_flag::kAll) != 0) return Flags;
  if (!joints_possible(c.q_rad)) return JointPosition;
  if (!frame_possible(c.cart)) return CartesianPose;
  if (!within(c.tau_nm, -1000, 1000)) return JointTorque;
  if (!within(c.wrench, -1e4f, 1e4f)) return Wrench;
  if (!within(c.stiffness_nm_rad, 0, 2000)) return Stiffness;
  for (std::size_t i = 0; i < 6; ++i)
    if (!within(c.cart_stiffness[i], 0, i < 3 ? 5000.0f : 300.0f)) return Stiffness;
  if (!within(c.damping, 0, 1) || !within(c.cart_damping, 0, 1)) return Damping;
  return None;
}

namespace {

template <class Packet>
FriRefusal decode_packet(std::span<const std::byte> bytes, Packet& out, FriChecks checks, std::size_t size,
                         std::uint16_t id) noexcept {
  if (bytes.size() != size) return FriRefusal::Size;
  Packet packet;
  Reader read(bytes.data());
  fri_layout(packet, read);
  if (checks.header) {
    if (packet.head.id != id) return FriRefusal::HeaderId;
    if (packet.head.size != size) return FriRefusal::HeaderSize;
  }
  if (checks.values)
    if (const FriRefusal why = implausible(packet); why != FriRefusal::None) return why;
  out = packet;
  return FriRefusal::None;
}

}  // namespace

FriRefusal decode(std::span<const std::byte> bytes, FriMeasurement& out, FriChecks checks) noexcept {
  return decode_packet(bytes, out, checks, kFriMeasurementBytes, kFriMeasurementId);
}

FriRefusal decode(std::span<const std::byte> bytes, FriCommand& out, FriChecks checks) noexcept {
  return decode_packet(bytes, out, checks, kFriCommandBytes, kFriCommandId);
}

void encode(const FriMeasurement& value, std::span<std::byte, kFriMeasurementBytes> bytes) noexcept {
  Writer write(bytes.data());
  fri_layout(value, write);
}

void encode(const FriCommand& value, std::span<std::byte, kFriCommandBytes> bytes) noexcept {
  Writer write(bytes.data());
  fri_layout(value, write);
}

}  // namespace colift::hal
