#include "hal/config/config_file.hpp"
#include "planner/hand/hand_model.hpp"

namespace colift::planner {

hal::Result<HandModel> load_hand(const std::filesystem::path& file) {
  auto hand = hal::load_yaml<HandModel>(file);
  if (!hand) return hand;
  if (const auto fits = check_hand(*hand); !fits) {
    return hal::failure(fits.error().code, file.string(), fits.error().detail);
  }
  return hand;
}

}  // namespace colift::planner
