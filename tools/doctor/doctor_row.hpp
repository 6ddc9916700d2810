#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace colift::tools {

/// One finding on this machine.
struct DoctorRow {
  enum class Verdict { Ok, Warn, Bad };
  std::string what;   ///< "kernel", "CAN can0", ...
  std::string found;  ///< With its numbers.
  Verdict verdict = Verdict::Ok;
  std::string repair;  ///< The line that repairs it, or what to do; empty when it is fine.

  DoctorRow(std::string what_, std::string found_, Verdict verdict_ = Verdict::Ok, std::string repair_ = "")
      : what(std::move(what_)), found(std::move(found_)), verdict(verdict_), repair(std::move(repair_)) {}
};
using DoctorRows = std::vector<DoctorRow>;
[[nodiscard]] const char* word(DoctorRow::Verdict verdict);

/// The start of a small file (64 KiB at most) without white space at its end; nothing when there is none.
[[nodiscard]] std::optional<std::string> read_small(const std::filesystem::path& file);
/// A whole number that a file holds.
[[nodiscard]] std::optional<long long> read_number(const std::filesystem::path& file);
/// Names in a folder, sorted; none when there is no such folder.
[[nodiscard]] std::vector<std::string> names_in(const std::filesystem::path& folder);

// Probes are functions of a root folder, "/" on the machine and a fake tree in tests, and of numbers that the
// system was asked for. They touch nothing.

struct Limits {
  /// What a process may ask for; unset: without a limit.
  std::optional<unsigned long long> rtprio, memlock_bytes;
};
struct DiskSpace {
  std::filesystem::path folder;
  unsigned long long free_bytes = 0;
};

/// Kernel, priorities, memory lock, processors, governor, clock source, disk.
[[nodiscard]] DoctorRows machine_rows(const std::filesystem::path& root, const Limits& limits,
                                      const DiskSpace& disk);
/// The arm's UDP port and the network cards.
[[nodiscard]] DoctorRows network_rows(const std::filesystem::path& root, int udp_port);
/// A camera that the kernel serves.
[[nodiscard]] DoctorRows video_rows(const std::filesystem::path& root, const std::string& device);
/// The Kinect on its USB port.
[[nodiscard]] DoctorRows usb_rows(const std::filesystem::path& root);

}  // namespace colift::tools
