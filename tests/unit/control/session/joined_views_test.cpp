#include "control/session/views/joined_views.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

using namespace colift;
using namespace colift::control;
using hal::Vec3;
using perception::PartnerKind;

namespace {

ViewOfPartner view(std::size_t camera, PartnerKind kind, const Vec3& at = Vec3::Zero(),
                   const Vec3& sigma_m = Vec3::Constant(0.01)) {
  ViewOfPartner v{camera, {}};
  v.sighting.observation.kind = kind;
  v.sighting.observation.reason = "seen";
  if (kind != PartnerKind::Grasp) return v;
  perception::PartnerGrasp grasp;
  grasp.position = at;
  grasp.covariance = sigma_m.array().square().matrix().asDiagonal();
  grasp.points = 100;
  grasp.skin = at;
  v.sighting.observation.grasp = grasp;
  return v;
}

constexpr double kSame_m = 0.12;

perception::Body body(const Vec3& low, const Vec3& high, double area_m2, std::size_t first,
                      std::size_t count) {
  perception::Body b;
  b.box = {low, high};
  b.center = b.box.center();
  b.area_m2 = area_m2;
  b.first = first;
  b.count = count;
  return b;
}

std::vector<perception::BodyPoint> points_at(std::initializer_list<Vec3> places) {
  std::vector<perception::BodyPoint> points;
  for (const Vec3& p : places) points.push_back({p.cast<float>(), Eigen::Vector3f::UnitX(), 0.1F});
  return points;
}

}  // namespace

TEST_CASE("a hand that only the second camera sees is seen, and the reason says by which") {
  const std::vector views{view(0, PartnerKind::Near), view(1, PartnerKind::Grasp, {1.0, 0.0, 0.5})};
  const PartnerSighting seen = join_sightings(views, kSame_m);
  REQUIRE(seen.observation.kind == PartnerKind::Grasp);
  CHECK(seen.observation.grasp->position.isApprox(Vec3(1.0, 0.0, 0.5)));
  // the middle of what is visible of a hand is another one in each view
  CHECK_FALSE(seen.observation.grasp->skin);
  CHECK(seen.observation.reason.find("camera2") != std::string::npos);
}

TEST_CASE("two views of one hand are averaged by how sure each is, along each axis") {
  const std::vector views{view(0, PartnerKind::Grasp, {1.00, 0.00, 0.5}, {0.01, 0.03, 0.01}),
                          view(1, PartnerKind::Grasp, {1.02, 0.04, 0.5}, {0.03, 0.01, 0.01})};
  const perception::PartnerGrasp grasp = *join_sightings(views, kSame_m).observation.grasp;
  CHECK(grasp.position.x() == Approx(1.002));
  CHECK(grasp.position.y() == Approx(0.036));
  CHECK(grasp.covariance(0, 0) == Approx(0.9e-4));
  CHECK(grasp.covariance(2, 2) == Approx(0.5e-4));
  CHECK(grasp.points == 200);
}

TEST_CASE("hands far apart are no one hand: the leading view's counts") {
  const std::vector views{view(0, PartnerKind::Grasp, {1.0, 0.0, 0.5}),
                          view(1, PartnerKind::Grasp, {0.2, 0.0, 0.5})};
  CHECK(join_sightings(views, kSame_m).observation.grasp->position.isApprox(Vec3(1.0, 0.0, 0.5)));
}

TEST_CASE("a hidden hand is hidden where no view shows that it is gone") {
  std::vector views{view(0, PartnerKind::Near), view(1, PartnerKind::Near)};
  views[0].sighting.seen_before = views[0].sighting.hidden = true;
  CHECK(join_sightings(views, kSame_m).hidden);
  // the other one has seen it before, nothing is before the place now, and no hand is there
  views[1].sighting.seen_before = true;
  CHECK_FALSE(join_sightings(views, kSame_m).hidden);
  views[1].sighting.hidden = true;
  CHECK(join_sightings(views, kSame_m).hidden);
}

TEST_CASE("an edge that one camera sees is not hidden") {
  std::vector views{view(0, PartnerKind::Near), view(1, PartnerKind::None)};
  views[0].sighting.observation.hidden_edge.emplace();
  CHECK_FALSE(join_sightings(views, kSame_m).observation.hidden_edge);
  views[1].sighting.observation.hidden_edge.emplace();
  CHECK(join_sightings(views, kSame_m).observation.hidden_edge);
}

TEST_CASE(
    "a scene that moved says nothing of hands, unless another view shows one on the object where it was") {
  std::vector views{view(0, PartnerKind::ObjectMoved), view(1, PartnerKind::Near)};
  CHECK(join_sightings(views, kSame_m).observation.kind == PartnerKind::ObjectMoved);
  views[1] = view(1, PartnerKind::Grasp, {1.0, 0.0, 0.5});
  CHECK(join_sightings(views, kSame_m).observation.kind == PartnerKind::Grasp);
}

