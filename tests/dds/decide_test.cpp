#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <thread>

#include "control/config/resolve_config.hpp"
#include "control/session/scene_analysis.hpp"
#include "hal/drivers/recorded/frame_file.hpp"
#include "tests/dds/camera_rig.hpp"
#include "tests/dds/frame_messages.hpp"
#include "tools/dds/decide_server.hpp"

namespace colift::tests {
namespace {

using namespace std::chrono_literals;

// A real office chair, seen by a Kinect; the partner grasps its seat.
const hal::Vec3 kPartner_C(-0.45, -0.5, 1.75);

const hal::DepthFrame& recorded() {
  static const hal::DepthFrame frame =
      hal::read_frame(std::string(COLIFT_TEST_DATA) + "/real/01_office_chair_and_bottles/depth.png", {})
          .value()
          .frame;
  return frame;
}

hal::Result<ros2::DecideResult> decide(const ros2::DecideTask& task) {
  static const control::Config config;
  static const planner::HandModel hand;
  control::Config mine = config;
  if (task.share) mine.decision.share = *task.share;
  control::SceneAnalysisInput input;
  input.frame = task.frame;
  const auto analysis =
      control::analyse_scene(std::move(input), control::Method::Fast, mine, hand, hal::SteadyClock());
  if (!analysis) return tl::unexpected(analysis.error());
  control::PartnerInput partner;
  partner.position_W = task.partner_C;
  auto outcome = control::decide(*analysis, partner, mine, hal::SteadyClock());
  if (!outcome) return tl::unexpected(outcome.error());
  ros2::DecideResult result;
  result.outcome = std::move(*outcome);
  if (analysis->scene.target) result.cog_C = analysis->scene.target->cog;
  return result;
}

RosDecideRequest request(std::uint64_t number) {
  RosDecideRequest r;
  r.header = {system_stamp(), "camera"};
  r.client = "test", r.sequence_number = number;
  r.depth = image_of_frame(recorded()), r.info = info_of_frame(recorded());
  r.partner = {kPartner_C.x(), kPartner_C.y(), kPartner_C.z()};
  r.share = std::nan("");
  return r;
}

void check_same(const RosDecision& there, const ros2::DecideResult& here) {
  const planner::Decision& d = here.outcome.decision;
  REQUIRE(d.chosen);
  CHECK(there.decided);
  CHECK(there.chosen == here.outcome.candidates[*d.chosen].id);
  CHECK(there.share == d.share);
  CHECK(there.cost == d.cost);
  CHECK(there.because == d.reason);
  REQUIRE(there.candidates.size() == here.outcome.candidates.size());
  for (std::size_t i = 0; i < there.candidates.size(); ++i) {
    CHECK(there.candidates[i].id == here.outcome.candidates[i].id);
    CHECK(there.candidates[i].position[2] == here.outcome.candidates[i].position.z());
  }
}

/// A server in a thread of its own.
class Serving {
 public:
  explicit Serving(ros2::Decide with = decide) {
    auto made = ros2::DecideServer::open({test_domain(), "lo", "colift_decide"}, std::move(with));
    if (!made) FAIL(made.error().text());
    server_ = std::move(*made);
    thread_ = std::thread([this] {
      while (!ends_) answered += server_->serve(50ms);
    });
  }
  ~Serving() {
    ends_ = true;
    thread_.join();
  }
  std::atomic<int> answered{0};

 private:
  std::unique_ptr<ros2::DecideServer> server_;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

struct Client {
  FastPeer peer{test_domain()};
  std::unique_ptr<FastPeer::Reader> replies =
      peer.reader("rt/colift/decide/reply", "colift_msgs::msg::dds_::DecideReply_");
  std::unique_ptr<FastPeer::Writer> requests =
      peer.writer("rt/colift/decide/request", "colift_msgs::msg::dds_::DecideRequest_", {true, false, 10});

