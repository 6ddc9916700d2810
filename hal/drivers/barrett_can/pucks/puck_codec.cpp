#include "hal/drivers/barrett_can/pucks/puck_codec.hpp"

#include <algorithm>
#include <bit>

namespace colift::hal::barrett {
namespace {

// groups that answers go to, when the host is node 0
constexpr int kPositionGroup = 3, kValueGroup = 6, kJointGroup = 7, kTopGroup = 8, kFullGroup = 9;

constexpr std::int32_t sign_extend(std::uint32_t value, int bits) {
  const int unused = 32 - bits;
  return static_cast<std::int32_t>(value << unused) >> unused;
}

// 22 bits, big endian; the two bits above them mean nothing (firmware sets bit 7, the maker's paper does not)
std::int32_t packed22(const CanFrame& frame, std::size_t at) {
  const std::uint32_t raw = (frame.data[at] & 0x3fu) << 16 | frame.data[at + 1] * 256u | frame.data[at + 2];
  return sign_extend(raw, 22);
}

tl::expected<Reply, Reject> decode_value(Puck puck, const CanFrame& frame) {
  if (frame.length != 4 && frame.length != 6) return tl::unexpected(Reject::WrongLength);
  if ((frame.data[0] & 0x80) == 0) return tl::unexpected(Reject::NotAnAnswer);
  const auto number = static_cast<std::uint8_t>(frame.data[0] & 0x7f);
  const PropertyInfo* info = property_info(number);
  if (info == nullptr || !info->readable) return tl::unexpected(Reject::UnknownProperty);
  if (frame.data[1] != 0) return tl::unexpected(Reject::WrongFormat);
  std::uint32_t raw = 0;
  for (int i = frame.length - 1; i >= 2; --i) raw = raw << 8 | frame.data[static_cast<std::size_t>(i)];
  return ValueReply{puck, static_cast<Property>(number), sign_extend(raw, 8 * (frame.length - 2))};
}

tl::expected<Reply, Reject> decode_position(Puck puck, const CanFrame& frame) {
  if (frame.length != 3 && frame.length != 6) return tl::unexpected(Reject::WrongLength);
  PositionReply reply{puck, packed22(frame, 0), std::nullopt};
  if (frame.length == 6) reply.joint = packed22(frame, 3);
  return reply;
}

tl::expected<Reply, Reject> decode_row(Puck puck, const CanFrame& frame) {
  if (frame.length != 8) return tl::unexpected(Reject::WrongLength);
  TactileRow reply{puck, static_cast<std::uint8_t>(frame.data[0] >> 4), {}};
  if (reply.row >= kTactileRows) return tl::unexpected(Reject::WrongFormat);
  // sixty bits after the row number, twelve per cell
  for (std::size_t cell = 0; cell < reply.cells.size(); ++cell) {
    const std::size_t nibble = 1 + 3 * cell, byte = nibble / 2;
    reply.cells[cell] =
        nibble % 2 ? static_cast<std::uint16_t>((frame.data[byte] & 0x0f) << 8 | frame.data[byte + 1])
                   : static_cast<std::uint16_t>(frame.data[byte] << 4 | frame.data[byte + 1] >> 4);
  }
  return reply;
}

tl::expected<Reply, Reject> decode_top(Puck puck, const CanFrame& frame) {
  if (frame.length != 8) return tl::unexpected(Reject::WrongLength);
  const std::uint32_t map = frame.data[0] * 65536u + frame.data[1] * 256u + frame.data[2];
  if (std::popcount(map) != 10) return tl::unexpected(Reject::WrongFormat);
  TactileTop reply{puck, {}};
  std::size_t nibble = 6;  // of the first value, high nibble first
  for (std::size_t cell = 0; cell < kTactileCells; ++cell) {
    if ((map >> cell & 1u) == 0) continue;
    const unsigned byte = frame.data[nibble / 2];
    reply.cells[cell] = static_cast<std::uint16_t>((nibble % 2 ? byte & 0x0fu : byte >> 4) * 256u);
    ++nibble;
  }
  return reply;
}

}  // namespace

CanFrame encode_get(std::uint16_t to, Property property) noexcept {
  CanFrame frame;
  frame.id = to;
  frame.length = 1;
  frame.data[0] = static_cast<std::uint8_t>(property);
  return frame;
}

CanFrame encode_set(std::uint16_t to, Property property, std::int32_t value, SetForm form) noexcept {
  CanFrame frame;
  frame.id = to;
  frame.length = form == SetForm::Long || property_info(property).bits == 32 ? 6 : 4;
  frame.data[0] = static_cast<std::uint8_t>(0x80 | static_cast<std::uint8_t>(property));
  const auto raw = static_cast<std::uint32_t>(value);
  for (std::size_t i = 2; i < frame.length; ++i)
    frame.data[i] = static_cast<std::uint8_t>(raw >> 8 * (i - 2) & 0xff);
  return frame;
}

std::string_view to_string(Reject why) noexcept {
  switch (why) {
    case Reject::ForeignId:
      return "from no puck of the hand";
    case Reject::WrongLength:
      return "of a length that this answer never has";
    case Reject::NotAnAnswer:
      return "a question, not an answer";
    case Reject::UnknownProperty:
      return "about a property that is unknown or never read";
    case Reject::WrongFormat:
      return "of a form that this answer never has";
  }
  return "of an unknown kind";
}

std::optional<Request> decode_request(const CanFrame& frame) noexcept {
  const int from = frame.id >> 5 & 0x1f, to = frame.id & 0x1f;
  if (frame.id > 0x7ff || frame.length == 0 || frame.length > 8) return std::nullopt;
  if (std::find(kHostNodes.begin(), kHostNodes.end(), from) == kHostNodes.end()) return std::nullopt;
  Request request;
  request.from = static_cast<std::uint8_t>(from);
  if ((frame.id & kGroupBit) != 0) {
    if (to != 0 && to != kHandGroup) return std::nullopt;
  } else {
    if (to < node_id(Puck::F1) || to > node_id(Puck::Spread)) return std::nullopt;
    request.puck = kAllPucks[static_cast<std::size_t>(to - node_id(Puck::F1))];
  }
  request.property = static_cast<Property>(frame.data[0] & 0x7f);
  request.sets = (frame.data[0] & 0x80) != 0;
  if (!request.sets) return frame.length <= 2 ? std::optional(request) : std::nullopt;
  if (frame.length == 8) return request;
  if (frame.length != 4 && frame.length != 6) return std::nullopt;
  std::uint32_t raw = 0;
  for (int i = frame.length - 1; i >= 2; --i) raw = raw << 8 | frame.data[static_cast<std::size_t>(i)];
  request.value = sign_extend(raw, 8 * (frame.length - 2));
  return request;
}

tl::expected<Reply, Reject> decode_reply(const CanFrame& frame) noexcept {
  const int from = frame.id >> 5 & 0x1f;
  if (frame.id > 0x7ff || (frame.id & kGroupBit) == 0 || from < node_id(Puck::F1) ||
      from > node_id(Puck::Spread))
    return tl::unexpected(Reject::ForeignId);
  if (frame.length > 8) return tl::unexpected(Reject::WrongLength);
  const Puck puck = kAllPucks[static_cast<std::size_t>(from - node_id(Puck::F1))];
  switch (frame.id & 0x1f) {
    case kPositionGroup:
      return decode_position(puck, frame);
    case kValueGroup:
      return decode_value(puck, frame);
    case kJointGroup:
      if (frame.length != 3) return tl::unexpected(Reject::WrongLength);
      return ValueReply{puck, Property::Jp, packed22(frame, 0)};
    case kTopGroup:
      return decode_top(puck, frame);
    case kFullGroup:
      return decode_row(puck, frame);
    default:
      return tl::unexpected(Reject::ForeignId);
  }
}

}  // namespace colift::hal::barrett
