#include "tools/experiments/experiment.hpp"

#include "sim_hal/synthetic/hash_random.hpp"

namespace colift::experiments {

std::uint64_t Trial::own_seed(std::uint64_t stream) const {
  return sim_hal::hash(seed, 6000 + stream, static_cast<std::uint64_t>(index));
}

const std::vector<Experiment>& all_experiments() {
  static const std::vector<Experiment> all{
      grasps_experiment(),      realtime_experiment(),  tilt_experiment(),       load_experiment(),
      complex_experiment(),     robust_experiment(),    wrong_cog_experiment(),  slip_experiment(),
      tasks_experiment(),       agents_experiment(),    let_go_experiment(),     people_experiment(),
      false_stops_experiment(), fingers_experiment(),   faults_experiment(),     stalls_experiment(),
      share_experiment(),       mass_experiment(),      lift_alone_experiment(), rooms_experiment(),
      stances_experiment(),     imperfect_experiment(), impedance_experiment(),  certificate_experiment(),
      views_experiment(),       furniture_experiment(), candidates_experiment(), hidden_hand_experiment()};
  return all;
}

const Experiment* find_experiment(const std::string& name) {
  for (const Experiment& e : all_experiments())
    if (e.name == name) return &e;
  return nullptr;
}

}  // namespace colift::experiments
