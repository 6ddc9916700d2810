#include "tests/dds/ros_messages.hpp"

#include <fastcdr/Cdr.h>

#include <chrono>
#include <cmath>
#include <stdexcept>

namespace colift::tests {
namespace {

using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;

/// Reads with Fast CDR; little endian, behind the encapsulation.
class In {
 public:
  explicit In(const Bytes& message)
      : bytes_(message),
        buffer_(reinterpret_cast<char*>(bytes_.data()), bytes_.size()),
        cdr_(buffer_, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR) {
    cdr_.read_encapsulation();
  }
  template <class T>
  In& operator>>(T& value) {
    cdr_ >> value;
    return *this;
  }
  In& operator>>(RosHeader& h) { return *this >> h.stamp.sec >> h.stamp.nanosec >> h.frame_id; }
  template <std::size_t N>
  In& operator>>(std::array<double, N>& values) {
    for (double& v : values) cdr_ >> v;
    return *this;
  }
  std::uint32_t length() {
    std::uint32_t n = 0;
    cdr_ >> n;
    if (n > 10'000'000) throw std::runtime_error("absurd length");
    return n;
  }
  /// Padding at the end is part of no member.
  void end() const {
    if (bytes_.size() - cdr_.getSerializedDataLength() > 3) throw std::runtime_error("bytes are left over");
  }

 private:
  Bytes bytes_;
  FastBuffer buffer_;
  Cdr cdr_;
};

class Out {
 public:
  explicit Out(std::size_t size)
      : bytes_(size),
        buffer_(reinterpret_cast<char*>(bytes_.data()), size),
        cdr_(buffer_, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR) {
    cdr_.serialize_encapsulation();
  }
  template <class T>
  Out& operator<<(const T& value) {
    cdr_ << value;
    return *this;
  }
  Out& operator<<(const RosHeader& h) { return *this << h.stamp.sec << h.stamp.nanosec << h.frame_id; }
  template <std::size_t N>
  Out& operator<<(const std::array<double, N>& values) {
    for (const double v : values) cdr_ << v;
    return *this;
  }
  Bytes bytes() {
    bytes_.resize(cdr_.getSerializedDataLength());
    return bytes_;
  }