  /// Asks again until there is an answer, as a client has to.
  std::optional<RosDecideReply> ask(const RosDecideRequest& r) {
    for (int i = 0; i < 30; ++i) {
      (void)requests->write(bytes_of(r));
      if (const auto got = replies->next(2'000ms)) {
        const auto reply = decide_reply_of(*got);
        if (reply.client == r.client && reply.sequence_number == r.sequence_number) return reply;
      }
    }
    return std::nullopt;
  }
};

}  // namespace

TEST_CASE("a decision asked for over ROS 2 equals the local one", "[dds][decide]") {
  const Serving server;
  Client client;
  const auto reply = client.ask(request(1));
  REQUIRE(reply);
  CHECK(reply->error.empty());
  REQUIRE(reply->ok);
  const auto here = decide({recorded(), kPartner_C, {}});
  REQUIRE(here);
  check_same(reply->decision, *here);
}

TEST_CASE("a decision from a frame of a camera over ROS 2 equals the local one", "[dds][decide]") {
  auto config = camera_config();
  Ros2CameraRig rig(
      [](RosImage& m, RosCameraInfo& i) {
        const auto stamp = system_stamp();
        m = image_of_frame(recorded()), i = info_of_frame(recorded());
        m.header.stamp = stamp;
      },
      config);
  if (auto done = rig.camera.configure(); !done) FAIL(done.error().text());
  REQUIRE(rig.camera.activate());
  auto frame = rig.camera.next_frame(10'000ms);
  REQUIRE(frame);
  REQUIRE(frame->depth_m.size() == recorded().depth_m.size());
  std::size_t differ = 0;
  for (std::size_t i = 0; i < frame->depth_m.size(); ++i) {
    const float a = frame->depth_m[i], b = recorded().depth_m[i];
    differ += !(a == b || (std::isnan(a) && std::isnan(b)));
  }
  CHECK(differ == 0);
  const auto there = decide({*frame, kPartner_C, {}}), here = decide({recorded(), kPartner_C, {}});
  REQUIRE(there);
  REQUIRE(here);
  REQUIRE(here->outcome.decision.chosen);
  CHECK(there->outcome.decision.chosen == here->outcome.decision.chosen);
  CHECK(there->outcome.decision.share == here->outcome.decision.share);
  CHECK(there->outcome.decision.cost == here->outcome.decision.cost);
}

TEST_CASE("a request that cannot be used is answered with the reason, and nothing is decided",
          "[dds][decide]") {
  std::atomic<int> decided{0};
  const Serving server([&](const ros2::DecideTask&) -> hal::Result<ros2::DecideResult> {
    ++decided;
    return ros2::DecideResult{};
  });
  Client client;
  const auto refused = [&](std::uint64_t number, const char* word, const auto& lie) {
    auto r = request(number);
    lie(r);
    const auto reply = client.ask(r);
    INFO(word);
    REQUIRE(reply);
    CHECK_FALSE(reply->ok);
    CHECK_THAT(reply->error, Catch::Contains(word));
  };
  refused(2, "encoding", [](auto& r) { r.depth.encoding = "rgb8"; });
  refused(3, "bytes", [](auto& r) { r.depth.data.resize(10); });
  refused(4, "not finite", [](auto& r) { r.info.k[4] = INFINITY; });
  refused(5, "partner", [](auto& r) { r.partner[1] = std::nan(""); });
  refused(6, "share", [](auto& r) { r.share = 1.5; });
  CHECK(decided == 0);
  // garbage and nameless clients get no answer; the next one does
  Bytes garbage(400, 0xff);
  garbage[0] = 0, garbage[1] = 1;
  (void)client.requests->write(garbage);
  auto nameless = request(7);
  nameless.client = std::string(65, 'x');
  (void)client.requests->write(bytes_of(nameless));
  const auto reply = client.ask(request(8));
  REQUIRE(reply);
  CHECK(reply->sequence_number == 8);
}

}  // namespace colift::tests
