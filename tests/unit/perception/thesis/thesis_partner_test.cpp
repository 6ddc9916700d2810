#include "perception/thesis/thesis_partner.hpp"

#include <catch2/catch.hpp>

#include "sampled_shapes.hpp"

using namespace colift::perception;
using colift::test::SampledShapes;

namespace {

/// A board on the floor, seen before (reference) and with something else added.
struct Board {
  std::vector<Eigen::Vector3f> object = SampledShapes(0.01).box({0, 0, 0}, {0.8, 0.5, 0.4}).points;
  std::vector<Eigen::Vector3f> reference =
      SampledShapes(0.01).rectangle({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}).points;
  ThesisConfig config;

  Board() { reference.insert(reference.end(), object.begin(), object.end()); }

  [[nodiscard]] std::optional<PartnerGrasp> with(const SampledShapes& added,
                                                 std::string* reason = nullptr) const {
    std::vector<Eigen::Vector3f> current = reference;
    current.insert(current.end(), added.points.begin(), added.points.end());
    return thesis_partner(PclCloud{reference}, PclCloud{current}, object, config, reason);
  }
};

}  // namespace

TEST_CASE("the partner's grasp is the mean of the 100 changed points nearest to the object",
          "[thesis][partner]") {
  const Board board;
  // a palm of 9 x 9 cm that hangs down beside the edge at y = 0.5, with an arm that goes away from it
  SampledShapes arm(0.01);
  arm.rectangle({0.2, 0.54, 0.3}, {0.09, 0, 0}, {0, 0, 0.09});
  arm.rectangle({0.2, 0.62, 0.35}, {0.09, 0, 0}, {0, 0.5, 0});
  const auto grasp = board.with(arm);

  REQUIRE(grasp);
  CHECK(grasp->points == 100);
  CHECK((grasp->position - Vec3{0.245, 0.54, 0.345}).norm() < 0.005);
  CHECK(std::sqrt(grasp->covariance(0, 0)) == Approx(0.0287).epsilon(0.05));
  CHECK(std::sqrt(grasp->covariance(1, 1)) < 0.005);
}

TEST_CASE("a passer-by a metre away is not a grasp", "[thesis][partner]") {
  const Board board;
  std::string reason;
  CHECK_FALSE(board.with(SampledShapes(0.01).rectangle({0, 1.5, 0.3}, {0.4, 0, 0}, {0, 0, 1.2}), &reason));
  CHECK(reason.find("cm from the object") != std::string::npos);
}

TEST_CASE("an unchanged view, noise and a few stray points are not a grasp", "[thesis][partner]") {
  const Board board;
  std::string reason;
  CHECK_FALSE(board.with(SampledShapes{}, &reason));
  CHECK(reason == "no partner's grasp: 0 points changed by more than 3.0 cm, a grasp needs 100");
  CHECK_FALSE(
      board.with(SampledShapes(0.01).rectangle({0.2, 0.54, 0.3}, {0.08, 0, 0}, {0, 0, 0.08}), &reason));
  CHECK(reason == "no partner's grasp: 81 points changed by more than 3.0 cm, a grasp needs 100");

  std::vector<Eigen::Vector3f> shaken = board.reference;
  for (std::size_t i = 0; i < shaken.size(); ++i) shaken[i].z() += i % 2 ? 0.01f : -0.01f;
  CHECK_FALSE(thesis_partner(PclCloud{board.reference}, PclCloud{shaken}, board.object, board.config));
}

TEST_CASE("without an object or without any points nobody holds anything", "[thesis][partner]") {
  const Board board;
  const PclCloud reference{board.reference};
  std::string reason;
  CHECK_FALSE(thesis_partner(reference, reference, {}, board.config, &reason));
  CHECK(reason == "no partner's grasp: there is no object to hold");
  CHECK_FALSE(thesis_partner(reference, PclCloud{}, board.object, board.config));
  CHECK_FALSE(thesis_partner(PclCloud{}, PclCloud{}, board.object, board.config));
}

TEST_CASE("the person is what hangs together with his grasp", "[thesis][partner]") {
  const Board board;
  SampledShapes added(0.01);
  added.rectangle({0.2, 0.54, 0.3}, {0.09, 0, 0}, {0, 0, 0.09});  // hand
  added.rectangle({0.2, 0.6, 0.35}, {0.09, 0, 0}, {0, 0.5, 0});   // arm
  added.rectangle({0.7, -0.5, 0.2}, {0.05, 0, 0}, {0, 0, 0.05});  // something else that is new
  const PclCloud changed{added.points};
  const auto grasp = thesis_grasp(changed, board.object, board.config);
  REQUIRE(grasp);
  const auto person = thesis_person(changed, *grasp);
  CHECK(person.size() > 500);
  for (const auto& p : person) REQUIRE(p.y() > 0.5f);
}

TEST_CASE("against the object's cloud alone a thing that always stood beside it is a grasp",
          "[thesis][partner]") {
  // a carton 4 cm beside the board, there from the start, and a palm at the other end of the side later
  Board board;
  const auto carton = SampledShapes(0.01).rectangle({0.5, 0.54, 0.1}, {0.2, 0, 0}, {0, 0, 0.2});
  const auto palm = SampledShapes(0.01).rectangle({0.1, 0.54, 0.2}, {0.12, 0, 0}, {0, 0, 0.12});
  board.reference.insert(board.reference.end(), carton.points.begin(), carton.points.end());
  OrganisedCloud before;
  for (const auto& p : board.reference) {
    before.depth_m.push_back(1.0f);
    before.x.push_back(p.x()), before.y.push_back(p.y()), before.z.push_back(p.z());
  }
  board.config.voxel_leaf_m = 0.0;
  Ground floor;
  floor.plane = {Vec3::UnitZ(), 0.0};
  const auto grasp = [&](const char* with, const std::vector<Eigen::Vector3f>& now) {
    board.config.partner_reference = with;
    const ReferenceCloud reference(before, board.object, floor, board.config);
    return thesis_grasp(reference.changed(PclCloud{now}, board.config), board.object, board.config);
  };
  std::vector<Eigen::Vector3f> later = board.reference;
  later.insert(later.end(), palm.points.begin(), palm.points.end());

  CHECK_FALSE(grasp("scene", board.reference));
  const auto seen = grasp("scene", later);
  REQUIRE(seen);
  CHECK(seen->position.x() == Approx(0.16).margin(0.02));
  // the floor is no grasp, though no part of the object either; the carton is the thesis's weakness
  const auto taken_for_hand = grasp("object", board.reference);
  REQUIRE(taken_for_hand);
  CHECK(taken_for_hand->position.x() == Approx(0.60).margin(0.05));
  board.reference.erase(board.reference.end() - static_cast<std::ptrdiff_t>(carton.points.size()),
                        board.reference.end());
  CHECK_FALSE(grasp("object", board.reference));
  board.reference.insert(board.reference.end(), palm.points.begin(), palm.points.end());
  const auto alone = grasp("object", board.reference);
  REQUIRE(alone);
  CHECK(alone->position.x() == Approx(0.16).margin(0.02));
}
