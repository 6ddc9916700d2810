#pragma once

#include <memory>

#include "control/session/decide.hpp"
#include "tools/analyse/recorded_scene.hpp"
#include "tools/python/bindings.hpp"

namespace colift::python {

/// A configuration and what it names, made once for many frames.
struct PySetup {
  std::shared_ptr<const tools::Setup> setup;
};

/// What one look found. What it points to is never changed: own candidates make a new one, so other threads
/// and earlier outcomes keep theirs.
struct PyAnalysis {
  std::shared_ptr<const tools::Setup> setup;
  std::shared_ptr<const tools::Seen> seen;
};

/// A decision, with what it rests on.
struct PyOutcome {
  std::shared_ptr<const tools::Setup> setup;
  std::shared_ptr<const tools::Seen> seen;
  control::Outcome outcome;
};

}  // namespace colift::python
