#include "tools/recover/stopped_run.hpp"

#include <nlohmann/json.hpp>

#include "hal/types/units.hpp"
#include "tools/cli/interrupt.hpp"
#include "tools/recover/cmd_recover.hpp"
#include "tools/recover/operator.hpp"
#include "tools/recover/recover_json.hpp"

namespace colift::tools {

std::string recover_stopped_run(Rig& rig, const Setup& setup, std::uint64_t seed, hal::Timestamp began,
                                bool quiet) {
  using Json = nlohmann::ordered_json;
  Json truth = Json::array();
  // the signal that stopped the run has done its work: a second one ends the program
  control::RecoveryHooks hooks = confirm_everything([] { return false; }, quiet);
  hooks.confirm = [&, ask = hooks.confirm](control::RecoveryStep step, const std::string& what) {
    if (rig.truth) {
      const TruthSample s = rig.truth->sample(began);
      truth.push_back({{"before", control::word(step)},
                       {"robot_force_z_n", s.robot_force_z_n},
                       {"partner_force_z_n", s.partner_force_z_n},
                       {"floor_force_z_n", s.floor_force_z_n},
                       {"object_height_m", s.height_m},
                       {"tilt_deg", hal::rad_to_deg(s.tilt_rad)}});
    }
    return ask(step, what);
  };
  Json document = Json::parse(recover_document(recover_rig(rig, setup, seed, hooks)));
  document["truth"] = truth;
  return document.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace colift::tools
