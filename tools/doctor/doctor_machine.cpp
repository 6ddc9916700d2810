#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <map>

#include "tools/doctor/doctor_row.hpp"

namespace colift::tools {
namespace {

namespace fs = std::filesystem;
using Verdict = DoctorRow::Verdict;

constexpr int kSysNice = 23, kIpcLock = 14;   // capabilities(7)
constexpr unsigned long long kPriority = 80;  // that the arm's cycle asks for
constexpr unsigned long long kMiB = 1024ull * 1024;
constexpr unsigned long long kLocked = 512 * kMiB;

const char* const kLimitsLine =
    "printf '@realtime - rtprio 95\\n@realtime - memlock unlimited\\n' | sudo tee "
    "/etc/security/limits.d/colift.conf; sudo groupadd -f realtime; sudo usermod -aG realtime $USER; then "
    "log in anew";

bool may(const fs::path& root, int capability) {
  const auto status = read_small(root / "proc/self/status");
  if (!status) return false;
  const std::size_t at = status->find("CapEff:");
  if (at == std::string::npos) return false;
  const std::size_t from = status->find_first_not_of(" \t", at + 7);
  if (from == std::string::npos) return false;
  unsigned long long bits = 0;
  std::from_chars(status->data() + from, status->data() + status->size(), bits, 16);
  return (bits >> capability & 1) != 0;
}

DoctorRow kernel(const fs::path& root) {
  const std::string release = read_small(root / "proc/sys/kernel/osrelease").value_or("unknown");
  if (read_number(root / "sys/kernel/realtime") == 1)
    return {"kernel", fmt::format("{}, PREEMPT_RT", release)};
  const std::string version = read_small(root / "proc/version").value_or("");
  const bool dynamic = version.find("PREEMPT") != std::string::npos;
  return {"kernel",
          fmt::format("{}, {}: single answers to the arm may come late by milliseconds", release,
                      dynamic ? "preemptible, not PREEMPT_RT" : "not PREEMPT_RT"),
          Verdict::Warn, "sudo apt install linux-image-rt-amd64 && sudo reboot"};
}

DoctorRow priority(const fs::path& root, const Limits& limits) {
  if (may(root, kSysNice)) return {"real-time priority", "any: this process has CAP_SYS_NICE"};
  if (!limits.rtprio) return {"real-time priority", "any"};
  if (*limits.rtprio >= kPriority) return {"real-time priority", fmt::format("up to {}", *limits.rtprio)};
  return {"real-time priority",
          fmt::format("up to {}, the arm's cycle asks for {}: it runs among everything else", *limits.rtprio,
                      kPriority),
          Verdict::Warn, kLimitsLine};
}

DoctorRow memory_lock(const fs::path& root, const Limits& limits) {
  if (may(root, kIpcLock)) return {"locked memory", "any: this process has CAP_IPC_LOCK"};
  if (!limits.memlock_bytes) return {"locked memory", "any"};
  const std::string found = fmt::format("up to {} MiB", *limits.memlock_bytes / kMiB);
  if (*limits.memlock_bytes >= kLocked) return {"locked memory", found};
  return {"locked memory", found + ", needed are 512: pages may be fetched in the arm's cycle", Verdict::Warn,
          kLimitsLine};
}

/// "0-3,6" as a number of processors.
int count_list(const std::string& text) {
  int n = 0;
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t to = std::min(text.find(',', from), text.size());
    const char *at = text.data() + from, *end = text.data() + to;
    int low = 0, high = 0;
    const auto first = std::from_chars(at, end, low);
    high = low;
    if (first.ptr < end && *first.ptr == '-') std::from_chars(first.ptr + 1, end, high);
    if (first.ec == std::errc{} && high >= low) n += high - low + 1;
    from = to + 1;
  }
  return n;
}

DoctorRow processors(const fs::path& root) {
  const fs::path cpu = root / "sys/devices/system/cpu";
  const std::string online = read_small(cpu / "online").value_or("");
  const int n = count_list(online);
  const std::string isolated = read_small(cpu / "isolated").value_or("");
  std::string found = fmt::format("{} ({})", n, online);
  if (!isolated.empty()) found += fmt::format(", isolated: {}", isolated);
  if (n >= 2) return {"processors", found};
  return {"processors",
          n == 0 ? std::string("not reported by the system")
                 : found + ": the arm's cycle shares it with all else",
          Verdict::Warn, "a machine with two processors or more"};
}

DoctorRow governor(const fs::path& root) {
  const fs::path cpu = root / "sys/devices/system/cpu";
  std::map<std::string, int> found;
  for (const std::string& name : names_in(cpu))
    if (const auto g = read_small(cpu / name / "cpufreq/scaling_governor"); g && name.rfind("cpu", 0) == 0)
      ++found[*g];
  if (found.empty()) return {"governor", "the clock rate is not in this system's hands"};
  std::string text;
  for (const auto& [name, n] : found) text += fmt::format("{}{} on {}", text.empty() ? "" : ", ", name, n);
  if (found.size() == 1 && found.begin()->first == "performance") return {"governor", text};
  return {"governor", text + ": processors sleep and slow down between datagrams", Verdict::Warn,
          "echo performance | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor"};
}

DoctorRow clock_source(const fs::path& root) {
  const fs::path folder = root / "sys/devices/system/clocksource/clocksource0";
  const std::string now = read_small(folder / "current_clocksource").value_or("unknown");
  for (const char* slow : {"hpet", "acpi_pm", "jiffies", "pit", "refined-jiffies"})
    if (now == slow) {
      const bool tsc =
          read_small(folder / "available_clocksource").value_or("").find("tsc") != std::string::npos;
      return {"clock source", now + ": a look at the clock costs microseconds", Verdict::Warn,
              tsc ? "echo tsc | sudo tee /sys/devices/system/clocksource/clocksource0/current_clocksource"
                  : "see dmesg for why the kernel does not trust the TSC"};
    }
  return {"clock source", now};
}

DoctorRow disk_space(const DiskSpace& disk) {
  const double gib = static_cast<double>(disk.free_bytes) / static_cast<double>(1024 * kMiB);
  DoctorRow row{"disk space", fmt::format("{:.1f} GiB free in {}", gib, disk.folder.string())};
  if (gib >= 2.0) return row;
  row.verdict = gib < 0.2 ? Verdict::Bad : Verdict::Warn;
  row.found += ", recordings of a run need about 2";
  row.repair = fmt::format("du -xh --max-depth=2 {} | sort -h | tail", disk.folder.string());
  return row;
}

}  // namespace

const char* word(Verdict verdict) {
  switch (verdict) {
    case Verdict::Ok:
      return "ok";
    case Verdict::Warn:
      return "warn";
    case Verdict::Bad:
      return "bad";
  }
  return "?";
}

std::optional<std::string> read_small(const fs::path& file) {
  std::error_code none;
  if (fs::is_directory(file, none)) return std::nullopt;
  std::ifstream in(file, std::ios::binary);
  if (!in) return std::nullopt;
  std::string text(64 * 1024, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ' || text.back() == '\0')) text.pop_back();
  return text;
}

std::optional<long long> read_number(const fs::path& file) {
  const auto text = read_small(file);
  long long value = 0;
  if (!text || std::from_chars(text->data(), text->data() + text->size(), value).ec != std::errc{})
    return std::nullopt;
  return value;
}

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    names.push_back(it->path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

DoctorRows machine_rows(const fs::path& root, const Limits& limits, const DiskSpace& disk) {
  return {kernel(root),   priority(root, limits), memory_lock(root, limits), processors(root),
          governor(root), clock_source(root),     disk_space(disk)};
}

}  // namespace colift::tools
