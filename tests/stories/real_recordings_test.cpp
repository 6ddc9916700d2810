#include <algorithm>

#include "recording.hpp"

namespace colift::stories {
namespace {

bool any_because(const control::SceneAnalysis& analysis, perception::RejectedObject::Kind kind) {
  return std::any_of(analysis.rejected.begin(), analysis.rejected.end(),
                     [&](const auto& o) { return o.kind == kind; });
}

}  // namespace

using Kind = perception::RejectedObject::Kind;

TEST_CASE("01: the office chair is the target, the drawer unit is cut by the image", "[real]") {
  const Recording r("01_office_chair_and_bottles");
  const control::SceneAnalysis seen = r.analysis();
  check_ground(r, seen.scene);
  REQUIRE(seen.scene.target);
  check_box(r, *seen.scene.target, r.object("office chair"));
  const Vec3 drawers = vec(r.object("drawer unit")["obb_center"]);
  CHECK(std::any_of(seen.rejected.begin(), seen.rejected.end(),
                    [&](const auto& o) { return o.kind == Kind::Cut && (o.center - drawers).norm() < 0.2; }));
  CHECK(seen.scene.target->reason.find("upper side") != std::string::npos);
}

TEST_CASE("01: bottles full of holes are one object", "[real]") {
  const Recording r("01_office_chair_and_bottles");
  const control::SceneAnalysis seen = r.analysis(vec(r.object("bottle pack")["centroid"]));
  REQUIRE(seen.scene.target);
  check_box(r, *seen.scene.target, r.object("bottle pack"));
}

TEST_CASE("02: laptop and carton touch and are told apart", "[real]") {
  const Recording r("02_laptop_and_box");
  const control::SceneAnalysis laptop = r.analysis({}, control::Method::Fast, "depth_0.png");
  check_ground(r, laptop.scene);
  REQUIRE(laptop.scene.target);
  check_box(r, *laptop.scene.target, r.object("laptop"));

  const control::SceneAnalysis carton =
      r.analysis(vec(r.object("box")["centroid"]), control::Method::Fast, "depth_0.png");
  REQUIRE(carton.scene.target);
  check_box(r, *carton.scene.target, r.object("box"));
}

TEST_CASE("03: the desk stands free of its partition wall", "[real]") {
  const Recording r("03_desk_and_two_chairs");
  const control::SceneAnalysis seen = r.analysis();
  check_ground(r, seen.scene);
  REQUIRE(seen.scene.target);
  CHECK(any_because(seen, Kind::Wall));

  // its top is one of the surfaces, level and at the right height
  const auto& desk = r.truth["desk_top"];
  const double height = desk["height_over_floor"], tolerance = r.tolerance("desk_top_height_m");
  bool top = false;
  for (const auto& s : seen.scene.surfaces) {
    const auto* face = std::get_if<perception::Rectangle>(&s);
    if (!face || face->size.x() < 0.5) continue;
    const auto& g = seen.scene.ground->plane;
    top |= angle_deg(face->normal, g.normal) < 5.0 && std::abs(g.height(face->center) - height) <= tolerance;
  }
  CHECK(top);
}

TEST_CASE("03: a point picks one of the chairs", "[real]") {
  const Recording r("03_desk_and_two_chairs");
  for (const char* name : {"desk chair (purple)", "desk chair (yellow)"}) {
    const control::SceneAnalysis seen = r.analysis(vec(r.object(name)["centroid"]));
    REQUIRE(seen.scene.target);
    check_box(r, *seen.scene.target, r.object(name));
  }
}

TEST_CASE("04: people are not carried", "[real]") {
  const Recording r("04_five_people");
  const control::SceneAnalysis seen = r.analysis();
  check_ground(r, seen.scene);
  CHECK_FALSE(seen.scene.target);
  CHECK(seen.candidates.empty());
  CHECK(any_because(seen, Kind::Person));
  CHECK(seen.reason.find("no target") == 0);

  // every person is among those refused as a person
  for (const auto& person : r.truth["objects"]) {
    const Vec3 at = vec(person["obb_center"]);
    CHECK(std::any_of(seen.rejected.begin(), seen.rejected.end(),
                      [&](const auto& o) { return o.kind == Kind::Person && (o.center - at).norm() < 0.7; }));
  }
}

TEST_CASE("05: a can is a cylinder", "[real]") {
  const Recording r("05_can_on_table");
  const control::SceneAnalysis seen = r.analysis();
  check_ground(r, seen.scene);
  REQUIRE(seen.scene.target);
  check_box(r, *seen.scene.target, r.object("can"));
  const auto& can = r.truth["cylinder"];
  bool found = false;
  for (const auto& s : seen.scene.surfaces) {
    const auto* c = std::get_if<perception::Cylinder>(&s);
    if (!c) continue;
    found = true;
    CHECK(std::abs(c->radius - can["radius_m"].get<double>()) <= can["radius_tolerance_m"].get<double>());
    const double tilt = angle_deg(c->axis, seen.scene.ground->plane.normal);
    CHECK(std::min(tilt, 180.0 - tilt) < 4.0);
  }
  CHECK(found);
}

TEST_CASE("06: a box shows two perpendicular faces and no cylinder", "[real]") {
  const Recording r("06_cereal_box_on_table");
  const control::SceneAnalysis seen = r.analysis();
  check_ground(r, seen.scene);
  REQUIRE(seen.scene.target);
  check_box(r, *seen.scene.target, r.object("cereal box"));
  std::vector<perception::Rectangle> faces;
  for (const auto& s : seen.scene.surfaces) {
    CHECK(std::holds_alternative<perception::Rectangle>(s));
    if (const auto* f = std::get_if<perception::Rectangle>(&s)) faces.push_back(*f);
  }
  bool perpendicular = false;
  for (const auto& a : faces)
    for (const auto& b : faces) perpendicular |= std::abs(angle_deg(a.normal, b.normal) - 90.0) < 5.0;
  CHECK(perpendicular);
}

TEST_CASE("a partner at one side of the cereal box gets a robot at the other", "[real]") {
  const Recording r("06_cereal_box_on_table");
  const control::SceneAnalysis seen = r.analysis();
  REQUIRE(seen.scene.target);
  const auto& t = *seen.scene.target;
  control::PartnerInput partner;
  partner.position_W = t.obb.center + 0.5 * t.obb.size.x() * t.obb.axes.col(0);
  const auto outcome = control::decide(seen, partner, {}, hal::ManualClock());
  REQUIRE(outcome);
  INFO(outcome->decision.reason);
  for (const auto& c : outcome->candidates) CHECK((c.verdict == planner::Verdict::Ok || !c.reason.empty()));
  if (outcome->decision.chosen) {
    const Vec3 lever = outcome->candidates[*outcome->decision.chosen].position - t.cog;
    CHECK(lever.dot(*partner.position_W - t.cog) < 0.0);
  }
}

}  // namespace colift::stories
