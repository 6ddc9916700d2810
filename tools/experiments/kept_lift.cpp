#include "tools/experiments/kept_lift.hpp"

#include <fmt/format.h>

#include "sim_hal/scenario/scenario_text.hpp"
#include "tools/visualization/file_output.hpp"

namespace colift::experiments {

hal::Result<std::filesystem::path> keep_lift(const KeptLift& lift, control::Method method,
                                             const std::filesystem::path& folder, const std::string& name) {
  const std::filesystem::path file = folder / (name + ".yaml");
  const std::string text =
      fmt::format("# colift run --scenario {} --seed {} --method {}{}\n{}", file.filename().string(),
                  lift.seed, control::to_string(method), lift.rig.empty() ? "" : " --rig " + lift.rig,
                  sim_hal::yaml_of(lift.scenario));
  if (auto ok = picture::write_file(file, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
      !ok)
    return tl::unexpected(ok.error());
  return file;
}

}  // namespace colift::experiments
