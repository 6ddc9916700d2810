#pragma once

#include <string>

#include "hal/config/range.hpp"
#include "perception/ground.hpp"
#include "perception/noise_model.hpp"
#include "perception/partner_grasp.hpp"
#include "perception/partner_tracker.hpp"
#include "perception/shape_completion.hpp"
#include "perception/surfaces/surface_config.hpp"
#include "perception/target.hpp"
#include "perception/thesis/thesis_config.hpp"
#include "planner/grasp_candidates.hpp"
#include "planner/grasp_decision.hpp"

namespace colift::control {

/// Everything that can be set, by the names that YAML files, `--set` and `colift check` use.
struct Config {
  std::string method = "fast";
  std::string hand_file;
  perception::NoiseModel noise;
  perception::GroundConfig ground;
  perception::TargetConfig target;
  perception::SurfaceConfig surfaces;
  perception::CompletionConfig completion;
  planner::CandidateConfig candidates;
  perception::PartnerConfig partner;
  perception::TrackerConfig tracker;
  planner::DecisionConfig decision;
  perception::ThesisConfig thesis;

  template <class Visitor>
  void visit(Visitor& v) {
    v("method", method, hal::Choices{"fast", "thesis"},
      "How CoLift sees and decides: its own way, or the thesis's.");
    v("hand_file", hand_file, "Description of the hand; empty: the built-in BarrettHand BH8-282.");
    v("noise", noise, "Depth noise of the camera.");
    v("ground", ground, "How the ground is found.");
    v("target", target, "Which object is the target.");
    v("surfaces", surfaces, "How the object's faces are found.");
    v("completion", completion, "How the unseen part of the object is guessed.");
    v("candidates", candidates, "Where the hand may grasp.");
    v("partner", partner, "How the partner's grasp is seen.");
    v("tracker", tracker, "When a touch is a grasp.");
    v("decision", decision, "How the load is shared.");
    v("thesis", thesis, "Parameters of the thesis's method.");
  }
};

}  // namespace colift::control
