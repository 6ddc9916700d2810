// A hand at its contact on an object that moves: seen, gone, back.
#include "perception/partner/grasp_presence.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

using namespace colift;

namespace {

/// A camera that looks straight down from 2 m: a table top at 0.4 m on a floor, and a hand of 8 cm by 8 cm.
struct Down {
  Down() {
    k.width = 320;
    k.height = 240;
    k.fx = k.fy = 262.5;
    k.cx = 160;
    k.cy = 120;
    X_WC.linear() << 1, 0, 0, 0, -1, 0, 0, 0, -1;
    X_WC.translation() << 0, 0, 2;
  }
  [[nodiscard]] hal::DepthFrame frame(double raised_m, std::optional<hal::Vec3> hand) const {
    hal::DepthFrame f;
    f.intrinsics = k;
    f.depth_m.assign(static_cast<std::size_t>(k.width * k.height), 2.0f);
    const auto paint = [&](const hal::Vec3& middle, double half_x, double half_y) {
      for (int v = 0; v < k.height; ++v)
        for (int u = 0; u < k.width; ++u) {
          const double z = 2.0 - middle.z();
          const double x = (u - k.cx) / k.fx * z, y = -(v - k.cy) / k.fy * z;
          if (std::abs(x - middle.x()) > half_x || std::abs(y - middle.y()) > half_y) continue;
          f.depth_m[static_cast<std::size_t>(v * k.width + u)] = static_cast<float>(z);
        }
    };
    paint({0, 0, 0.4 + raised_m}, 0.3, 0.2);
    if (hand) paint(*hand, 0.04, 0.04);
    return f;
  }
  [[nodiscard]] double area(double raised_m, std::optional<hal::Vec3> hand) const {
    const auto reference = perception::deproject(frame(0.0, {}), X_WC);
    hal::Pose X = hal::Pose::Identity();
    X.translation().z() = raised_m;
    const auto seen = perception::hand_at_contact(reference, frame(raised_m, hand), X, contact, {}, {});
    return seen ? seen->area_m2 : NAN;
  }

  hal::CameraIntrinsics k;
  hal::Pose X_WC = hal::Pose::Identity();
  hal::Vec3 contact{0.28, 0.0, 0.4};
};

}  // namespace

TEST_CASE("a hand at its contact is seen, on the floor's object and on a raised one", "[presence]") {
  const Down view;
  for (const double raised_m : {0.0, 0.05, 0.10}) {
    INFO(raised_m);
    const double there = view.area(raised_m, hal::Vec3(0.29, 0.0, 0.43 + raised_m));
    CHECK(there > 0.0020);  // 64 cm^2 of hand, some of it farther than the radius
    CHECK(there < 0.0070);
    CHECK(view.area(raised_m, {}) < 0.0002);
    // 15 cm out it is no longer at the grasp
    CHECK(view.area(raised_m, hal::Vec3(0.43, 0.0, 0.43 + raised_m)) < 0.1 * there);
  }
}

TEST_CASE("a place that the camera does not show says nothing", "[presence]") {
  Down view;
  view.contact = {3.0, 0.0, 0.4};
  CHECK(std::isnan(view.area(0.0, {})));
}
