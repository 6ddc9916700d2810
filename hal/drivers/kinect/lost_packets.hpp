#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace colift::hal::kinect {

// Up to five lost USB packets leave no mark in a frame: it is delivered with the bytes of the frame before in
// their place (OpenKinect/libfreenect 0.5.3, cameras.c). Two signs tell.

/// What the library logs: "[Stream 70] Lost 3 packets" or "Lost too many packets, resyncing...". The number
/// of packets; 6 for too many; nothing for any other line. Stream 70 is the depth.
[[nodiscard]] std::optional<int> lost_packets(std::string_view log_line);

/// Runs of pixels as one packet carries them (1748 bytes, 11 bits each) that are the same as in the frame
/// before to the last bit, while most of the others have changed: what a lost packet leaves. Runs that see
/// next to nothing do not count. 0 for frames of different size, and where nothing changes at all.
[[nodiscard]] int stale_runs(std::span<const std::uint16_t> frame, std::span<const std::uint16_t> before);

}  // namespace colift::hal::kinect
