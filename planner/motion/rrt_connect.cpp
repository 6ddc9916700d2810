#include "planner/motion/rrt_connect.hpp"

#include <ompl/base/MotionValidator.h>
#include <ompl/base/PlannerTerminationCondition.h>
#include <ompl/base/ProblemDefinition.h>
#include <ompl/base/SpaceInformation.h>
#include <ompl/base/StateSampler.h>
#include <ompl/base/goals/GoalState.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/PathGeometric.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/util/Console.h>

#include <memory>
#include <utility>

#include "planner/motion/joint_random.hpp"

namespace colift::planner {
namespace {

namespace ob = ompl::base;
using hal::JointVector;
using Space = ob::RealVectorStateSpace;

Eigen::Map<const JointVector> joints(const ob::State* state) {
  return Eigen::Map<const JointVector>(state->as<Space::StateType>()->values);
}

void assign(ob::State* state, const JointVector& q) {
  Eigen::Map<JointVector>(state->as<Space::StateType>()->values) = q;
}

class Validity final : public ob::StateValidityChecker {
 public:
  Validity(const ob::SpaceInformationPtr& si, const FreeSpace& space)
      : ob::StateValidityChecker(si), space_(space) {}
  bool isValid(const ob::State* state) const override { return space_.state(joints(state)); }

 private:
  const FreeSpace& space_;
};

class Motions final : public ob::MotionValidator {
 public:
  Motions(const ob::SpaceInformationPtr& si, const FreeSpace& space)
      : ob::MotionValidator(si), space_(space) {}
  bool checkMotion(const ob::State* from, const ob::State* to) const override {
    return space_.edge(joints(from), joints(to));
  }
  bool checkMotion(const ob::State* from, const ob::State* to,
                   std::pair<ob::State*, double>& last) const override {
    if (checkMotion(from, to)) return true;
    if (last.first != nullptr) si_->copyState(last.first, from);
    last.second = 0.0;
    return false;
  }

 private:
  const FreeSpace& space_;
};

/// Draws from an engine of its own: OMPL's generators hang on one seed for the whole process.
class Sampler final : public ob::StateSampler {
 public:
  Sampler(const ob::StateSpace* space, const JointBox& box, std::uint64_t seed, std::size_t& drawn)
      : ob::StateSampler(space), box_(box), random_(seed), drawn_(drawn) {}
  void sampleUniform(ob::State* state) override {
    ++drawn_;
    assign(state, random_.in(box_));
  }
  void sampleUniformNear(ob::State* state, const ob::State* near, double distance) override {
    ++drawn_;
    assign(state, random_.near(joints(near), distance, box_));
  }
  void sampleGaussian(ob::State* state, const ob::State* mean, double deviation) override {
    sampleUniformNear(state, mean, 1.7 * deviation);
  }

 private:
  const JointBox& box_;
  JointRandom random_;
  std::size_t& drawn_;
};

/// OMPL prints to the console by default; what failed is said by the planner in its own words.
void silence_ompl() {
  static const bool done = [] {
    ompl::msg::setLogLevel(ompl::msg::LOG_NONE);
    return true;
  }();
  static_cast<void>(done);
}

std::shared_ptr<ob::SpaceInformation> make_space(const FreeSpace& space, const JointBox& box,
                                                 std::uint64_t seed, std::size_t& drawn) {
  auto joints_space = std::make_shared<Space>(hal::kArmJoints);
  ob::RealVectorBounds bounds(hal::kArmJoints);
  for (unsigned i = 0; i < hal::kArmJoints; ++i) {
    bounds.setLow(i, box.lower_rad[i]);
    bounds.setHigh(i, box.upper_rad[i]);
  }
  joints_space->setBounds(bounds);
  joints_space->setStateSamplerAllocator([&box, seed, &drawn](const ob::StateSpace* s) {
    return std::make_shared<Sampler>(s, box, seed, drawn);
  });
  auto si = std::make_shared<ob::SpaceInformation>(joints_space);
  si->setStateValidityChecker(std::make_shared<Validity>(si, space));
  si->setMotionValidator(std::make_shared<Motions>(si, space));
  si->setup();
  return si;
}

}  // namespace

std::optional<FoundPath> rrt_connect(const FreeSpace& space, const JointBox& box, const JointVector& start,
                                     std::span<const JointVector> goals, const SearchBudget& budget,
                                     std::uint64_t seed, std::size_t& samples_used) {
  silence_ompl();
  std::size_t drawn = 0;
  const auto si = make_space(space, box, seed, drawn);
  const auto problem = std::make_shared<ob::ProblemDefinition>(si);
  // OMPL's RRT-Connect roots all starts at once, but takes a second goal only after its tree at the first one
  // has grown: a locked-in first goal would end the search. So it is asked for the way back.
  ob::ScopedState<Space> state(si);
  for (const JointVector& goal : goals) {
    assign(state.get(), goal);
    problem->addStartState(state);
  }
  const auto target = std::make_shared<ob::GoalState>(si);
  assign(state.get(), start);
  target->setState(state);
  problem->setGoal(target);

  ompl::geometric::RRTConnect planner(si);
  planner.setRange(budget.max_edge_rad);
  planner.setProblemDefinition(problem);
  planner.setup();
  const ob::PlannerTerminationCondition spent([&] { return drawn >= budget.samples; });
  const ob::PlannerStatus status = planner.solve(spent);
  samples_used += drawn;
  if (status != ob::PlannerStatus::EXACT_SOLUTION) return std::nullopt;

  const auto& found = *problem->getSolutionPath()->as<ompl::geometric::PathGeometric>();
  FoundPath out;
  for (std::size_t i = found.getStateCount(); i-- > 0;) {
    out.path.emplace_back(joints(found.getState(static_cast<unsigned>(i))));
  }
  while (out.goal + 1 < goals.size() && goals[out.goal] != out.path.back()) ++out.goal;
  return out;
}

}  // namespace colift::planner
