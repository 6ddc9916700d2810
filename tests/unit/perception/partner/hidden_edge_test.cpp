#include "perception/partner/hidden_edge.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

namespace colift::perception {
namespace {

constexpr int kWidth = 100, kHeight = 60;

// An edge across the image at 2 m, and a body at 1.2 m from column `from` to `to`.
struct View {
  OrganisedCloud cloud;
  std::vector<Eigen::Vector3f> edge;
  std::vector<std::uint32_t> body;

  View(int from, int to) {
    hal::DepthFrame frame;
    frame.intrinsics.width = kWidth;
    frame.intrinsics.height = kHeight;
    frame.intrinsics.fx = frame.intrinsics.fy = 100.0;
    frame.intrinsics.cx = 50.0;
    frame.intrinsics.cy = 30.0;
    frame.depth_m.assign(kWidth * kHeight, 2.0F);
    for (int v = 0; v < kHeight; ++v)
      for (int u = from; u < to; ++u) {
        const auto i = static_cast<std::uint32_t>(v * kWidth + u);
        body.push_back(i);
        frame.depth_m[i] = 1.2F;
      }
    cloud = deproject(frame, hal::Pose::Identity());
    for (int u = 20; u < 80; ++u) edge.emplace_back(static_cast<float>(u - 50) / 100.0F * 2.0F, 0.0F, 2.0F);
  }
  [[nodiscard]] std::optional<HiddenEdge> find() const { return find_hidden_edge(edge, cloud, body, 0.1); }
};

TEST_CASE("a body before the object hides a part of its edge, and has a shorter way out",
          "[partner][hidden]") {
  const auto left = View(10, 50).find();  // hides columns 20 to 49: its right end is nearer to their middle
  REQUIRE(left);
  CHECK(left->fraction == Approx(0.5).margin(0.02));
  CHECK_FALSE(left->to_right);
  CHECK(left->aside_W.isApprox(-hal::Vec3::UnitX()));  // of a camera whose image's right is W's x
  const auto right = View(50, 95).find();
  REQUIRE(right);
  CHECK(right->fraction == Approx(0.5).margin(0.02));
  CHECK(right->to_right);
  CHECK(right->aside_W.isApprox(hal::Vec3::UnitX()));
}

TEST_CASE("a hand behind a body most likely is on the hidden edge nearest to him", "[partner][hidden]") {
  const auto straight = View(40, 60).find();
  REQUIRE(straight);
  CHECK(straight->grasp.position.x() == Approx(0.0).margin(0.02));
  CHECK(straight->grasp.position.z() == Approx(2.0));
  // an edge 0.4 m long is hidden; nothing says where along it, but for his middle
  const double along_m = std::sqrt(straight->grasp.covariance(0, 0));
  CHECK(along_m > 0.08);
  CHECK(along_m < 0.16);
  CHECK(straight->grasp.points > 0);

  View askew(30, 70);  // his right side comes nearer to the edge, as an arm does that reaches for it
  for (const std::uint32_t i : askew.body)
    if (i % kWidth >= 60) askew.cloud.depth_m[i] = 1.85F;
  hal::DepthFrame frame;
  frame.intrinsics = askew.cloud.intrinsics;
  frame.depth_m.assign(askew.cloud.depth_m.begin(), askew.cloud.depth_m.end());
  askew.cloud = deproject(frame, hal::Pose::Identity());
  const auto arm = askew.find();
  REQUIRE(arm);
  CHECK(arm->grasp.position.x() > 0.15);
}

TEST_CASE("who stands beside the object or behind it hides nothing", "[partner][hidden]") {
  CHECK_FALSE(View(0, 15).find());
  CHECK_FALSE(View(85, 100).find());
  View behind(30, 60);
  for (Eigen::Vector3f& p : behind.edge) p *= 0.5F;  // the edge is at 1 m, the body at 1.2 m
  CHECK_FALSE(behind.find());
}

TEST_CASE("a body that touches the edge does not hide it", "[partner][hidden]") {
  View touches(30, 60);
  CHECK_FALSE(find_hidden_edge(touches.edge, touches.cloud, touches.body, 0.9));
}

TEST_CASE("without an edge or a body nothing is hidden", "[partner][hidden]") {
  const View view(30, 60);
  CHECK_FALSE(find_hidden_edge({}, view.cloud, view.body, 0.1));
  CHECK_FALSE(find_hidden_edge(view.edge, view.cloud, {}, 0.1));
}

}  // namespace
}  // namespace colift::perception