TEST_CASE("front and back of a person in two views are one body with the points of both") {
  const auto front = points_at({{1.0, 0.0, 1.0}, {1.0, 0.1, 1.2}});
  const auto back = points_at({{1.2, 0.0, 1.0}, {3.0, 0.0, 1.0}});
  std::vector<perception::Body> of_first{body({1.0, 0.0, 1.0}, {1.05, 0.3, 1.7}, 0.3, 0, 2)};
  of_first[0].whole = of_first[0].top_seen = false;
  const std::vector<perception::Body> of_second{body({1.15, 0.0, 0.2}, {1.2, 0.3, 1.8}, 0.4, 0, 1),
                                                body({3.0, 0.0, 0.2}, {3.1, 0.3, 1.8}, 0.5, 1, 1)};
  JoinedBodies joined;
  const std::vector<ViewOfBodies> views{{of_first, front}, {of_second, back}};
  const auto bodies = joined.join(views, 0.15);
  REQUIRE(bodies.size() == 2);
  // largest first: the one that only the second camera sees
  CHECK(bodies[0].count == 1);
  CHECK(bodies[1].count == 3);
  CHECK(bodies[1].box.min().z() == Approx(0.2));
  // what cuts it off in one view, the other one sees
  CHECK(bodies[1].whole);
  CHECK(bodies[1].top_seen);
  for (const perception::Body& b : bodies)
    for (const auto& p : joined.points().subspan(b.first, b.count))
      CHECK(b.box.exteriorDistance(Vec3(p.p_W.cast<double>())) < 0.1);
}

TEST_CASE("two bodies of one view stay two, unless the other one bridges them") {
  const auto points = points_at({{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}});
  const std::vector<perception::Body> two{body({0.0, 0.0, 0.0}, {0.1, 0.1, 1.0}, 0.2, 0, 1),
                                          body({0.15, 0.0, 0.0}, {0.3, 0.1, 1.0}, 0.2, 1, 1)};
  JoinedBodies joined;
  CHECK(joined.join(std::vector<ViewOfBodies>{{two, points}}, 0.15).size() == 2);
  const auto across = points_at({{0.1, 0.0, 0.0}});
  const std::vector<perception::Body> one{body({0.05, 0.0, 0.0}, {0.2, 0.1, 1.0}, 0.2, 0, 1)};
  CHECK(joined.join(std::vector<ViewOfBodies>{{two, points}, {one, across}}, 0.15).size() == 1);
}

namespace {

/// A box of one metre along x on the floor, of which one view shows the part from `from` to `to`. The camera
/// looks down on it from 3 m; what it shows beside that part is the floor, or nothing where the arm hides it.
struct PartSeen {
  perception::Target target;
  perception::OrganisedCloud cloud;

  PartSeen(double from, double to, double cog_x, double sigma_m, bool arm_before_the_rest) {
    target.shape.center = {0.5 * (from + to), 0.0, 0.2};
    target.shape.size = {to - from, 0.4, 0.4};
    for (int i = 0; i <= 100; ++i)
      target.points.emplace_back(static_cast<float>(from + 0.01 * i * (to - from)), 0.1F, 0.4F);
    target.cog = {cog_x, 0.0, 0.2};
    target.cog_covariance = sigma_m * sigma_m * Eigen::Matrix3d::Identity();
    hal::Pose X_WC = hal::Pose::Identity();
    X_WC.translation() = Vec3(0.5, 0.0, 3.0);
    X_WC.linear() = Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitX()).matrix();
    hal::DepthFrame frame;
    const auto& k = frame.intrinsics;
    frame.depth_m.assign(static_cast<std::size_t>(k.width * k.height), arm_before_the_rest ? NAN : 3.0F);
    cloud = perception::deproject(frame, X_WC);
  }
  [[nodiscard]] ViewOfObject view() { return {&target, &cloud}; }
};

constexpr double kMargin_m = 0.03;

}  // namespace

TEST_CASE("two views of the whole object average their centres of gravity") {
  PartSeen a(0.0, 1.0, 0.49, 0.01, false), b(0.0, 1.0, 0.51, 0.01, false);
  join_cogs(std::vector{a.view(), b.view()}, kMargin_m);
  CHECK(a.target.cog.x() == Approx(0.5));
  CHECK(a.target.cog_covariance(0, 0) == Approx(0.5e-4));
}

TEST_CASE("a view from which the arm hides half of the object does not move its centre of gravity") {
  PartSeen whole(0.0, 1.0, 0.5, 0.01, false), half(0.0, 0.5, 0.25, 0.005, true);
  join_cogs(std::vector{whole.view(), half.view()}, kMargin_m);
  CHECK(whole.target.cog.x() == Approx(0.5));
  CHECK(whole.target.cog_covariance(0, 0) == Approx(1e-4));
  // and when it is the first, the other one's counts
  join_cogs(std::vector{half.view(), whole.view()}, kMargin_m);
  CHECK(half.target.cog.x() == Approx(0.5));
}

TEST_CASE("what the first view sees apart from the object is not the object, whatever another one says") {
  PartSeen right(0.0, 1.0, 0.5, 0.01, false), merged(0.0, 1.6, 0.8, 0.01, false);
  join_cogs(std::vector{right.view(), merged.view()}, kMargin_m);
  CHECK(right.target.cog.x() == Approx(0.5));
  // but nobody knows which one is right
  CHECK(std::sqrt(right.target.cog_covariance(0, 0)) > 0.1);
}

TEST_CASE("views that differ by more than their covariances explain are less sure together") {
  PartSeen a(0.0, 1.0, 0.40, 0.01, false), b(0.0, 1.0, 0.60, 0.01, false);
  join_cogs(std::vector{a.view(), b.view()}, kMargin_m);
  CHECK(a.target.cog.x() == Approx(0.5));
  CHECK(std::sqrt(a.target.cog_covariance(0, 0)) > 0.05);
}
