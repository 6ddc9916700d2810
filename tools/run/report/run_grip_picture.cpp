#include "tools/run/report/run_pictures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tools/visualization/palette.hpp"

namespace colift::tools {
namespace {

using picture::Box;
using picture::Canvas;

constexpr double kCell = 26.0, kGap = 3.0, kFinger = 190.0, kTop = 44.0;
constexpr int kWidth = 860, kHeight = 300;
constexpr std::array<const char*, hal::kTactileArrays> kNames{"F1", "F2", "F3", "palm"};
constexpr std::array<int, 4> kPalmRows{5, 7, 7, 5};

bool known(const hal::TactileArray& array) {
  return !std::isnan(array.pressure_n_cm2[0]);
}

// The tip of a finger is up; the palm as seen from the fingers.
Box box_of(std::size_t array, std::size_t cell) {
  const double left = 20.0 + static_cast<double>(array) * kFinger, step = kCell + kGap;
  if (array != hal::kPalmArray) {
    const auto row = 7.0 - static_cast<double>(cell / 3), column = static_cast<double>(cell % 3);
    return {left + column * step, kTop + row * step, kCell, kCell};
  }
  std::size_t first = 0, row = 0;
  while (cell >= first + static_cast<std::size_t>(kPalmRows[row]))
    first += static_cast<std::size_t>(kPalmRows[row++]);
  const double indent = 0.5 * (7 - kPalmRows[row]);
  return {left + (static_cast<double>(cell - first) + indent) * step, kTop + static_cast<double>(row) * step,
          kCell, kCell};
}

}  // namespace

std::vector<std::string> grip_sentences(const control::RunRecord& record) {
  if (!record.grip) return {};
  std::vector<std::string> out{fmt::format("The closed hand: {}.", control::describe(*record.grip))};
  if (record.grip->palm_touches()) out.emplace_back("The object touches the palm.");
  const double margin = record.lift ? control::friction_margin(*record.grip, record.lift->load_n) : NAN;
  if (std::isfinite(margin))
    out.push_back(
        fmt::format("Friction carries {:.1f} times the load of {:.0f} N.", margin, record.lift->load_n));
  return out;
}

std::optional<Canvas> tactile_picture(const control::RunRecord& record) {
  if (!record.grip || std::none_of(record.grip->cells.begin(), record.grip->cells.end(), known))
    return std::nullopt;
  float most = 1.0F;  // N/cm2: a touch is not drawn as the most that there is
  for (const auto& array : record.grip->cells)
    for (const float p : array.pressure_n_cm2) most = std::fmax(most, p);
  Canvas canvas(kWidth, kHeight, picture::kPaper);
  for (std::size_t a = 0; a < record.grip->cells.size(); ++a) {
    const double force = record.grip->contacts[a].force_n;
    const std::string words = std::isnan(force) ? fmt::format("{}: no sensor", kNames[a])
                                                : fmt::format("{}: {:.1f} N", kNames[a], force);
    canvas.text({20.0 + static_cast<double>(a) * kFinger, 28.0}, words,
                {.size = 16.0, .colour = picture::kInk, .bold = true});
    for (std::size_t c = 0; c < hal::kArrayCells; ++c) {
      const float p = record.grip->cells[a].pressure_n_cm2[c];
      const Box box = box_of(a, c);
      if (!std::isnan(p))
        canvas.fill(box, picture::kPanel.towards(picture::kCog, static_cast<double>(p / most)), 3.0);
      canvas.outline(box, {.colour = picture::kRule, .width = 1.0}, 3.0);
    }
  }
  canvas.text({20.0, kHeight - 12.0}, fmt::format("Full colour: {:.1f} N/cm2", static_cast<double>(most)),
              {.size = 14.0, .colour = picture::kSoftInk});
  return canvas;
}

}  // namespace colift::tools
