// A run is asked for its last seconds by another process of the same user.
#include "tools/telemetry/record/flight_request.hpp"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <future>

#include "tests/support/temporary_folder.hpp"

using namespace colift;
using namespace colift::telemetry;

namespace {

/// The folder of the requests is this test's own meanwhile.
struct OwnRuntimeFolder {
  tests::TemporaryFolder folder;
  OwnRuntimeFolder() { ::setenv("XDG_RUNTIME_DIR", folder.path().c_str(), 1); }
  ~OwnRuntimeFolder() { ::unsetenv("XDG_RUNTIME_DIR"); }
  OwnRuntimeFolder(const OwnRuntimeFolder&) = delete;
  OwnRuntimeFolder& operator=(const OwnRuntimeFolder&) = delete;
};

}  // namespace

TEST_CASE("a run that is announced is asked, and answers once it has written the file") {
  const OwnRuntimeFolder own;
  auto post = FlightPost::open();
  REQUIRE(post);
  const auto file = own.folder.path() / "flight.mcap";
  auto asks = std::async(std::launch::async, [&] { return ask_for_flight(file, std::nullopt, 20.0); });
  std::optional<std::filesystem::path> asked;
  while (!asked) asked = post->asked();
  CHECK(*asked == file);
  std::ofstream(file) << "seconds";
  CHECK_FALSE(post->asked());
  CHECK(asks.get());
}

TEST_CASE("what a killed run has left behind is no run, even when its number is another process's today") {
  const OwnRuntimeFolder own;
  std::filesystem::create_directory(own.folder.path() / "colift");
  const auto left = own.folder.path() / "colift" / "run-1";
  std::ofstream(left) << "1\n";
  const auto asked = ask_for_flight(own.folder.path() / "flight.mcap", 1, 0.1);
  REQUIRE_FALSE(asked);
  CHECK(asked.error().code == hal::ErrorCode::NotFound);
  const auto post = FlightPost::open();
  CHECK(post);
  CHECK_FALSE(std::filesystem::exists(left));
}
