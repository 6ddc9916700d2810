#include <catch2/catch.hpp>

#include "tools/cli/options.hpp"
#include "tools/cli/session.hpp"

using namespace colift;
using hal::ErrorCode;

TEST_CASE("an error ends a command with the exit code of its kind", "[program]") {
  const auto code = [](ErrorCode error) { return tools::report_error("test", {error, "there", "why"}); };
  for (const ErrorCode input : {ErrorCode::BadConfig, ErrorCode::BadInput})
    CHECK(code(input) == tools::kBadInput);
  CHECK(code(ErrorCode::NotFound) == tools::kNoGoal);
  for (const ErrorCode device : {ErrorCode::Timeout, ErrorCode::LinkLost, ErrorCode::BadReply,
                                 ErrorCode::DeviceFault, ErrorCode::NotReady})
    CHECK(code(device) == tools::kDeviceFailed);
  CHECK(code(ErrorCode::LimitExceeded) == tools::kInternal);
}
