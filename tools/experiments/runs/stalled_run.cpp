#include "tools/experiments/runs/stalled_run.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <vector>

#include "tools/rig/emulated_rig.hpp"
#include "tools/rig/rig_world.hpp"

namespace colift::experiments {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr double kWindow_s = 0.02, kMoving_rad_s = 0.01, kSlow_rad_s = 0.05, kMachine_s = 0.02;
constexpr double kReach_s = 120.0, kEnd_s = 20.0;

double seconds_since(Clock::time_point t) {
  return std::chrono::duration<double>(Clock::now() - t).count();
}

/// The joints as the far ends move them, with the times of this machine.
class Motion {
 public:
  void add(const hal::JointVector& q_rad) {
    const std::scoped_lock lock(mutex_);
    samples_.push_back({seconds_since(began_), q_rad});
  }
  [[nodiscard]] double now_s() const { return seconds_since(began_); }

  /// Of the fastest joint over the 20 ms before an instant.
  [[nodiscard]] double speed_rad_s(double t_s) const {
    const auto after = std::upper_bound(samples_.begin(), samples_.end(), t_s,
                                        [](double t, const Sample& s) { return t < s.t_s; });
    if (after == samples_.begin()) return 0.0;
    const Sample& last = *(after - 1);
    const auto first = std::lower_bound(samples_.begin(), after, last.t_s - kWindow_s,
                                        [](const Sample& s, double t) { return s.t_s < t; });
    const double dt = last.t_s - first->t_s;
    return dt > 0.0 ? (last.q_rad - first->q_rad).cwiseAbs().maxCoeff() / dt : 0.0;
  }

  void judge(double stopped_s, double held_s, StalledRun& run) const {
    const std::scoped_lock lock(mutex_);
    run.speed_rad_s = speed_rad_s(stopped_s);
    double before_s = NAN;
    for (const Sample& s : samples_) {
      if (s.t_s < stopped_s - 0.05 || s.t_s > stopped_s + held_s) continue;
      if (!std::isnan(before_s)) run.gap_s = std::max(run.gap_s, s.t_s - before_s);
      before_s = s.t_s;
      if (s.t_s <= stopped_s) continue;
      const double v = speed_rad_s(s.t_s);
      if (v > kMoving_rad_s) run.moved_s = s.t_s - stopped_s;
      if (v > kSlow_rad_s) run.fast_s = s.t_s - stopped_s;
    }
  }

 private:
  struct Sample {
    double t_s;
    hal::JointVector q_rad;
  };
  const Clock::time_point began_ = Clock::now();
  mutable std::mutex mutex_;
  std::vector<Sample> samples_;
};

/// `colift run --json` as a child that dies with this program.
class Client {
 public:
  explicit Client(const fs::path& folder) : out_(folder / "run.json") {}
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  ~Client() {
    if (pid_ > 0) {
      ::kill(pid_, SIGKILL);
      (void)::waitpid(pid_, nullptr, 0);
    }
    if (pipe_ >= 0) ::close(pipe_);
  }

  hal::Result<> start(const fs::path& robot) {
    const std::string program = (fs::read_symlink("/proc/self/exe").parent_path() / "colift").string();
    const int out = ::open(out_.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0600);
    int ends[2];
    if (out < 0 || ::pipe2(ends, O_CLOEXEC) != 0)
      return hal::failure(hal::ErrorCode::DeviceFault, program, "no file or pipe for its output");
    const std::string file = robot.string();
    const std::array<const char*, 6> words{program.c_str(), "run",        "--json",
                                           "--robot",       file.c_str(), nullptr};
    pid_ = ::fork();
    if (pid_ == 0) {  // nothing but system calls: other threads may hold any lock
      (void)::prctl(PR_SET_PDEATHSIG, SIGKILL);
      (void)::dup2(out, 1);
      (void)::dup2(ends[1], 2);
      (void)::execv(words[0], const_cast<char* const*>(words.data()));
      ::_exit(127);
    }
    ::close(out);
    ::close(ends[1]);
    pipe_ = ends[0];
    if (pid_ < 0) return hal::failure(hal::ErrorCode::DeviceFault, program, "cannot be started");
    return {};
  }

  /// Reads what it says for a while. False: it says nothing any more, it has ended.
  bool listen(double for_s) {
    pollfd fd{pipe_, POLLIN, 0};
    if (::poll(&fd, 1, static_cast<int>(1e3 * for_s)) <= 0) return true;
    std::array<char, 4096> text{};
    const ssize_t n = ::read(pipe_, text.data(), text.size());
    if (n > 0) said_.append(text.data(), static_cast<std::size_t>(n));
    return n > 0;
  }
  [[nodiscard]] bool said(const std::string& words) const { return said_.find(words) != std::string::npos; }

  [[nodiscard]] pid_t pid() const { return pid_; }
  /// The kernel's number of a thread by its name.
  [[nodiscard]] std::optional<pid_t> thread(const std::string& kind, std::uint64_t seed) const {
    if (kind == "task") return pid_;
    std::vector<pid_t> others;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(fmt::format("/proc/{}/task", pid_), ignored)) {
      std::string name;
      std::getline(std::ifstream(entry.path() / "comm") >> std::ws, name);
      const auto tid = static_cast<pid_t>(std::stol(entry.path().filename().string()));
      if (name == kind) return tid;
      if (kind == "other" && tid != pid_ && name != "colift-arm" && name != "colift-hand")
        others.push_back(tid);
    }
    std::sort(others.begin(), others.end());
    if (others.empty()) return std::nullopt;
    return others[seed % others.size()];
  }

