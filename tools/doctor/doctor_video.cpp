#include <fmt/format.h>
#include <unistd.h>

#include <system_error>

#include "tools/doctor/doctor_row.hpp"

namespace colift::tools {

namespace fs = std::filesystem;

DoctorRows video_rows(const fs::path& root, const std::string& device) {
  constexpr auto kList = "sudo apt install v4l-utils; v4l2-ctl --list-devices";
  const fs::path node = root / fs::path(device).relative_path();
  std::error_code none;
  if (!fs::exists(node, none))
    return {{"video device", fmt::format("there is no {}", device), DoctorRow::Verdict::Bad, kList}};
  if (!fs::is_character_file(node, none))
    return {{"video device", fmt::format("{} is no device", device), DoctorRow::Verdict::Bad, kList}};
  if (::access(node.c_str(), R_OK | W_OK) != 0)
    return {{"video device", fmt::format("{} may not be opened by this user", device),
             DoctorRow::Verdict::Bad, "sudo usermod -aG video $USER    # then log in again"}};
  // a link by id names the node
  const fs::path real = fs::canonical(node, none);
  const auto name =
      none ? std::nullopt : read_small(root / "sys/class/video4linux" / real.filename() / "name");
  if (!name)
    return {{"video device", fmt::format("{} is no video device", device), DoctorRow::Verdict::Bad, kList}};
  return {{"video device", fmt::format("{} may be opened: {}", device, *name)}};
}

}  // namespace colift::tools
