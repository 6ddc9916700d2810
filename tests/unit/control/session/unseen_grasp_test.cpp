#include "control/session/views/unseen_grasp.hpp"

#include <catch2/catch.hpp>
#include <optional>

namespace colift::control {
namespace {

using namespace std::chrono_literals;
using perception::PartnerEvent;
using perception::PartnerTracker;

const hal::Vec3 kEdge_W(1.5, 0.1, 0.7);

// Somebody before the far edge of a table, whose hand no camera sees; a frame each 33 ms.
struct Watch {
  perception::RaiseConfig config;
  perception::TrackerConfig tracker_config;
  UnseenGrasp grasp{config, tracker_config.hidden_dwell_s};
  PartnerTracker tracker{tracker_config};
  hal::Timestamp now{0};

  std::optional<PartnerEvent> see(int frames, double rise_m, const std::optional<hal::Vec3>& hidden_W) {
    std::optional<PartnerEvent> out;
    for (int k = 0; k < frames; ++k) {
      now += 33ms;
      perception::PartnerObservation seen;
      if (hidden_W) {
        seen.hidden_edge.emplace();
        seen.hidden_edge->grasp.position = *hidden_W;
        seen.hidden_edge->grasp.covariance = 0.08 * 0.08 * Eigen::Matrix3d::Identity();
      }
      perception::ObjectMotion motion;
      motion.X_WTnow_WTref.translation().z() = rise_m;
      motion.covariance.topLeftCorner<3, 3>() = 1e-7 * Eigen::Matrix3d::Identity();
      motion.center_W = hal::Vec3(1.1, 0.1, 0.6);
      grasp.look(seen);
      if (tracker.state() == PartnerTracker::State::Holding) continue;
      const auto known = grasp.needs_motion() ? std::optional(motion) : std::nullopt;
      if (auto event = grasp.update(now, known, hal::Vec3::UnitZ(), seen, tracker)) out = event;
    }
    return out;
  }

  void raise() {
    see(20, 0.0, kEdge_W);
    see(10, 0.012, kEdge_W);
    REQUIRE(see(15, 0.0, kEdge_W));
    REQUIRE(tracker.is_unseen());
  }

  // As PerceptionSession does it before the robot waits for a partner once more.
  void come_back() {
    tracker = PartnerTracker(tracker_config);
    grasp.forget_motion();
  }
};

TEST_CASE("nobody holds an object that only stands behind somebody", "[session][hidden]") {
  Watch watch;
  CHECK_FALSE(watch.see(300, 0.0, kEdge_W));
  CHECK(watch.tracker.state() == PartnerTracker::State::Away);
}

TEST_CASE("who raised the object, and still stands there after an attempt, holds it", "[session][hidden]") {
  Watch watch;
  watch.raise();
  watch.come_back();
  CHECK_FALSE(watch.see(5, 0.0, kEdge_W));  // he has to stand there for a moment
  const auto event = watch.see(20, 0.0, kEdge_W);
  REQUIRE(event);
  CHECK(event->kind == PartnerEvent::Kind::Grasped);
  CHECK(watch.tracker.grasp()->position.isApprox(kEdge_W));
}

TEST_CASE("who went away during an attempt has to raise it again", "[session][hidden]") {
  Watch watch;
  watch.raise();
  watch.come_back();
  CHECK_FALSE(watch.see(60, 0.0, std::nullopt));  // two seconds
  CHECK_FALSE(watch.see(60, 0.0, kEdge_W));
  watch.raise();
}

TEST_CASE("somebody elsewhere at the edge is not who raised it", "[session][hidden]") {
  Watch watch;
  watch.raise();
  watch.come_back();
  CHECK_FALSE(watch.see(200, 0.0, kEdge_W + hal::Vec3(0.0, 2.0 * watch.config.max_shift_m, 0.0)));
}

TEST_CASE("another scene knows of nobody", "[session][hidden]") {
  Watch watch;
  watch.raise();
  watch.come_back();
  watch.grasp.forget_place();
  CHECK_FALSE(watch.see(60, 0.0, kEdge_W));
}

}  // namespace
}  // namespace colift::control