  /// Asks it to end as Ctrl-C does, and says how it did.
  void end(StalledRun& run) {
    ::kill(pid_, SIGINT);
    const auto asked = Clock::now();
    int status = 0;
    pid_t ended = 0;
    while ((ended = ::waitpid(pid_, &status, WNOHANG)) == 0 && seconds_since(asked) < kEnd_s)
      (void)listen(0.05);
    if (ended != pid_) {
      run.end = "no end";
      run.because = said_.substr(said_.size() - std::min<std::size_t>(said_.size(), 300));
      return;
    }
    pid_ = -1;
    run.end = WIFEXITED(status) ? fmt::format("exit {}", WEXITSTATUS(status))
                                : fmt::format("signal {}", WTERMSIG(status));
    std::ifstream in(out_);
    const auto document = nlohmann::json::parse(in, nullptr, false);
    if (document.is_discarded()) return;
    run.because = document.value("because", "");
    if (const auto& states = document["states"]; states.is_array() && !states.empty())
      run.end += ", " + states.back().value("state", "");
  }

 private:
  fs::path out_;
  pid_t pid_ = -1;
  int pipe_ = -1;
  std::string said_;
};

/// A folder that goes with the trial.
struct Folder {
  fs::path path = fs::temp_directory_path() / fmt::format("colift-stalls-{}", ::getpid());
  Folder() { fs::create_directories(path); }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
};

fs::path write_robot(const fs::path& folder) {
  const int port = 50100 + 2 * static_cast<int>(::getpid() % 2000);  // campaigns run side by side
  const fs::path file = folder / "robot.yaml";
  std::ofstream(file) << fmt::format(
      "arm: fri\nhand: barrett\ncamera: kinect\nemulator: auto\n"
      "fri: {{address: 127.0.0.1, port: {0}, krc: 127.0.0.1, cycle_ms: 2, script: colift, cpu: -1}}\n"
      "barrett: {{can: \"socketcand:127.0.0.1:{1}/can0\"}}\n"
      "kinect: {{source: \"emulated:@colift-stalls-{0}\", motor: true, latency_ms: 10}}\n",
      port, port + 1);
  return file;
}

bool client_is_ready(tools::EmulatedRig& rig) {
  const auto pucks = rig.pucks()->report().initialised;
  return rig.krc().report().command_cycles > 0 &&
         std::all_of(pucks.begin(), pucks.end(), [](int times) { return times > 0; });
}

/// Stops one thread of a child while the others run on.
bool stop_thread(pid_t tid) {
  if (::ptrace(PTRACE_SEIZE, tid, nullptr, nullptr) != 0) return false;
  if (::ptrace(PTRACE_INTERRUPT, tid, nullptr, nullptr) != 0) return false;
  return ::waitpid(tid, nullptr, __WALL) == tid;
}

}  // namespace

hal::Result<StalledRun> run_stalled(const Stall& stall, std::uint64_t seed) {
  const Folder folder;
  const fs::path robot = write_robot(folder.path);
  const auto file = tools::read_robot_file(robot);
  if (!file) return tl::unexpected(file.error());
  const auto sign = tools::ServedRigSign::put_up(static_cast<std::uint16_t>(file->fri.port));
  if (!sign) return tl::unexpected(sign.error());
  const sim_hal::Scenario scenario = sim_hal::built_in_scenario();
  const auto model = tools::read_model(file->model);
  if (!model) return tl::unexpected(model.error());
  auto world = tools::make_world(*file, scenario, **model, seed);
  if (!world) return tl::unexpected(world.error());
  Motion motion;
  (*world)->observe([&](const sim_hal::TickReport& report) { motion.add(report.truth.q_rad); });
  auto rig = tools::EmulatedRig::start(tools::emulated_rig_of(*file, seed), scenario, **model, *world);
  if (!rig) return tl::unexpected(rig.error());
  struct Stopped {
    tools::EmulatedRig& rig;
    ~Stopped() { rig.stop(); }
  } const stopped{**rig};  // before the motion goes that its world adds to

  Client client(folder.path);
  if (auto done = client.start(robot); !done) return tl::unexpected(done.error());
  StalledRun run;
  bool began = false, alive = true;
  const auto wait = [&](double for_s, const std::string& words) {
    const auto from = Clock::now();
    while (alive && seconds_since(from) < for_s && (words.empty() || !client.said(words))) {
      alive = client.listen(0.01);
      if (began || !client_is_ready(**rig)) continue;
      (*rig)->begin();
      began = true;
    }
    return alive && seconds_since(from) < for_s;
  };
  if (!wait(kReach_s, fmt::format(" s  {} ", stall.state))) {
    run.verdict = "not-reached";
    client.end(run);
    return run;
  }
  (void)wait(stall.delay_s, "");
  const auto tid = client.thread(stall.thread, seed);
  if (!tid || !stop_thread(*tid)) {
    run.verdict = "no-thread";
    client.end(run);
    return run;
  }
  const double stopped_s = motion.now_s();
  (void)wait(stall.held_s, "");
  (void)::ptrace(PTRACE_DETACH, *tid, nullptr, nullptr);
  motion.judge(stopped_s, stall.held_s, run);
  (void)wait(1.0, "");
  client.end(run);
  if (run.speed_rad_s < kMoving_rad_s)
    run.verdict = "at-rest";
  else if (run.gap_s > kMachine_s)
    run.verdict = "machine";
  else if (run.moved_s <= kRestWithin_s)
    run.verdict = "stopped";
  else
    run.verdict = stall.thread == "other" ? "continued" : "late";
  return run;
}

}  // namespace colift::experiments
