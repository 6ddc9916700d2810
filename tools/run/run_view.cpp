#include "tools/run/run_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace colift::tools {
namespace {

using control::Task;

struct Stretch {
  double from = 0.0, to = 0.0;
};

// When the last stretch of a state was; open at its end where the run ended in it.
std::optional<Stretch> last_stretch(const control::RunRecord& record, Task state) {
  std::optional<Stretch> found;
  for (std::size_t i = 0; i < record.states.size(); ++i) {
    if (record.states[i].state != state) continue;
    found = Stretch{hal::seconds(record.states[i].at), std::numeric_limits<double>::infinity()};
    if (i + 1 < record.states.size()) found->to = hal::seconds(record.states[i + 1].at);
  }
  return found;
}

class Mean {
 public:
  void add(double value) {
    if (!std::isfinite(value)) return;
    sum_ += value;
    ++count_;
  }
  [[nodiscard]] double value() const { return count_ ? sum_ / count_ : std::nan(""); }

 private:
  double sum_ = 0.0;
  int count_ = 0;
};

}  // namespace

const char* word(control::RunRecord::Result outcome) {
  using Result = control::RunRecord::Result;
  switch (outcome) {
    case Result::Lifted:
      return "lifted";
    case Result::Aborted:
      return "aborted";
    case Result::Refused:
      return "refused";
  }
  return "?";
}

double true_share(const TruthSample& s) {
  const double all = s.robot_force_z_n + s.partner_force_z_n + s.floor_force_z_n;
  if (!(all > 1e-3) || s.floor_force_z_n > 0.1 * all) return std::nan("");
  return s.robot_force_z_n / all;
}

std::optional<TrueLift> true_lift(const RunView& view) {
  if (!view.truth) return std::nullopt;
  std::optional<Stretch> top = last_stretch(view.record, Task::Hold);
  if (!top) {
    top = last_stretch(view.record, Task::Lift);
    if (!top) return std::nullopt;
    if (!std::isfinite(top->to) && !view.truth->curve.empty()) top->to = view.truth->curve.back().t_s;
    top->from = top->to - 0.1 * (top->to - top->from);
  }
  Mean height, tilt, share, slip;
  bool any = false;
  for (const TruthSample& s : view.truth->curve) {
    if (s.t_s < top->from || s.t_s > top->to) continue;
    any = true;
    height.add(s.height_m);
    tilt.add(s.tilt_rad);
    share.add(true_share(s));
    slip.add(s.slip_m);
  }
  if (!any) return std::nullopt;
  return TrueLift{height.value(), tilt.value(), share.value(), slip.value()};
}

std::optional<double> partner_error_m(const RunView& view) {
  const auto& decision = view.record.decision;
  if (!decision || !decision->partner || !view.truth || !view.truth->partner) return std::nullopt;
  return (decision->partner->position - *view.truth->partner).norm();
}

}  // namespace colift::tools
