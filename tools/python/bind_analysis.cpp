// Setup -> look -> Analysis -> decide -> Outcome, as `colift look` and `colift decide` do it.
#include <cmath>
#include <nlohmann/json.hpp>

#include "control/session/suggest.hpp"
#include "hal/config/config_file.hpp"
#include "hal/config/field_value.hpp"
#include "tools/analyse/decide_why.hpp"
#include "tools/analyse/look_json.hpp"
#include "tools/analyse/show.hpp"
#include "tools/cli/config_of.hpp"
#include "tools/python/analysis.hpp"

namespace colift::python {
namespace {

using planner::GraspCandidate;

constexpr double kFarthest_m = 1000.0;

hal::Pose pose_of(const Eigen::Matrix4d& X) {
  constexpr double kRounding = 1e-6;
  const Eigen::Matrix3d R = X.topLeftCorner<3, 3>();
  if (!X.allFinite() || !(R * R.transpose()).isIdentity(kRounding) || R.determinant() < 0.0 ||
      X.row(3) != Eigen::RowVector4d(0, 0, 0, 1) || X.col(3).head<3>().norm() > kFarthest_m)
    refuse("camera_pose", "expected a rigid transform, 4 x 4, in metres");
  hal::Pose pose = hal::Pose::Identity();
  pose.matrix() = X;
  return pose;
}

void check_point(const char* where, const hal::Vec3& p) {
  if (!p.allFinite() || p.norm() > kFarthest_m) refuse(where, "expected three finite numbers, in metres");
}

std::unique_ptr<PySetup> setup_of(const std::string& command, const std::string& method,
                                  const std::string& share, const std::string& share_strict,
                                  std::vector<std::string> settings, std::vector<std::string> config_files) {
  const Unlocked other_threads_run;
  tools::CommonOptions common;
  common.settings = std::move(settings);
  common.config_files = std::move(config_files);
  const auto with_share = [&](auto options) {
    options.share = share;
    options.share_strict = share_strict;
    return options;
  };
  const auto resolved = [&]() -> hal::Result<control::ResolvedConfig> {
    if (command == "decide") {
      tools::DecideOptions options = with_share(tools::DecideOptions{});
      options.look.method = method;
      return tools::config_of_decide(common, options);
    }
    if (command == "look") {
      tools::LookOptions options;
      options.method = method;
      return tools::config_of_look(common, options);
    }
    if (command == "run") {
      tools::RunOptions options = with_share(tools::RunOptions{});
      options.method = method;
      return tools::config_of_run(common, options);
    }
    refuse("command", "\"" + command + "\" has no such configuration; expected look, decide or run");
  }();
  return std::make_unique<PySetup>(
      PySetup{std::make_shared<const tools::Setup>(value_of(tools::load_setup(resolved)))});
}

std::string setting_of(const PySetup& s, const std::string& path) {
  control::Config copy = s.setup->config;  // only read: a table refers to what can be changed
  hal::FieldTable table = hal::table_of(copy);
  const hal::Field* field = table.find(path);
  if (field == nullptr)
    throw Failure{{hal::ErrorCode::BadConfig, path, "there is no such entry; Setup.yaml() shows all"}};
  return hal::value_text(hal::value_of(*field));
}

PyAnalysis look(const PySetup& py_setup, const std::shared_ptr<Frame>& frame,
                const std::optional<Eigen::Matrix4d>& camera_pose, const std::optional<hal::Vec3>& at) {
  const Unlocked other_threads_run;
  const std::shared_ptr<const tools::Setup> setup = py_setup.setup;
  if (!frame) refuse("frame", "expected a Frame");
  auto seen = std::make_shared<tools::Seen>();
  seen->file = *frame;
  control::SceneAnalysisInput input;
  if (camera_pose) {
    seen->X_WF = pose_of(*camera_pose);
    input.base_frame_known = true;
  } else if (setup->calibration) {
    seen->X_WF = setup->calibration->X_BC();
    input.base_frame_known = true;
  }
  if (at) {
    check_point("at", *at);
    if (setup->method == control::Method::Thesis)
      refuse("at", "goes with the method \"fast\": the thesis takes the largest cluster");
    input.at_W = at;
  }
  input.X_WC = seen->X_WF * frame->X_FC;
  input.frame = std::move(seen->file.frame);
  seen->analysis = value_of(control::analyse_scene(std::move(input), setup->method, setup->config,
                                                   setup->hand, hal::SteadyClock(), setup->hand_tables));
  return {setup, std::move(seen)};
}

const control::SceneAnalysis& with_target(const tools::Seen& seen) {
  if (!seen.analysis.finder)
    throw Failure{{hal::ErrorCode::NotFound, "candidates", "there is no object: " + seen.analysis.reason}};
  return seen.analysis;
}

void use(PyAnalysis& a, std::vector<GraspCandidate> candidates) {
  std::shared_ptr<tools::Seen> other;
  {
    const std::shared_ptr<const tools::Seen> seen = a.seen;  // another thread may replace it meanwhile
    const Unlocked other_threads_run;
    (void)with_target(*seen);
    other = std::make_shared<tools::Seen>(*seen);
    control::use_candidates(other->analysis, std::move(candidates));
  }
  a.seen = std::move(other);
}

GraspCandidate judge(const PyAnalysis& a, GraspCandidate candidate) {
  const control::SceneAnalysis& analysis = with_target(*a.seen);
  control::SceneAnalysis one;
  one.scene.surfaces = analysis.scene.surfaces;
  one.finder = analysis.finder;
  control::use_candidates(one, {std::move(candidate)});
  return one.candidates.front();
}

PyOutcome decide(const PyAnalysis& a, const py::object& partner, const PySetup* other) {
  control::PartnerInput input;
  std::optional<perception::PartnerGrasp> grasp;
  if (py::isinstance<Frame>(partner))
    input.frame = partner.cast<const Frame&>().frame;
  else if (py::isinstance<perception::PartnerGrasp>(partner))
    grasp = partner.cast<perception::PartnerGrasp>();
  else
    input.position_W = partner.cast<hal::Vec3>();
  PyOutcome out{other != nullptr ? other->setup : a.setup, a.seen, {}};
  const Unlocked other_threads_run;
  if (grasp) check_point("partner", grasp->position);
  if (input.position_W) check_point("partner", *input.position_W);
  const control::SceneAnalysis& analysis = out.seen->analysis;
  if (grasp && analysis.scene.target) {
    out.outcome = value_of(control::decide_for(analysis, *grasp, out.setup->config, hal::SteadyClock()));
    out.outcome.partner_reason = "the partner's grasp was given";
  } else {
    if (grasp) input.position_W = grasp->position;
    out.outcome = value_of(control::decide(analysis, input, out.setup->config, hal::SteadyClock()));
  }
  return out;
}

std::string decision_json(const PyOutcome& o) {
  const control::SceneAnalysis& a = o.seen->analysis;
  std::optional<control::Suggestion> suggestion;
  if (a.scene.target && a.scene.ground)
    suggestion = control::suggest_to_partner(o.outcome, a.candidates, a.scene.target->cog,
                                             a.scene.ground->plane.normal, o.setup->config.decision);
  return tools::decide_document(*o.seen, o.outcome, suggestion);
}

std::string why_json(const PyOutcome& o, int id) {
  const tools::WhyCandidate why = value_of(tools::explain_candidate(o.outcome, o.setup->config, id));
  return nlohmann::ordered_json::parse(tools::with_why("{}", o.outcome, why))["why"].dump();
}

void choose_instead(PyOutcome& o, std::size_t candidate, std::string reason) {
  value_of(control::choose_instead(o.outcome, candidate, std::move(reason)));
  const control::SceneAnalysis& a = o.seen->analysis;
  const control::Config& config = o.setup->config;
  o.outcome.share = control::share_contract(
      o.outcome, a, control::uncertain_scene(a, *o.outcome.partner, config.decision), config, {});
  control::say_share(o.outcome);
}

void write(const tools::Setup& setup, const tools::Seen& seen, const control::Outcome* outcome,
           const std::optional<std::string>& picture, const std::optional<std::string>& report) {
  tools::LookOptions options;
  options.cloud = outcome != nullptr ? "colift/decide" : "colift/look";
  if (picture) options.png = *picture;
  if (report) options.report = *report;
  tools::CommonOptions common;
  common.quiet = true;
  common.command = "python";
  const Unlocked other_threads_run;
  value_of(tools::show(seen, outcome, options, common, setup));
}

template <class Number>
py::array_t<double> scores_of(const PyOutcome& o, Number number) {
  const auto& scores = o.outcome.decision.scores;
  py::array_t<double> out(static_cast<py::ssize_t>(scores.size()));
  for (std::size_t i = 0; i < scores.size(); ++i) out.mutable_at(i) = scores[i] ? number(*scores[i]) : NAN;
  return out;
}

py::object points_of(const PyAnalysis& a) {
  const auto& target = a.seen->analysis.scene.target;
  if (!target) return py::none();
  const auto n = static_cast<py::ssize_t>(target->points.size());
  return view(a.seen, n > 0 ? target->points.front().data() : nullptr, {n, 3});
}

py::object pixels_of(const PyAnalysis& a) {
  const auto& target = a.seen->analysis.scene.target;
  if (!target) return py::none();
  return view(a.seen, target->pixels.data(), {static_cast<py::ssize_t>(target->pixels.size())});
}

py::object ground_of(const PyAnalysis& a) {
  const auto& ground = a.seen->analysis.scene.ground;
  if (!ground) return py::none();
  return py::make_tuple(hal::Vec3(ground->plane.normal), ground->plane.offset);
}

}  // namespace

void bind_analysis(py::module_& m) {
  py::class_<PySetup>(m, "Setup")
      .def(py::init(&setup_of), py::arg("command"), py::arg("method"), py::arg("share"),
           py::arg("share_strict"), py::arg("settings"), py::arg("config_files"))
      .def_property_readonly("method", [](const PySetup& s) { return control::to_string(s.setup->method); })
      .def_property_readonly("warnings", [](const PySetup& s) { return s.setup->warnings; })
      .def(
          "yaml", [](const PySetup& s, bool explain) { return control::yaml_of(*s.setup, explain); },
          py::arg("explain") = false)
      .def("text_of", &setting_of, py::arg("path"))
      .def("look", &look, py::arg("frame"), py::arg("camera_pose") = py::none(), py::arg("at") = py::none());

  py::class_<PyAnalysis>(m, "Analysis")
      .def_property_readonly("reason", [](const PyAnalysis& a) { return a.seen->analysis.reason; })
      .def_property_readonly("json_text", [](const PyAnalysis& a) { return tools::look_document(*a.seen); })
      .def_property_readonly("points", &points_of)
      .def_property_readonly("pixels", &pixels_of)
      .def_property_readonly("ground", &ground_of)
      .def_property_readonly(
          "depth",
          [](const PyAnalysis& a) {
            const hal::DepthFrame& f = a.seen->analysis.frame;
            return view(a.seen, f.depth_m.data(), {f.intrinsics.height, f.intrinsics.width});
          })
      .def_property_readonly("cog",
                             [](const PyAnalysis& a) {
                               std::optional<hal::Vec3> cog;
                               if (a.seen->analysis.scene.target) cog = a.seen->analysis.scene.target->cog;
                               return cog;
                             })
      .def_property(
          "candidates", [](const PyAnalysis& a) { return a.seen->analysis.candidates; }, &use)
      .def("judge", &judge, py::arg("candidate"))
      .def("decide", &decide, py::arg("partner"), py::arg("setup") = nullptr)
      .def(
          "write",
          [](const PyAnalysis a, const std::optional<std::string>& picture,
             const std::optional<std::string>& report) {
            write(*a.setup, *a.seen, nullptr, picture, report);
          },
          py::arg("picture"), py::arg("report"));

  py::class_<PyOutcome>(m, "Outcome")
      .def_property_readonly("json_text", &decision_json)
      .def_property_readonly("reason", [](const PyOutcome& o) { return o.outcome.decision.reason; })
      .def_property_readonly("partner", [](const PyOutcome& o) { return o.outcome.partner; })
      .def_property_readonly("partner_reason", [](const PyOutcome& o) { return o.outcome.partner_reason; })
      .def_property_readonly("candidates", [](const PyOutcome& o) { return o.outcome.candidates; })
      .def_property_readonly("chosen", [](const PyOutcome& o) { return o.outcome.decision.chosen; })
      .def_property_readonly(
          "costs",
          [](const PyOutcome& o) { return scores_of(o, [](const auto& score) { return score.cost; }); })
      .def_property_readonly(
          "shares",
          [](const PyOutcome& o) { return scores_of(o, [](const auto& score) { return score.share; }); })
      .def("why_text", &why_json, py::arg("id"))
      .def("choose_instead", &choose_instead, py::arg("candidate"), py::arg("reason"))
      .def(
          "write",
          [](const PyOutcome& o, const std::optional<std::string>& picture,
             const std::optional<std::string>& report) {
            write(*o.setup, *o.seen, &o.outcome, picture, report);
          },
          py::arg("picture"), py::arg("report"));
}

}  // namespace colift::python
