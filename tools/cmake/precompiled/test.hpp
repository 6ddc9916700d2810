// As library.hpp, for the tests.
#include "library.hpp"

#include <catch2/catch.hpp>
