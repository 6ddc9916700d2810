#include "tools/experiments/trials/room_sheet.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tools/experiments/trials/seen_room.hpp"
#include "tools/visualization/palette.hpp"

namespace colift::experiments {
namespace {

constexpr int kThumbWidth = 320, kThumbHeight = 240, kCaption = 34, kColumns = 4, kRows = 4;

std::vector<std::uint8_t> thumbnail(const SeenRoom& seen) {
  const perception::OrganisedCloud& cloud = seen.analysis.cloud;
  std::vector<bool> taken(cloud.size(), false);
  if (seen.analysis.scene.target) {
    for (const Eigen::Vector3f& p : seen.analysis.scene.target->points) {
      const auto at = cloud.project(p.cast<double>());
      if (cloud.contains(at.u, at.v))
        taken[static_cast<std::size_t>(std::lround(at.v)) * static_cast<std::size_t>(cloud.width()) +
              static_cast<std::size_t>(std::lround(at.u))] = true;
    }
  }
  std::vector<std::uint8_t> rgb;
  rgb.reserve(3 * kThumbWidth * kThumbHeight);
  for (int y = 0; y < kThumbHeight; ++y) {
    for (int x = 0; x < kThumbWidth; ++x) {
      const auto i = static_cast<std::size_t>(y * cloud.height() / kThumbHeight) *
                         static_cast<std::size_t>(cloud.width()) +
                     static_cast<std::size_t>(x * cloud.width() / kThumbWidth);
      auto c = picture::depth_rgb(static_cast<double>(cloud.depth_m[i]));
      if (cloud.seen(i)) {
        if (seen.truth.label[i] == sim_hal::Label::Target) c[2] = std::min(255.0, c[2] + 90);
        if (seen.truth.label[i] == sim_hal::Label::Partner) c[0] = std::min(255.0, c[0] + 90);
        if (taken[i]) c[1] = 220;
      }
      for (const double v : c) rgb.push_back(static_cast<std::uint8_t>(v));
    }
  }
  return rgb;
}

}  // namespace

Estimate verdict_share(const Results& r, const std::string& column, const std::string& value,
                       const std::vector<std::string>& verdicts) {
  int all = 0, hits = 0;
  for (const Row& row : r.trials.rows()) {
    if (!value.empty() && r.trials.text(row, column) != value) continue;
    ++all;
    hits += std::count(verdicts.begin(), verdicts.end(), r.trials.text(row, "verdict")) > 0 ? 1 : 0;
  }
  return rate(hits, all);
}

picture::Canvas room_sheet(const Results& r, const std::function<sim_hal::RandomRoom(std::uint64_t)>& make) {
  picture::Canvas canvas(kColumns * kThumbWidth, kRows * (kThumbHeight + kCaption), picture::kPaper);
  int k = 0;
  for (const char* verdict : {"person", "wrong", "partly", "nothing", "right"}) {
    for (const Row& row : r.trials.rows()) {
      if (k == kColumns * kRows) return canvas;
      if (r.trials.text(row, "verdict") != verdict) continue;
      if (verdict == std::string("nothing") && r.trials.text(row, "class") != "solvable") continue;
      const std::uint64_t seed = std::stoull(r.trials.text(row, "seed"));
      const auto method =
          r.trials.text(row, "method") == "thesis" ? control::Method::Thesis : control::Method::Fast;
      const SeenRoom seen = see_room(make(seed), seed, method);
      const int x = k % kColumns * kThumbWidth, y = k / kColumns * (kThumbHeight + kCaption);
      canvas.image(x, y, kThumbWidth, kThumbHeight, thumbnail(seen));
      picture::TextStyle small;
      small.size = 11.0;
      const picture::Canvas::Clip clip(canvas, {static_cast<double>(x), static_cast<double>(y),
                                                kThumbWidth - 4.0, kThumbHeight + kCaption + 0.0});
      canvas.text({x + 3.0, y + kThumbHeight + 13.0},
                  fmt::format("{}: {}, {}", TrialTable::trial_of(row), verdict, r.trials.text(row, "class")),
                  small);
      canvas.text({x + 3.0, y + kThumbHeight + 27.0}, r.trials.text(row, "room"), small);
      ++k;
    }
  }
  return canvas;
}

}  // namespace colift::experiments
