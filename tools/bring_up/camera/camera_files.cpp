#include "tools/bring_up/camera/camera_files.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/visualization/file_output.hpp"

namespace colift::tools {
namespace {

std::string noise_yaml(const perception::MeasuredNoise& n) {
  return fmt::format(
      "# colift hal camera noise: {} frames, {} flat blocks of 16 x 16 pixels from {:.2f} to {:.2f} m,\n"
      "# model off by {:.0f} % (root mean square over bins of depth). For --config.\n"
      "noise:\n  sigma0_m: {:.6f}\n  sigma2_per_m: {:.6f}\n  step2_per_m: {:.6f}\n",
      n.frames, n.blocks, n.nearest_m, n.farthest_m, 100 * n.misfit, n.model.sigma0_m, n.model.sigma2_per_m,
      n.model.step2_per_m);
}

}  // namespace

int say_noise(const CommonOptions& common, const std::optional<std::filesystem::path>& out,
              const hal::Result<perception::MeasuredNoise>& noise, const perception::NoiseModel& configured) {
  const char* const where = "hal camera noise";
  if (!noise) return report_error(where, noise.error());
  if (!common.quiet) {
    std::fprintf(stderr,
                 "noise at 1 m %.1f mm (configured %.1f), at 2 m %.1f mm (%.1f), at 3 m %.1f mm (%.1f)\n",
                 1e3 * noise->model.sigma(1.0), 1e3 * configured.sigma(1.0), 1e3 * noise->model.sigma(2.0),
                 1e3 * configured.sigma(2.0), 1e3 * noise->model.sigma(3.0), 1e3 * configured.sigma(3.0));
    for (const std::string& doubt : noise->doubts) std::fprintf(stderr, "doubt: %s\n", doubt.c_str());
  }
  const std::string yaml = noise_yaml(*noise);
  if (!out) {
    if (!common.json) std::fputs(yaml.c_str(), stdout);
    return kDone;
  }
  if (auto written =
          picture::write_file(*out, {reinterpret_cast<const std::uint8_t*>(yaml.data()), yaml.size()});
      !written)
    return report_error(where, written.error());
  if (!common.quiet) std::fprintf(stderr, "noise model: %s, for --config\n", out->c_str());
  return kDone;
}

std::string with_noise(const std::string& document, const std::optional<perception::MeasuredNoise>& noise) {
  if (!noise) return document;
  auto j = nlohmann::ordered_json::parse(document);
  j["noise"] = {{"sigma0_m", noise->model.sigma0_m},
                {"sigma2_per_m", noise->model.sigma2_per_m},
                {"step2_per_m", noise->model.step2_per_m},
                {"frames", noise->frames},
                {"blocks", noise->blocks},
                {"nearest_m", noise->nearest_m},
                {"farthest_m", noise->farthest_m},
                {"misfit", noise->misfit},
                {"doubts", noise->doubts}};
  return j.dump();
}

}  // namespace colift::tools
