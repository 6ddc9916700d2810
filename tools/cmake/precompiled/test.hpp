// As library.hpp, for the tests.
#include "library.hpp"

// a tenth less to compile: what an assertion throws ends its test case, as it does anyway
#define CATCH_CONFIG_FAST_COMPILE
#include <catch2/catch.hpp>
