#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <tl/expected.hpp>
#include <variant>

#include "hal/can_bus.hpp"
#include "hal/drivers/barrett_can/pucks/puck_property.hpp"

namespace colift::hal::barrett {

/// The four motor controllers of the hand in the order of their node ids, which are also indices here.
enum class Puck : std::uint8_t { F1, F2, F3, Spread };
inline constexpr int kPucks = 4;
inline constexpr std::array<Puck, kPucks> kAllPucks{Puck::F1, Puck::F2, Puck::F3, Puck::Spread};
inline constexpr std::array<Puck, 3> kFingerPucks{Puck::F1, Puck::F2, Puck::F3};
[[nodiscard]] constexpr std::size_t index(Puck puck) {
  return static_cast<std::size_t>(puck);
}
[[nodiscard]] constexpr int node_id(Puck puck) {
  return 11 + static_cast<int>(puck);
}
[[nodiscard]] constexpr std::string_view name(Puck puck) {
  constexpr std::array<std::string_view, kPucks> kNames{"F1", "F2", "F3", "spread"};
  return kNames[index(puck)];
}

// An identifier is G FFFFF TTTTT: group bit, sender, receiver. The host is node 0.
inline constexpr std::uint16_t kGroupBit = 0x400;
inline constexpr std::uint16_t kToEverybody = kGroupBit;  ///< Group 0: every puck on the bus.
inline constexpr std::uint16_t kToHand = kGroupBit | 5;   ///< Group 5: the pucks whose GRPA, B or C is 5.
inline constexpr int kHandGroup = 5;
[[nodiscard]] constexpr std::uint16_t id_to(Puck puck) {
  return static_cast<std::uint16_t>(node_id(puck));
}

/// Nodes that other programs speak from (Barrett's and most: 0, 6, 9); a WAM's pucks are 1 to 7, its safety
/// module 10.
inline constexpr std::array<int, 3> kHostNodes{0, 6, 9};

/// What comes from the hand to groups, one filter per puck; and what other programs say to anybody.
[[nodiscard]] constexpr std::array<CanFilter, kPucks + kHostNodes.size()> hand_filters() {
  std::array<CanFilter, kPucks + kHostNodes.size()> filters;
  for (const Puck p : kAllPucks)
    filters[index(p)] = {static_cast<std::uint16_t>(kGroupBit | node_id(p) << 5), 0x7e0};
  for (std::size_t i = 0; i < kHostNodes.size(); ++i)
    filters[kPucks + i] = {static_cast<std::uint16_t>(kHostNodes[i] << 5), 0x3e0};
  return filters;
}

[[nodiscard]] CanFrame encode_get(std::uint16_t to, Property property) noexcept;

/// How long a SET is: as wide as its property (4 or 6 bytes), or 6 bytes always. Pucks take both.
enum class SetForm { ByWidth, Long };

/// The value's low 16 bits for a 16-bit property in the form ByWidth.
[[nodiscard]] CanFrame encode_set(std::uint16_t to, Property property, std::int32_t value,
                                  SetForm form = SetForm::ByWidth) noexcept;

/// Answer to a GET of anything but P and TACT.
struct ValueReply {
  Puck puck{};
  Property property{};
  std::int32_t value = 0;
};

/// Answer to a GET of P, in counts of 22 bits with sign. The joint's encoder only from a puck that has one.
struct PositionReply {
  Puck puck{};
  std::int32_t motor = 0;
  std::optional<std::int32_t> joint;
};

/// A fifth of a full tactile scan: cells 5 `row` to 5 `row` + 4, counted from 0; 12 bits, 256 per N/cm2. In
/// row 4 the last one is padding.
struct TactileRow {
  Puck puck{};
  std::uint8_t row = 0;
  std::array<std::uint16_t, 5> cells{};
};

inline constexpr int kTactileCells = 24;
inline constexpr int kTactileRows = 5;

/// The ten cells under the most pressure; all others are 0. In the unit of TactileRow, in steps of 256.
struct TactileTop {
  Puck puck{};
  std::array<std::uint16_t, kTactileCells> cells{};
};

using Reply = std::variant<ValueReply, PositionReply, TactileRow, TactileTop>;

/// Why a frame is not an answer of the hand. The caller counts.
enum class Reject : std::uint8_t {
  ForeignId,  ///< Not from a puck of the hand, or not to a group that answers go to.
  WrongLength,
  NotAnAnswer,      ///< Bit 7 of byte 0 is clear: somebody's question.
  UnknownProperty,  ///< Or one that is never read back.
  WrongFormat,      ///< Array byte, row number or number of marked cells that cannot be.
};
[[nodiscard]] std::string_view to_string(Reject why) noexcept;

/// A question or a setting to the hand, as hosts say them.
struct Request {
  std::uint8_t from = 0;     ///< Node of who said it.
  std::optional<Puck> puck;  ///< Unset: to all of them.
  Property property{};
  bool sets = false;
  std::int32_t value = 0;  ///< Of a setting; 0 for packed torques.
};

/// What a host on the bus asked or told the hand; nullopt: it is none, or not to the hand. Any bytes may
/// come.
[[nodiscard]] std::optional<Request> decode_request(const CanFrame& frame) noexcept;

/// What a frame from the bus says. Any bytes may come.
[[nodiscard]] tl::expected<Reply, Reject> decode_reply(const CanFrame& frame) noexcept;

}  // namespace colift::hal::barrett
