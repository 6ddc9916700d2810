// As library.hpp, for the program: it writes JSON in many places.
#include "library.hpp"

#include <nlohmann/json.hpp>
