#include "tools/telemetry/channels/string_message.hpp"

#include "tools/telemetry/mcap/byte_io.hpp"

namespace colift::telemetry {
namespace {

constexpr std::uint32_t kPlainCdr = 0x00000100;  // bytes 00 01 00 00: little endian

}  // namespace

std::string string_definition() {
  return "string data\n";
}

std::string string_message(std::string_view text) {
  std::string out;
  out.reserve(text.size() + 9);
  ByteWriter w(out);
  w.u32(kPlainCdr);
  w.u32(static_cast<std::uint32_t>(text.size() + 1));  // the zero at its end counts
  w.bytes(text);
  w.u8(0);
  return out;
}

hal::Result<std::string_view> parse_string(std::string_view bytes) {
  ByteReader r(bytes);
  const bool plain = r.u32() == kPlainCdr;
  const std::string_view text = r.text();
  if (!plain || !r.ok())
    return hal::failure(hal::ErrorCode::BadInput, "text", "is no text in little-endian CDR, or is cut");
  return text.substr(0, text.find('\0'));
}

}  // namespace colift::telemetry
