#include "tools/cli/numbers.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace colift::tools {

hal::Result<std::vector<double>> parse_numbers(const std::string& text, std::size_t count,
                                               const std::string& option) {
  const auto refuse = [&](const std::string& why) {
    return hal::failure(hal::ErrorCode::BadInput, option, why);
  };
  std::vector<double> numbers;
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  while (true) {
    double value = 0.0;
    const auto [next, error] = std::from_chars(at, end, value);
    if (error != std::errc() || !std::isfinite(value)) {
      return refuse(fmt::format("\"{}\" is not {} at character {}; expected {} with commas and no spaces",
                                text, "a finite number", at - text.data() + 1,
                                count == 1 ? "one number" : fmt::format("{} numbers", count)));
    }
    numbers.push_back(value);
    at = next;
    if (at == end) break;
    if (*at != ',')
      return refuse(fmt::format("\"{}\" has '{}' at character {} where a comma was expected", text, *at,
                                at - text.data() + 1));
    ++at;
  }
  if (numbers.size() != count)
    return refuse(fmt::format("\"{}\" has {} numbers, {} were expected", text, numbers.size(), count));
  return numbers;
}

hal::Result<hal::Vec3> parse_point(const std::string& text, const std::string& option) {
  const auto n = parse_numbers(text, 3, option);
  if (!n) return tl::unexpected(n.error());
  return hal::Vec3((*n)[0], (*n)[1], (*n)[2]);
}

hal::Result<hal::Pose> parse_pose(const std::string& text, const std::string& option) {
  const auto n = parse_numbers(text, 7, option);
  if (!n) return tl::unexpected(n.error());
  const Eigen::Quaterniond q((*n)[6], (*n)[3], (*n)[4], (*n)[5]);
  if (std::abs(q.norm() - 1.0) > 0.01) {
    return hal::failure(hal::ErrorCode::BadInput, option,
                        fmt::format("the quaternion {},{},{},{} has length {:.3f}, a rotation has length 1",
                                    q.x(), q.y(), q.z(), q.w(), q.norm()));
  }
  hal::Pose pose = hal::Pose::Identity();
  pose.linear() = q.normalized().toRotationMatrix();
  pose.translation() = hal::Vec3((*n)[0], (*n)[1], (*n)[2]);
  return pose;
}

}  // namespace colift::tools
