#pragma once

#include <optional>
#include <string_view>

namespace colift::control {

struct Config;

/// How CoLift sees and decides: its own methods, or those of the thesis. What differs is made by
/// make_pipeline() and set_method_defaults(); nothing else asks which one it is, but to say so.
enum class Method { Fast, Thesis };

/// "fast" or "thesis", as in Config::method, options and documents.
[[nodiscard]] const char* to_string(Method method);
[[nodiscard]] std::optional<Method> method_named(std::string_view name);

/// Writes what goes with a method over a command's defaults, before anything that a person says. For the
/// thesis: its weights of effort, nothing refused that it does not refuse (sections 4.3, 5.3.4), its
/// candidates (5.3.2), and a tracker that suits the noise and the rate of its partner's grasp. Nothing for
/// the fast one, which is what the defaults are made for.
void set_method_defaults(Method method, Config& config);

}  // namespace colift::control
