// A run that is asked to end, in every phase: Ctrl-C, SIGTERM, SIGHUP, a terminal or a pipe that is closed.
// The arm stops, the result is complete, the recording is readable to its end.

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "run_program.hpp"

using namespace story;

namespace {

/// `colift ARGUMENTS` with its stderr in a pipe, stdout in a file.
class Started {
 public:
  explicit Started(std::vector<std::string> arguments, bool ignore_hup = false) {
    std::array<int, 2> ends{};
    REQUIRE(::pipe(ends.data()) == 0);
    pid_ = ::fork();
    if (pid_ == 0) {
      if (ignore_hup) ::signal(SIGHUP, SIG_IGN);
      const int out = ::open((scratch() / "out").c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0644);
      ::dup2(out, STDOUT_FILENO);
      ::dup2(ends[1], STDERR_FILENO);
      ::close(ends[0]);
      std::vector<char*> argv;
      std::string program = COLIFT_PROGRAM;
      argv.push_back(program.data());
      for (std::string& a : arguments) argv.push_back(a.data());
      argv.push_back(nullptr);
      ::execv(COLIFT_PROGRAM, argv.data());
      ::_exit(127);
    }
    ::close(ends[1]);
    from_ = ends[0];
  }
  ~Started() { close_pipe(); }
  Started(const Started&) = delete;
  Started& operator=(const Started&) = delete;

  /// Reads its lines until one is about this state. False: it ended before.
  bool wait_for(const std::string& state) {
    std::string line;
    for (char c = 0; ::read(from_, &c, 1) == 1;) {
      if (c != '\n') {
        line += c;
        continue;
      }
      if (line.find(" s  " + state + " ") != std::string::npos) return true;
      line.clear();
    }
    return false;
  }
  void send(int signal) const { ::kill(pid_, signal); }
  void close_pipe() {
    if (from_ >= 0) ::close(from_);
    from_ = -1;
  }
  /// Its exit code; 128 and the signal that killed it.
  int end() {
    // what it says meanwhile has to go somewhere
    for (std::array<char, 4096> text{}; from_ >= 0 && ::read(from_, text.data(), text.size()) > 0;) {
    }
    int status = 0;
    ::waitpid(pid_, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

 private:
  pid_t pid_ = -1;
  int from_ = -1;
};

std::vector<std::string> recorded_run(const std::filesystem::path& file) {
  // paced, so that the signal comes in the phase that it is meant for
  return {"run", "--json", "--seed", "1", "--speed", "2", "--record", file.string()};
}

void check_stopped_well(int code, const std::string& state, const std::filesystem::path& file) {
  CHECK(code == 130);
  const auto result = nlohmann::json::parse(slurp(scratch() / "out"), nullptr, false);
  REQUIRE_FALSE(result.is_discarded());
  CHECK(result["outcome"] == "aborted");
  CHECK(result["states"].back()["state"] == "stopped");
  CHECK(result["states"][result["states"].size() - 2]["state"] == state);
  const ProgramRun info = run_colift("log info --json " + file.string());
  CHECK(info.code == 0);
  const auto recording = nlohmann::json::parse(info.out, nullptr, false);
  REQUIRE_FALSE(recording.is_discarded());
  CHECK(recording["complete"] == true);
}

}  // namespace

TEST_CASE("a signal in any phase is a controlled stop", "[interrupted]") {
  const auto [state, signal] = GENERATE(table<std::string, int>({{"approach", SIGHUP},
                                                                 {"close", SIGINT},
                                                                 {"lift", SIGTERM},
                                                                 {"hold", SIGHUP},
                                                                 {"lower", SIGINT},
                                                                 {"retreat", SIGTERM}}));
  CAPTURE(state, signal);
  const auto file = scratch() / (state + ".mcap");
  Started run(recorded_run(file));
  REQUIRE(run.wait_for(state));
  run.send(signal);
  check_stopped_well(run.end(), state, file);
}

TEST_CASE("a closed terminal is a controlled stop: nobody reads what the run says", "[interrupted]") {
  const std::string state = GENERATE("approach", "lift", "retreat");
  CAPTURE(state);
  const auto file = scratch() / (state + "-closed.mcap");
  Started run(recorded_run(file));
  REQUIRE(run.wait_for(state));
  run.close_pipe();
  check_stopped_well(run.end(), state, file);
}

TEST_CASE("a terminal that hangs up several times still gets a controlled stop", "[interrupted]") {
  const auto file = scratch() / "twice.mcap";
  Started run(recorded_run(file));
  REQUIRE(run.wait_for("lift"));
  run.send(SIGHUP);
  run.send(SIGHUP);
  check_stopped_well(run.end(), "lift", file);
}

TEST_CASE("under nohup a hang-up is nothing", "[interrupted]") {
  Started run({"run", "--json", "--seed", "1"}, /*ignore_hup=*/true);
  REQUIRE(run.wait_for("approach"));
  run.send(SIGHUP);
  CHECK(run.end() == 0);
}

TEST_CASE("a run that was stopped while the object hung in the air is recovered: set down, released, home",
          "[interrupted][recover]") {
  const std::string state = GENERATE("approach", "lift", "hold");
  CAPTURE(state);
  Started run({"run", "--json", "--seed", "1", "--speed", "2", "--recover"});
  REQUIRE(run.wait_for(state));
  run.send(SIGINT);
  CHECK(run.end() == 130);
  const auto result = nlohmann::json::parse(slurp(scratch() / "out"), nullptr, false);
  REQUIRE_FALSE(result.is_discarded());
  const auto& recovery = result["recovery"];
  CAPTURE(recovery.dump());
  CHECK(recovery["outcome"] == "recovered");
  CHECK(recovery["before"]["hand"] == (state == "approach" ? "open" : "holds"));
  constexpr double kWeight_n = 4.0 * 9.81;
  for (const auto& truth : recovery["truth"])
    if (truth["before"] == "release") CHECK(truth["floor_force_z_n"].get<double>() > 0.9 * kWeight_n);
}
