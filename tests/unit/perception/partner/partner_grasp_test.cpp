#include "perception/partner_grasp.hpp"

#include <fmt/format.h>

#include <array>
#include <catch2/catch.hpp>
#include <iostream>

#include "partner_stage.hpp"

namespace colift::perception {
namespace {

using sim_hal::ObjectKind;
using test::Stage;

constexpr std::array kKinds{ObjectKind::Table, ObjectKind::Box, ObjectKind::OpenBox, ObjectKind::Pipe,
                            ObjectKind::Chair};
constexpr std::array kNames{"table", "box", "open box", "pipe", "chair"};

TEST_CASE("the contact is found more sharply than by the mean of the nearest 100 points",
          "[partner][grasp]") {
  std::vector<double> all, thesis;
  int hands = 0, missed = 0;
  std::string table = "contact error in mm      median    p90   thesis p90   missed\n";
  for (std::size_t k = 0; k < kKinds.size(); ++k) {
    std::vector<double> mine, theirs;
    int missed_here = 0;
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
      const Stage stage(kKinds[k], 500 + seed, 5);
      const auto pose = sim_hal::make_partner(stage.scene, seed, seed % 4 == 3);
      const auto current = stage.see(sim_hal::with_partner(stage.scene.world, pose), 77 + seed);
      auto finder = stage.finder();
      const auto seen = finder.find(current);
      REQUIRE(seen);
      std::vector<Vec3> truths{pose.contact};
      if (pose.second_contact) truths.push_back(*pose.second_contact);
      for (const Vec3& truth : truths) {
        double best = 0.15;  // farther than a hand is another place
        for (const auto& contact : seen->contacts) best = std::min(best, (contact.position - truth).norm());
        ++hands;
        missed_here += best >= 0.15 ? 1 : 0;
        mine.push_back(best);
      }
      if (truths.size() == 1 && !seen->pixels.empty()) {
        theirs.push_back((test::thesis_rule(stage, current, seen->pixels) - pose.contact).norm());
      }
    }
    missed += missed_here;
    table += fmt::format("{:<22} {:8.1f} {:6.1f} {:12.1f} {:8}\n", kNames[k], 1e3 * test::quantile(mine, 0.5),
                         1e3 * test::quantile(mine, 0.9), 1e3 * test::quantile(theirs, 0.9), missed_here);
    all.insert(all.end(), mine.begin(), mine.end());
    thesis.insert(thesis.end(), theirs.begin(), theirs.end());
  }
  table +=
      fmt::format("{:<22} {:8.1f} {:6.1f} {:12.1f} {:8} of {} hands\n", "all", 1e3 * test::quantile(all, 0.5),
                  1e3 * test::quantile(all, 0.9), 1e3 * test::quantile(thesis, 0.9), missed, hands);
  std::cout << table;
  CHECK(test::quantile(all, 0.5) < 0.012);
  CHECK(test::quantile(all, 0.5) < 0.5 * test::quantile(thesis, 0.5));
  CHECK(missed <= hands / 10);
}

TEST_CASE("somebody who passes by is not a grasp, however much of the object he hides", "[partner][grasp]") {
  for (std::size_t k = 0; k < kKinds.size(); ++k) {
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
      const Stage stage(kKinds[k], 300 + seed, 3);
      auto finder = stage.finder();
      const bool in_front = seed % 2 == 0;
      const auto seen =
          finder.find(stage.see(sim_hal::with_passer_by(stage.scene, seed, in_front), 9 + seed));
      REQUIRE(seen);
      INFO(stage.scene.name << (in_front ? ", before: " : ", behind: ") << seen->because);
      CHECK(seen->kind != PartnerKind::Grasp);
      CHECK_FALSE(seen->because.empty());
    }
  }
}

TEST_CASE("an unchanged scene is nobody, whoever stands in it already", "[partner][grasp]") {
  for (const ObjectKind kind : kKinds) {
    const Stage stage(kind, 41, 5);
    auto finder = stage.finder();
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
      const auto seen = finder.find(stage.see(stage.scene.world, 600 + seed));
      REQUIRE(seen);
      INFO(seen->because);
      CHECK(seen->kind == PartnerKind::None);
      CHECK(seen->pixels.empty());
    }
  }
}

TEST_CASE("an object that was carried away is not mistaken for a partner", "[partner][grasp]") {
  const Stage stage(ObjectKind::Table, 3);
  sim_hal::World bare;
  for (const auto& shape : stage.scene.world.shapes) {
    if (shape.label != sim_hal::Label::Target) bare.shapes.push_back(shape);
  }
  auto finder = stage.finder();
  const auto seen = finder.find(stage.see(bare, 1));
  REQUIRE(seen);
  CHECK(seen->kind == PartnerKind::ObjectMoved);
}

TEST_CASE("the same frame gives the same answer to the last bit", "[partner][grasp]") {
  const Stage stage(ObjectKind::Table, 5, 3);
  const auto world = sim_hal::with_partner(stage.scene.world, sim_hal::make_partner(stage.scene, 2, false));
  auto one = stage.finder(), other = stage.finder();
  const auto current = stage.see(world, 4);
  REQUIRE(other.find(stage.see(stage.scene.world, 8)));
  const auto a = one.find(current), b = other.find(current);
  REQUIRE((a && b && a->grasp && b->grasp));
  CHECK(a->grasp->position == b->grasp->position);
  CHECK(a->pixels == b->pixels);
}

TEST_CASE("a frame of another camera is refused", "[partner][grasp]") {
  const Stage stage(ObjectKind::Box, 2, 1);
  auto finder = stage.finder();
  auto moved = stage.see(stage.scene.world, 1);
  moved.X_WC.translation().x() += 0.01;
  CHECK(finder.find(moved).error().code == hal::ErrorCode::BadInput);
  CHECK(finder.find(OrganisedCloud{}).error().code == hal::ErrorCode::BadInput);
  Target nothing;
  CHECK_FALSE(PartnerFinder::make(stage.reference, nothing, stage.ground, NoiseModel{}, {}));
  nothing.pixels = {4000000};
  CHECK_FALSE(PartnerFinder::make(stage.reference, nothing, stage.ground, NoiseModel{}, {}));
}

}  // namespace
}  // namespace colift::perception
