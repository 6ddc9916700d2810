#include "tools/run/enter_key.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <string_view>
#include <thread>

using colift::tools::EnterKey;

namespace {

/// A terminal, and the person in front of it.
struct Terminal {
  Terminal() : person(::posix_openpt(O_RDWR | O_NOCTTY)) {
    REQUIRE(person >= 0);
    REQUIRE(::grantpt(person) == 0);
    REQUIRE(::unlockpt(person) == 0);
    input = ::open(::ptsname(person), O_RDWR | O_NOCTTY);
    REQUIRE(input >= 0);
  }
  ~Terminal() {
    ::close(person);
    ::close(input);
  }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  void type(std::string_view keys) const {
    REQUIRE(::write(person, keys.data(), keys.size()) == static_cast<ssize_t>(keys.size()));
  }

  int person, input = -1;
};

bool taken_soon(EnterKey& key) {
  for (int i = 0; i < 200; ++i) {
    if (key.take()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

}  // namespace

TEST_CASE("Enter at the terminal is taken once, and other keys are not Enter", "[run]") {
  const Terminal terminal;
  EnterKey key(terminal.input);
  CHECK(key.is_there());
  CHECK_FALSE(key.take());
  terminal.type("yes");
  CHECK_FALSE(key.take());
  terminal.type("\n");
  CHECK(taken_soon(key));
  CHECK_FALSE(key.take());
  terminal.type("\n\n\n");
  CHECK(taken_soon(key));
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  (void)key.take();  // what was still on its way
  CHECK_FALSE(key.take());
}

TEST_CASE("without a terminal nobody presses anything", "[run]") {
  int ends[2];
  REQUIRE(::pipe(ends) == 0);
  REQUIRE(::write(ends[1], "\n", 1) == 1);
  EnterKey key(ends[0]);
  CHECK_FALSE(key.is_there());
  CHECK_FALSE(key.take());
  ::close(ends[0]);
  ::close(ends[1]);
}
