#include "tools/doctor/doctor_usb_capture.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "hal/drivers/capture_link/capture_process.hpp"
#include "hal/drivers/openni2_camera/openni2_source.hpp"
#include "hal/types/time.hpp"

namespace colift::tools {
namespace {

using namespace std::chrono_literals;
using Verdict = DoctorRow::Verdict;

constexpr auto kTimeout = 2s;

CaptureAnswer ask(const hal::capture::CaptureCall& call) {
  const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);  // in place of the frames' memory
  auto process = hal::capture::CaptureProcess::start(call, nothing);
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

}  // namespace

CaptureAnswer ask_capture(const std::filesystem::path& program) {
  return ask({program.string(), {"--probe"}, {}});
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

DoctorRows openni2_rows(const hal::Openni2CameraConfig& config) {
  constexpr auto kWhat = "OpenNI2";
  const auto source = hal::openni2::find_source(config);
  if (!source)
    return {
        {kWhat, source.error().detail, Verdict::Bad,
         "sudo apt install libopenni2-dev, then build with -DCOLIFT_OPENNI2=ON; or look at openni2 in the "
         "robot file"}};
  hal::capture::CaptureCall call = source->call;
  call.arguments = {"--probe"};
  const CaptureAnswer answer = ask(call);
  const std::string name = std::filesystem::path(call.program).filename().string();
  if (!answer.fine)
    return {{kWhat, fmt::format("{} does not start: {}", name, answer.words), Verdict::Bad,
             fmt::format("sudo apt install libopenni2-0; ldd {}", call.program)}};
  // of a recording only the library is asked for
  const bool missing = source->kind != hal::openni2::Source::Kind::File &&
                       answer.words.find(", 0 devices") != std::string::npos;
  if (missing)
    return {{kWhat, fmt::format("{}: {}", name, answer.words), Verdict::Warn,
             "plug it in; lsusb; a maker's driver belongs into OpenNI2/Drivers beside libOpenNI2.so.0, as "
             "lib*.so.0"}};
  return {{kWhat, fmt::format("{}: {}", name, answer.words)}};
}

}  // namespace colift::tools