 private:
  Bytes bytes_;
  FastBuffer buffer_;
  Cdr cdr_;
};

void put(Out& out, const RosImage& m) {
  out << m.header << m.height << m.width << m.encoding << m.is_bigendian << m.step << m.data;
}
void put(Out& out, const RosCameraInfo& m) {
  out << m.header << m.height << m.width << m.distortion_model << m.d << m.k << m.r << m.p << m.binning_x
      << m.binning_y;
  for (const auto v : m.roi) out << v;
  out << m.do_rectify;
}

void get(In& in, RosDecision& m) {
  in >> m.header >> m.decided >> m.chosen >> m.share >> m.cost >> m.because >> m.partner >> m.cog;
  m.candidates.resize(in.length());
  for (RosCandidate& c : m.candidates) {
    std::string kind, because;
    std::array<double, 3> approach, closing;
    double width = 0.0, cost = 0.0;
    in >> c.id >> kind >> c.position >> approach >> closing >> width >> c.verdict >> because >> c.share >>
        cost;
  }
}

}  // namespace

RosJointState joint_state_of(const Bytes& message) {
  In in(message);
  RosJointState m;
  in >> m.header >> m.name >> m.position >> m.velocity >> m.effort;
  in.end();
  return m;
}

std::vector<RosTransform> transforms_of(const Bytes& message) {
  In in(message);
  std::vector<RosTransform> all(in.length());
  for (RosTransform& t : all) in >> t.header >> t.child_frame_id >> t.translation >> t.rotation;
  in.end();
  return all;
}

RosImage image_of(const Bytes& message) {
  In in(message);
  RosImage m;
  in >> m.header >> m.height >> m.width >> m.encoding >> m.is_bigendian >> m.step >> m.data;
  in.end();
  return m;
}

RosCameraInfo camera_info_of(const Bytes& message) {
  In in(message);
  RosCameraInfo m;
  in >> m.header >> m.height >> m.width >> m.distortion_model >> m.d >> m.k >> m.r >> m.p >> m.binning_x >>
      m.binning_y;
  for (auto& v : m.roi) in >> v;
  in >> m.do_rectify;
  in.end();
  return m;
}

RosPointCloud cloud_of(const Bytes& message) {
  In in(message);
  RosPointCloud m;
  in >> m.header >> m.height >> m.width;
  m.fields.resize(in.length());
  for (std::string& name : m.fields) {
    std::uint32_t offset = 0, count = 0;
    std::uint8_t type = 0;
    in >> name >> offset >> type >> count;
    if (type != 7 || count != 1) throw std::runtime_error("a field that is no FLOAT32");
  }
  bool big = false, dense = false;
  in >> big >> m.point_step >> m.row_step >> m.data >> dense;
  in.end();
  return m;
}

std::vector<RosMarker> markers_of(const Bytes& message) {
  In in(message);
  std::vector<RosMarker> all(in.length());
  for (RosMarker& m : all) {
    float c = 0.0f, u = 0.0f;
    std::int32_t lifetime_s = 0;
    std::uint32_t lifetime_ns = 0;
    bool flag = false;
    std::string text;
    std::vector<std::uint8_t> data;
    RosHeader header;
    in >> m.header >> m.ns >> m.id >> m.type >> m.action >> m.pose >> m.scale >> c >> c >> c >> c >>
        lifetime_s >> lifetime_ns >> flag;
    m.points.resize(in.length());
    for (auto& p : m.points) in >> p;
    for (std::uint32_t n = in.length(); n > 0; --n) in >> c >> c >> c >> c;
    in >> text >> header >> text >> data;  // texture_resource, texture
    for (std::uint32_t n = in.length(); n > 0; --n) in >> u >> u;
    in >> m.text >> text >> text >> data >> flag;  // mesh_resource, mesh_file
  }
  in.end();
  return all;
}

std::string string_of(const Bytes& message) {
  In in(message);
  std::string text;
  in >> text;
  in.end();
  return text;
}

RosTaskStatus task_status_of(const Bytes& message) {
  In in(message);
  RosTaskStatus m;
  std::string waits_for, doing;
  double in_state_s = 0.0, done = 0.0, scale = 0.0;
  in >> m.header >> m.state >> in_state_s >> m.because >> waits_for >> doing >> done >> scale;
  in.end();
  return m;
}

RosDecision decision_of(const Bytes& message) {
  In in(message);
  RosDecision m;
  get(in, m);
  in.end();
  return m;
}

RosDecideReply decide_reply_of(const Bytes& message) {
  In in(message);
  RosDecideReply m;
  in >> m.client >> m.sequence_number >> m.ok >> m.error;
  get(in, m.decision);
  in.end();
  return m;
}

std::vector<RosDiagnostic> diagnostics_of(const Bytes& message) {
  In in(message);
  RosHeader header;
  in >> header;
  std::vector<RosDiagnostic> all(in.length());
  for (RosDiagnostic& d : all) {
    std::string hardware, key, value;
    in >> d.level >> d.name >> d.message >> hardware;
    for (std::uint32_t n = in.length(); n > 0; --n) in >> key >> value;
  }
  in.end();
  return all;
}

std::vector<RosNode> nodes_of(const Bytes& message) {
  In in(message);
  const auto gid = [&in] {
    Bytes b(16);
    for (auto& octet : b) in >> octet;
    return b;
  };
  (void)gid();
  std::vector<RosNode> nodes(in.length());
  for (RosNode& n : nodes) {
    in >> n.name_space >> n.name;
    for (std::uint32_t c = in.length(); c > 0; --c) n.readers.push_back(gid());
    for (std::uint32_t c = in.length(); c > 0; --c) n.writers.push_back(gid());
  }
  in.end();
  return nodes;
}

Bytes bytes_of(const RosImage& image) {
  Out out(image.data.size() + 1000);
  put(out, image);
  return out.bytes();
}

Bytes bytes_of(const RosCameraInfo& info) {
  Out out(4000);
  put(out, info);
  return out.bytes();
}

Bytes bytes_of(const RosDecideRequest& r) {
  Out out(r.depth.data.size() + 4000);
  out << r.header << r.client << r.sequence_number;
  put(out, r.depth);
  put(out, r.info);
  out << r.partner << r.share;
  return out.bytes();
}

Bytes bytes_of(const RosJointState& m) {
  Out out(4000);
  out << m.header << m.name << m.position << m.velocity << m.effort;
  return out.bytes();
}

Bytes clock_bytes(Stamp clock) {
  Out out(64);
  out << clock.sec << clock.nanosec;
  return out.bytes();
}

Stamp system_stamp(double later_s) {
  const auto now = std::chrono::system_clock::now().time_since_epoch() +
                   std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * later_s));
  const auto ns = std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
  return {static_cast<std::int32_t>(ns / 1'000'000'000), static_cast<std::uint32_t>(ns % 1'000'000'000)};
}

}  // namespace colift::tests
