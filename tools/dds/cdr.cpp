#include "tools/dds/cdr.hpp"

#include <dds/ddsi/ddsi_cdrstream.h>

namespace colift::ros2 {
namespace {

constexpr std::uint32_t kXcdr1 = 1;
constexpr char kLittleEndian[] = {0, 1, 0, 0};

}  // namespace

std::string to_cdr(const dds_topic_descriptor_t& type, const void* message) {
  dds_ostreamLE_t stream;
  dds_ostreamLE_init(&stream, 256, kXcdr1);
  (void)dds_stream_writeLE(&stream, static_cast<const char*>(message), type.m_ops);
  std::string out(kLittleEndian, sizeof(kLittleEndian));
  out.append(reinterpret_cast<const char*>(stream.x.m_buffer), stream.x.m_index);
  dds_ostreamLE_fini(&stream);
  return out;
}

}  // namespace colift::ros2
