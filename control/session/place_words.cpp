#include "control/session/place_words.hpp"

#include <fmt/format.h>

#include <cmath>

namespace colift::control {
namespace {

constexpr double kWorthSaying_m = 0.05;  // half a hand's width

}  // namespace

std::string place_words(const hal::Vec3& from, const hal::Vec3& to, const Eigen::Vector2d& middle) {
  const Eigen::Vector2d ahead = (middle - from.head<2>()).normalized(), d = (to - from).head<2>();
  const double on = d.dot(ahead), left = ahead.x() * d.y() - ahead.y() * d.x();
  std::string text;
  if (std::abs(left) >= kWorthSaying_m)
    text = fmt::format("{:.2f} m further {}", std::abs(left), left > 0.0 ? "left" : "right");
  if (std::abs(on) >= kWorthSaying_m)
    text += fmt::format("{}{:.2f} m further {}", text.empty() ? "" : " and ", std::abs(on),
                        on > 0.0 ? "on" : "back");
  return text;
}

}  // namespace colift::control
