#include "perception/motion/window_sums.hpp"

#include <algorithm>
#include <cstddef>

namespace colift::perception {

WindowSums window_sums(const InverseDepth& object, int u, int v, const SampledWindow& window) {
  // the samples of a row that are in the image
  int first = -window.u, last = window.u;
  while (u + first < 0) first += window.step_u;
  while (u + last >= object.width) last -= window.step_u;
  const auto middle =
      static_cast<double>(object.values[static_cast<std::size_t>(v) * static_cast<std::size_t>(object.width) +
                                        static_cast<std::size_t>(u)]);
  WindowSums s;
  for (int dv = -window.v; dv <= window.v; dv += window.step_v) {
    if (v + dv < 0 || v + dv >= object.height) continue;
    const float* const row = object.values.data() + static_cast<std::ptrdiff_t>(v + dv) * object.width + u;
    int n = 0, sum_u = 0, sum_uu = 0;
    double w = 0.0, wu = 0.0;
    for (int du = first; du <= last; du += window.step_u) {
      if (!(row[du] > 0)) continue;
      const double d = static_cast<double>(row[du]) - middle;
      ++n;
      sum_u += du;
      sum_uu += du * du;
      w += d;
      wu += d * du;
      s.ww += d * d;
    }
    s.n += n;
    s.u += sum_u;
    s.v += dv * n;
    s.uu += sum_uu;
    s.uv += dv * sum_u;
    s.vv += dv * dv * n;
    s.w += w;
    s.wu += wu;
    s.wv += dv * w;
  }
  return s;
}

}  // namespace colift::perception
