#include <fmt/format.h>

#include <algorithm>

#include "tools/calibrate/calibrate.hpp"
#include "tools/visualization/canvas.hpp"
#include "tools/visualization/palette.hpp"

namespace colift::tools {
namespace {

using namespace picture;

constexpr double kMargin = 30, kTop = 90, kBars = 190, kLonger = 20.0;
constexpr Colour kOut = rgb(0xD55E00);

}  // namespace

hal::Result<> write_calibration_picture(const std::filesystem::path& file, const CalibrationView& view) {
  const auto& k = view.set->camera;
  const int width = k.width + static_cast<int>(2 * kMargin);
  const int height = k.height + static_cast<int>(kTop + kBars);
  Canvas canvas(width, height, kPaper);
  const bool good = view.refused_kind.empty();
  canvas.text({kMargin, 34}, good ? "Calibration: accepted" : "Calibration: refused",
              {.size = 22, .colour = good ? kRobot : kOut, .bold = true});
  const auto lines = canvas.wrap(view.reason, k.width, {.size = 14});
  for (std::size_t i = 0; i < std::min<std::size_t>(2, lines.size()); ++i)
    canvas.text({kMargin, 58 + 20.0 * static_cast<double>(i)}, lines[i], {.size = 14, .colour = kSoftInk});

  const Box frame{kMargin, kTop, static_cast<double>(k.width), static_cast<double>(k.height)};
  canvas.fill(frame, kMissing);
  const auto& set = *view.set;
  {
    const Canvas::Clip clip(canvas, frame);
    for (std::size_t i = 0; i < set.samples.size(); ++i) {
      const Px at = Px(kMargin, kTop) + set.samples[i].pixel;
      const auto* v = view.solved && i < view.solved->samples.size() ? &view.solved->samples[i] : nullptr;
      const Colour colour = !v ? kWhite : v->inlier ? kTarget : kOut;
      if (v && v->residual_px.allFinite()) {
        const Px tip = at + kLonger * v->residual_px.cwiseMax(-50.0).cwiseMin(50.0);
        canvas.line(at, tip, {.colour = colour, .width = 1.8});
      }
      canvas.circle(at, 4.5, {.colour = colour, .width = 1.8});
      canvas.text(at + Px(7, -5), fmt::format("{}", set.index[i]), {.size = 11, .colour = kWhite});
    }
  }
  canvas.text({kMargin + 8, kTop + k.height - 10},
              "spots; a line is where the result puts the spot, 20 times as far",
              {.size = 12, .colour = kWhite});

  // bars: residual and the residual of the solution without the pose
  const double base = kTop + k.height + kBars - 34, tall = kBars - 80;
  canvas.text({kMargin, kTop + k.height + 24},
              "Residual of each pose (px); the thin bar: predicted by the others",
              {.size = 14, .colour = kInk});
  if (view.solved && !view.solved->samples.empty()) {
    double most = 0.5;
    for (const auto& v : view.solved->samples)
      if (v.inlier) most = std::max(most, v.held_out_px);
    const double step = static_cast<double>(k.width) / static_cast<double>(view.solved->samples.size());
    for (std::size_t i = 0; i < view.solved->samples.size(); ++i) {
      const auto& v = view.solved->samples[i];
      const double x = kMargin + step * static_cast<double>(i);
      const double whole = std::min(1.0, (v.residual_px.allFinite() ? v.residual_px.norm() : 1e9) / most);
      const double held = std::min(1.0, v.held_out_px / most);
      canvas.fill(Box{x + 0.15 * step, base - tall * whole, 0.45 * step, tall * whole},
                  v.inlier ? kRobot : kOut);
      canvas.fill(Box{x + 0.65 * step, base - tall * held, 0.15 * step, tall * held}, kSoftInk);
    }
    canvas.text({kMargin + k.width, kTop + k.height + 24}, fmt::format("full height {:.2f} px", most),
                {.size = 12, .colour = kSoftInk, .align = Align::Right});
  }
  canvas.line({kMargin, base}, {kMargin + k.width, base}, {.colour = kInk});
  return canvas.write_png(file);
}

}  // namespace colift::tools
