#include "stock_planning.hpp"

#include <fcl/geometry/octree/octree.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision.h>
#include <octomap/OcTree.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/SimpleSetup.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>

#include <vector>

#include "bench_timing.hpp"

namespace colift::bench {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;

std::shared_ptr<fcl::CollisionGeometryd> geometry(const hal::LinkShape& shape) {
  switch (shape.kind) {
    case hal::LinkShape::Kind::Box:
      return std::make_shared<fcl::Boxd>(shape.size);
    case hal::LinkShape::Kind::Cylinder:
      return std::make_shared<fcl::Cylinderd>(shape.size.x(), shape.size.y());
    case hal::LinkShape::Kind::Sphere:
      return std::make_shared<fcl::Sphered>(shape.size.x());
  }
  return nullptr;
}

hal::JointVector joints(const ob::State* state) {
  return Eigen::Map<const hal::JointVector>(state->as<ob::RealVectorStateSpace::StateType>()->values);
}

}  // namespace

struct StockPlanner::Impl {
  struct Solid {
    int link;
    hal::Pose X_LS;
    std::unique_ptr<fcl::CollisionObjectd> object;
  };
  hal::RobotModel model;
  std::vector<Solid> solids;
  std::vector<std::pair<std::size_t, std::size_t>> pairs;  ///< Solids of links that may touch each other.
  std::unique_ptr<fcl::CollisionObjectd> octree;
  std::shared_ptr<ob::RealVectorStateSpace> space;
  std::vector<hal::Pose> X_WL;
  std::size_t checks = 0;

  bool is_free(const hal::JointVector& q_rad) {
    ++checks;
    hal::link_poses(model, q_rad, hal::coupled_posture(0.0), X_WL);
    fcl::CollisionRequestd request;
    fcl::CollisionResultd result;
    for (Solid& solid : solids) {
      solid.object->setTransform(X_WL[static_cast<std::size_t>(solid.link)] * solid.X_LS);
      solid.object->computeAABB();
      // what stands on the floor may touch it
      if (solid.link < model.arm[1]) continue;
      if (fcl::collide(solid.object.get(), octree.get(), request, result) > 0) return false;
    }
    for (const auto& [a, b] : pairs) {
      fcl::CollisionObjectd &first = *solids[a].object, &second = *solids[b].object;
      if (!first.getAABB().overlap(second.getAABB())) continue;
      if (fcl::collide(&first, &second, request, result) > 0) return false;
    }
    return true;
  }
};

StockPlanner::StockPlanner(const hal::RobotModel& model, const planner::SphereModel& spheres,
                           const perception::WorldMap& map, const planner::JointBox& box)
    : impl_(std::make_unique<Impl>()) {
  ompl::msg::setLogLevel(ompl::msg::LOG_NONE);
  Impl& m = *impl_;
  m.model = model;
  for (std::size_t link = 0; link < model.links.size(); ++link) {
    for (const hal::LinkShape& shape : model.links[link].shapes) {
      m.solids.push_back(
          {static_cast<int>(link), shape.X_LS, std::make_unique<fcl::CollisionObjectd>(geometry(shape))});
    }
  }
  for (const auto& [a, b] : spheres.self_pairs) {
    for (std::size_t i = 0; i < m.solids.size(); ++i) {
      for (std::size_t k = 0; k < m.solids.size(); ++k)
        if (m.solids[i].link == a && m.solids[k].link == b) m.pairs.emplace_back(i, k);
    }
  }
  auto tree = std::make_shared<octomap::OcTree>(map.tree());
  for (const hal::Vec3& p : map.target_cells()) {
    tree->updateNode(
        octomap::point3d(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())),
        5.0f);
  }
  tree->updateInnerOccupancy();
  m.octree = std::make_unique<fcl::CollisionObjectd>(
      std::make_shared<fcl::OcTreed>(std::shared_ptr<const octomap::OcTree>(tree)));
  m.space = std::make_shared<ob::RealVectorStateSpace>(hal::kArmJoints);
  ob::RealVectorBounds bounds(hal::kArmJoints);
  for (unsigned i = 0; i < hal::kArmJoints; ++i) {
    bounds.setLow(i, box.lower_rad[i]);
    bounds.setHigh(i, box.upper_rad[i]);
  }
  m.space->setBounds(bounds);
}
StockPlanner::~StockPlanner() = default;

bool StockPlanner::is_free(const hal::JointVector& q_rad) {
  return impl_->is_free(q_rad);
}

std::size_t StockPlanner::checks() const {
  return impl_->checks;
}

StockPlanner::Outcome StockPlanner::plan(const hal::JointVector& start, const hal::JointVector& goal,
                                         double limit_s, double resolution) {
  Impl& m = *impl_;
  og::SimpleSetup setup(m.space);
  setup.setStateValidityChecker([&m](const ob::State* state) { return m.is_free(joints(state)); });
  setup.getSpaceInformation()->setStateValidityCheckingResolution(resolution);
  setup.setPlanner(std::make_shared<og::RRTConnect>(setup.getSpaceInformation()));
  ob::ScopedState<ob::RealVectorStateSpace> from(m.space), to(m.space);
  for (unsigned i = 0; i < hal::kArmJoints; ++i) {
    from->values[i] = start[static_cast<int>(i)];
    to->values[i] = goal[static_cast<int>(i)];
  }
  setup.setStartAndGoalStates(from, to);
  Outcome out;
  double begin = cpu_ms();
  const bool solved = setup.solve(limit_s) == ob::PlannerStatus::EXACT_SOLUTION;
  out.plan_ms = cpu_ms() - begin;
  if (!solved) return out;
  begin = cpu_ms();
  setup.simplifySolution();
  out.simplify_ms = cpu_ms() - begin;
  const og::PathGeometric& path = setup.getSolutionPath();
  for (std::size_t i = 0; i < path.getStateCount(); ++i) {
    out.path.push_back(joints(path.getState(static_cast<unsigned>(i))));
  }
  return out;
}

}  // namespace colift::bench
