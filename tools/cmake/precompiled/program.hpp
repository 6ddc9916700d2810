// As library.hpp, for the programs: they write JSON in many places, and CLI11 parses their command lines.
#include "library.hpp"

#include <CLI/App.hpp>
#include <nlohmann/json.hpp>
