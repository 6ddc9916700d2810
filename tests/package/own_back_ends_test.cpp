// Back ends of somebody else, built against the installed package. Those that are right pass the suites; each
// that is wrong in one thing is caught (tests/package/check says by which fact).
#include <algorithm>
#include <cmath>
#include <memory>

#include "colift/contract/arm_contract.hpp"
#include "colift/contract/camera_contract.hpp"
#include "colift/contract/hand_contract.hpp"
#include "own_arm.hpp"
#include "own_camera.hpp"
#include "own_hand.hpp"

namespace {

using namespace colift;

template <class Arm>
void check_arm() {
  contract::check_arm([] {
    auto arm = std::make_shared<Arm>();
    return contract::ArmUnderTest{arm, arm.get()};
  });
}

template <class Hand>
void check_hand() {
  contract::check_hand([](bool with_object) {
    auto hand = std::make_shared<Hand>(with_object);
    return contract::HandUnderTest{hand, hand.get(), [h = hand.get()](hal::Duration by) { h->pass(by); }};
  });
}

/// Images of a slope from 1 to 2 m, one row in eight without depth.
struct Slope {
  hal::Timestamp now{0};
  hal::Duration period = std::chrono::milliseconds(33);

  std::optional<example::RawImage> operator()(std::chrono::milliseconds) {
    now += period;
    example::RawImage raw;
    raw.exposed_at = now;
    for (int row = 0; row < 48; ++row)
      raw.depth_mm.insert(raw.depth_mm.end(), 64,
                          static_cast<std::uint16_t>(row % 8 == 0 ? 0 : 1000 + 20 * row));
    return raw;
  }
};

template <class Camera>
void check_camera() {
  contract::check_camera([] {
    hal::CameraIntrinsics k;
    k.width = 64;
    k.height = 48;
    auto camera = std::make_shared<Camera>(Slope{}, k);
    return contract::CameraUnderTest{camera, camera.get()};
  });
}

/// Wrong: it goes on when it is stopped.
struct UnstoppableArm : OwnArm {
  void stop() noexcept override {}
};

/// Wrong: it says 0 m where it measured nothing.
struct ZeroCamera : example::OwnCamera {
  using OwnCamera::OwnCamera;
  hal::Result<hal::DepthFrame> next_frame(std::chrono::milliseconds timeout) override {
    auto frame = OwnCamera::next_frame(timeout);
    if (frame)
      std::replace_if(
          frame->depth_m.begin(), frame->depth_m.end(), [](float d) { return std::isnan(d); }, 0.0f);
    return frame;
  }
};

/// Wrong: it drops what it holds when it is asked for a preshape.
struct DroppingHand : OwnHand {
  using OwnHand::OwnHand;
  hal::Result<> preshape(double spread_rad) override {
    if (auto released = release(); !released) return released;
    return OwnHand::preshape(spread_rad);
  }
};

}  // namespace

TEST_CASE("my arm keeps the contract of an arm") {
  check_arm<OwnArm>();
}
TEST_CASE("my hand keeps the contract of a hand") {
  check_hand<OwnHand>();
}
TEST_CASE("my camera keeps the contract of a depth camera") {
  check_camera<example::OwnCamera>();
}

// hidden: only the check calls them, and each has to fail
TEST_CASE("an arm that does not stop", "[.wrong]") {
  check_arm<UnstoppableArm>();
}
TEST_CASE("a hand that drops its load", "[.wrong]") {
  check_hand<DroppingHand>();
}
TEST_CASE("a camera that says zero for unknown", "[.wrong]") {
  check_camera<ZeroCamera>();
}
