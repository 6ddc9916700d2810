#include "tools/doctor/doctor_usb_capture.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "hal/drivers/capture_link/capture_process.hpp"
#include "hal/types/time.hpp"

namespace colift::tools {
namespace {

using namespace std::chrono_literals;
using Verdict = DoctorRow::Verdict;

constexpr auto kTimeout = 2s;

}  // namespace

CaptureAnswer ask_capture(const std::filesystem::path& program) {
  const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);  // in place of the frames' memory
  auto process = hal::capture::CaptureProcess::start({program.string(), {"--probe"}, {}}, nothing);
  if (nothing >= 0) ::close(nothing);
  if (!process) return {false, process.error().detail};
  hal::capture::CaptureNews news;
  const hal::SteadyClock clock;
  const hal::Timestamp end = clock.now() + kTimeout;
  while (process->exists()) {
    if (clock.now() > end) return {false, "it does not answer"};
    process->wait(20ms);
    process->listen(news);
  }
  process->listen(news);
  const bool fine = process->ended() == "status 0";
  return {fine, news.last_words.empty() ? "it ended with " + process->ended() : news.last_words};
}

DoctorRows capture_rows(const std::filesystem::path& program, bool wanted, const AskCapture& ask) {
  const Verdict without = wanted ? Verdict::Bad : Verdict::Warn;
  const std::string name = program.filename().string();
  std::error_code none;
  if (!std::filesystem::is_regular_file(program, none))
    return {
        {"capture process",
         fmt::format("{} is not beside this program ({})", name, program.parent_path().string()), without,
         "sudo apt install libfreenect-dev, then build with -DCOLIFT_KINECT=ON; or install CoLift whole"}};
  const CaptureAnswer answer = ask(program);
  if (answer.fine) return {{"capture process", fmt::format("{}, libfreenect: {}", name, answer.words)}};
  return {{"capture process", fmt::format("{} does not start: {}", name, answer.words), without,
           fmt::format("sudo apt install libfreenect0.5; ldd {}", program.string())}};
}

}  // namespace colift::tools
