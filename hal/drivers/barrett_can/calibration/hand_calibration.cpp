#include "hal/drivers/barrett_can/calibration/hand_calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/config/config_file.hpp"

namespace colift::hal {
namespace {

constexpr double kMaxResidual = 0.1;  // of the largest torque: beyond it something else was measured
constexpr std::size_t kMaxPucks = 1000;

}  // namespace

const PuckScale* HandCalibration::of(std::int32_t serial) const {
  const auto at =
      std::find_if(pucks.begin(), pucks.end(), [&](const PuckScale& p) { return p.serial == serial; });
  return at == pucks.end() ? nullptr : &*at;
}

void HandCalibration::take(const PuckScale& scale) {
  const auto at =
      std::find_if(pucks.begin(), pucks.end(), [&](const PuckScale& p) { return p.serial == scale.serial; });
  if (at == pucks.end()) {
    pucks.push_back(scale);
    return;
  }
  PuckScale next = scale;
  if (next.strain_points == 0) {
    next.strain_scale = at->strain_scale;
    next.strain_residual_nm = at->strain_residual_nm;
    next.strain_points = at->strain_points;
  }
  if (next.torque_points == 0) {
    next.torque_units_per_nm = at->torque_units_per_nm;
    next.torque_points = at->torque_points;
  }
  *at = next;
}

Result<HandCalibration> parse_hand_calibration(const std::string& yaml, const std::string& name) {
  HandCalibration calibration;
  FieldTable table = table_of(calibration);
  if (auto done = apply_yaml_text(table, yaml, name); !done) return tl::unexpected(done.error());
  if (auto done = check_fields(table, name); !done) return tl::unexpected(done.error());
  if (calibration.pucks.size() > kMaxPucks)
    return failure(ErrorCode::BadConfig, name, fmt::format("more than {} pucks", kMaxPucks));
  for (std::size_t i = 0; i < calibration.pucks.size(); ++i) {
    const PuckScale& puck = calibration.pucks[i];
    if (calibration.of(puck.serial) != &puck)
      return failure(ErrorCode::BadConfig, name,
                     fmt::format("pucks[{}]: the serial number {} stands here twice", i, puck.serial));
  }
  return calibration;
}

Result<HandCalibration> load_hand_calibration(const std::filesystem::path& file) {
  const auto text = read_yaml_file(file);
  if (!text) return tl::unexpected(text.error());
  return parse_hand_calibration(*text, file.string());
}

std::string text_of(const HandCalibration& calibration) {
  HandCalibration copy = calibration;
  std::string yaml = effective_yaml(table_of(copy), false);
  // where each value comes from is nobody's question here
  const std::string origin = "  # " + std::string(kDefaultOrigin);
  for (std::size_t at = yaml.find(origin); at != std::string::npos; at = yaml.find(origin, at))
    yaml.erase(at, origin.size());
  return yaml;
}

Result<ScaleFit> fit_scale(std::span<const ScalePoint> points) {
  constexpr const char* kWhere = "hand.calibrate";
  double both = 0.0, shown = 0.0, most = 0.0;
  int usable = 0;
  for (const ScalePoint& p : points) {
    if (!std::isfinite(p.is) || !std::isfinite(p.shown))
      return failure(ErrorCode::BadInput, kWhere, "a torque was not measured");
    both += p.is * p.shown;
    shown += p.shown * p.shown;
    most = std::max(most, std::abs(p.is));
    usable += p.is != 0.0;
  }
  if (usable < 2)
    return failure(ErrorCode::BadInput, kWhere,
                   "two different torques beside none are needed, one tells no line");
  if (!(both > 0.0) || !(shown > 0.0))
    return failure(ErrorCode::BadInput, kWhere, "what was measured does not grow with the torque");
  ScaleFit fit;
  fit.scale = both / shown;
  double squares = 0.0;
  for (const ScalePoint& p : points) squares += std::pow(p.is - fit.scale * p.shown, 2);
  fit.residual = std::sqrt(squares / static_cast<double>(points.size()));
  if (fit.residual > kMaxResidual * most)
    return failure(ErrorCode::BadInput, kWhere,
                   fmt::format("the points lie on no line through 0: {:.3g} off in the mean, at {:.3g}",
                               fit.residual, most));
  return fit;
}

}  // namespace colift::hal
