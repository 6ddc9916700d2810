#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "hal/drivers/capture_link/beside_program.hpp"
#include "tools/bring_up/cmd_hal.hpp"
#include "tools/cli/session.hpp"
#include "tools/doctor/doctor_can.hpp"
#include "tools/doctor/doctor_row.hpp"
#include "tools/doctor/doctor_usb_capture.hpp"
#include "tools/rig/robot_file.hpp"

namespace colift::tools {
namespace {

namespace fs = std::filesystem;
using Verdict = DoctorRow::Verdict;

std::optional<unsigned long long> limit_of(__rlimit_resource_t what) {
  rlimit limit{};
  if (::getrlimit(what, &limit) != 0) return 0;
  if (limit.rlim_cur == RLIM_INFINITY) return std::nullopt;
  return limit.rlim_cur;
}

DiskSpace disk_here() {
  std::error_code error;
  const fs::path here = fs::current_path(error);
  const fs::space_info space = fs::space(here, error);
  return {here, error ? 0ull : static_cast<unsigned long long>(space.available)};
}

std::string table(const DoctorRows& rows) {
  std::size_t width = 0;
  for (const DoctorRow& row : rows) width = std::max(width, row.what.size());
  std::string text;
  for (const DoctorRow& row : rows) {
    text += fmt::format("{:4}  {:{}}  {}\n", word(row.verdict), row.what, width, row.found);
    if (!row.repair.empty()) text += fmt::format("{:6}{:{}}  -> {}\n", "", "", width, row.repair);
  }
  return text;
}

}  // namespace

int cmd_doctor(const CommonOptions& common, const DoctorOptions& options) {
  const auto robot = read_robot_file(options.robot);
  if (!robot) return report_error("doctor", robot.error());
  DoctorRows rows =
      machine_rows(options.root, {limit_of(RLIMIT_RTPRIO), limit_of(RLIMIT_MEMLOCK)}, disk_here());
  for (DoctorRow& row : network_rows(options.root, robot->fri.port)) rows.push_back(std::move(row));
  for (DoctorRow& row : can_rows(options.root, robot->barrett.can, hal::read_can_link))
    rows.push_back(std::move(row));
  DoctorRows camera;
  if (robot->camera == "v4l2")
    camera = video_rows(options.root, robot->v4l2.device);
  else
    camera = robot->camera == "openni2" ? openni2_rows(robot->openni2) : usb_rows(options.root);
  for (DoctorRow& row : camera) rows.push_back(std::move(row));
  const fs::path capture = robot->kinect.program.empty()
                               ? fs::path(hal::capture::own_folder()) / "colift-kinect"
                               : fs::path(robot->kinect.program);
  for (DoctorRow& row : capture_rows(capture, robot->camera == "kinect", ask_capture))
    rows.push_back(std::move(row));

  const auto count = [&](Verdict v) {
    return std::count_if(rows.begin(), rows.end(), [v](const DoctorRow& r) { return r.verdict == v; });
  };
  const auto bad = count(Verdict::Bad), warned = count(Verdict::Warn);
  if (common.json) {
    nlohmann::ordered_json j = {
        {"schema", "colift.doctor/1"}, {"ok", bad == 0}, {"rows", nlohmann::ordered_json::array()}};
    for (const DoctorRow& row : rows)
      j["rows"].push_back(
          {{"what", row.what}, {"found", row.found}, {"verdict", word(row.verdict)}, {"repair", row.repair}});
    // names of files and drivers may hold any bytes
    std::puts(j.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace).c_str());
  } else {
    if (!common.quiet) std::fputs(table(rows).c_str(), stdout);
    fmt::print("{} of {} fine, {} to look at, {} bad\n", rows.size() - static_cast<std::size_t>(bad + warned),
               rows.size(), warned, bad);
  }
  std::fflush(stdout);
  return bad == 0 ? kDone : kDeviceFailed;
}

}  // namespace colift::tools
