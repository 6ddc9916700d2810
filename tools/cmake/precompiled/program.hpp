// As library.hpp, for the programs: they write JSON in many places, and their command lines are parsed by CLI11.
#include "library.hpp"

#include <CLI/App.hpp>
#include <nlohmann/json.hpp>
