#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace colift::hal {

/// What a caller can do something about. A new code needs a new reaction, not a new wording.
enum class ErrorCode {
  Timeout,        ///< Nothing arrived before the deadline; asking again may help.
  LinkLost,       ///< The device is gone; configure() again.
  BadReply,       ///< The device answered something that cannot be.
  DeviceFault,    ///< The device says of itself that it is broken.
  LimitExceeded,  ///< The request breaks a limit; nothing was done.
  NotReady,       ///< The call does not fit the state.
  BadConfig,      ///< A configuration value or file is wrong; a person has to mend it.
  BadInput,       ///< An input file or argument is wrong; a person has to mend it.
  NotFound,       ///< The scene does not hold what was looked for; not an error of anyone's.
};

/// An error that a running robot lives with: what, where, and one sentence with the numbers.
struct Error {
  ErrorCode code;
  std::string where;   ///< Device and operation ("hand.f2.read_position") or place in a file ("a.pcd:3").
  std::string detail;  ///< One sentence with what was found and what was expected.

  [[nodiscard]] std::string text() const { return where + ": " + detail; }
};

template <class T = void>
using Result = tl::expected<T, Error>;

[[nodiscard]] inline tl::unexpected<Error> failure(ErrorCode code, std::string where, std::string detail) {
  return tl::unexpected<Error>(Error{code, std::move(where), std::move(detail)});
}

}  // namespace colift::hal
