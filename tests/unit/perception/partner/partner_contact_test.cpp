#include "perception/partner/partner_contact.hpp"

#include <catch2/catch.hpp>
#include <limits>
#include <vector>

namespace colift::perception {
namespace {

using Eigen::Vector3f;

// A long box, 0.8 x 0.12 x 0.24 m about the origin, whose far end at x = 0.4 m the camera cannot see: it
// looks at the top and at the side with y < 0.
struct BoxFromTheSide {
  std::vector<Vector3f> surface, outline;
  Vector3f eye{0.2F, -1.4F, 1.1F};

  BoxFromTheSide() {
    constexpr float kCell = 0.015F, kStep = 0.006F;
    for (float x = -0.395F; x < 0.4F; x += kCell) {
      for (float y = -0.055F; y < 0.06F; y += kCell) surface.emplace_back(x, y, 0.24F);
      for (float z = 0.008F; z < 0.23F; z += kCell) surface.emplace_back(x, -0.06F, z);
    }
    for (float x = -0.4F; x <= 0.4F; x += kStep) outline.emplace_back(x, 0.06F, 0.24F);
    for (float y = -0.06F; y <= 0.06F; y += kStep) outline.emplace_back(0.4F, y, 0.24F);
    for (float z = 0.0F; z <= 0.24F; z += kStep) outline.emplace_back(0.4F, -0.06F, z);
  }

  void add(std::vector<HandPoint>& hand, const Vector3f& p) const {
    HandPoint h{p, p, 1e-5F};
    float nearest = std::numeric_limits<float>::max();
    for (const Vector3f& q : surface)
      if ((p - q).norm() < nearest) nearest = (p - q).norm(), h.on_object = q;
    if (nearest < 0.06F) hand.push_back(h);
  }

  // palm on the hidden end, fingers over the upper edge: seen are the fingers' backs and the palm's narrow
  // side
  [[nodiscard]] std::vector<HandPoint> hand_on_end(float middle_y) const {
    std::vector<HandPoint> hand;
    for (float x = 0.345F; x < 0.41F; x += 0.004F)
      for (float y = -0.038F; y < 0.04F; y += 0.004F) add(hand, {x, middle_y + y, 0.258F});
    for (float x = 0.402F; x < 0.426F; x += 0.004F)
      for (float z = 0.15F; z < 0.25F; z += 0.003F) add(hand, {x, middle_y - 0.041F, z});
    return hand;
  }
};

TEST_CASE("a hand around the hidden end of a box holds the edge that its fingers come over",
          "[partner][contact]") {
  const BoxFromTheSide box;
  for (const float y : {-0.012F, -0.008F, 0.0F, 0.02F, 0.03F}) {
    const auto hand = box.hand_on_end(y);
    const auto contact = estimate_contact(hand, {box.surface, box.outline, box.eye}, {});
    INFO("hand at " << y << " m, seen at " << contact.position.transpose());
    CHECK((contact.position - Vec3(0.4, static_cast<double>(y), 0.24)).norm() < 0.02);
  }
}

TEST_CASE("an end that is seen too flat for the outline is an edge all the same", "[partner][contact]") {
  BoxFromTheSide box;
  std::erase_if(box.outline, [](const Vector3f& p) { return p.x() > 0.39F && p.z() > 0.235F; });
  const auto contact = estimate_contact(box.hand_on_end(0.0F), {box.surface, box.outline, box.eye}, {});
  INFO("seen at " << contact.position.transpose());
  CHECK((contact.position - Vec3(0.4, 0.0, 0.24)).norm() < 0.02);
}

}  // namespace
}  // namespace colift::perception
