#pragma once

// Catch2 of either version: the suites take no side, and whoever runs them brings his own.
#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
#else
#include <catch2/catch.hpp>
#endif
