#pragma once

#include "sim_hal/emulator/krc/krl_script.hpp"

namespace colift::sim_hal {

[[nodiscard]] std::unique_ptr<KrlScript> make_colift_script(const KrlScriptConfig& config);
[[nodiscard]] std::unique_ptr<KrlScript> make_stanford_script(const KrlScriptConfig& config);
[[nodiscard]] std::unique_ptr<KrlScript> make_cep_script(const KrlScriptConfig& config);
[[nodiscard]] std::unique_ptr<KrlScript> make_tum_script(const KrlScriptConfig& config);
[[nodiscard]] std::unique_ptr<KrlScript> make_vendor_script(const KrlScriptConfig& config);
[[nodiscard]] std::unique_ptr<KrlScript> make_openkc_script(const KrlScriptConfig& config);

}  // namespace colift::sim_hal
