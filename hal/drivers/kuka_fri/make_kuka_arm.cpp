#include "hal/drivers/kuka_fri/make_kuka_arm.hpp"

#include "hal/drivers/kuka_fri/fri_arm.hpp"

namespace colift::hal {

Result<std::unique_ptr<Arm>> make_kuka_arm(const FriConfig& config, const Clock& clock) {
  auto arm = make_fri_arm(config, clock);
  if (!arm) return tl::unexpected(arm.error());
  return std::move(*arm);
}

}  // namespace colift::hal
