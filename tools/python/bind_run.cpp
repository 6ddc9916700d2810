#include <fmt/format.h>

#include "tools/cli/shipped_files.hpp"
#include "tools/python/run_stepper.hpp"

namespace colift::python {
namespace {

std::shared_ptr<RunStepper> stepper_of(const std::optional<std::string>& scenario, const std::string& method,
                                       std::uint64_t seed, const std::string& share,
                                       const std::string& share_strict, const std::optional<std::string>& rig,
                                       bool dry_run, std::vector<std::string> settings,
                                       std::vector<std::string> config_files, py::object grasps,
                                       py::object partner, py::object choice, py::object carry,
                                       py::object lower_confirmed, py::object continue_confirmed) {
  tools::CommonOptions common;
  common.settings = std::move(settings);
  common.config_files = std::move(config_files);
  common.command = "python";
  tools::RunOptions options;
  if (scenario) options.scenario = value_of(tools::file_or_shipped(tools::ShippedKind::Scenario, *scenario));
  if (rig) options.rig = *rig;
  options.method = method;
  options.seed = seed;
  options.share = share;
  options.share_strict = share_strict;
  options.dry_run = dry_run;
  auto made = std::make_unique<RunStepper>(
      common, options,
      RunStepper::Callables{std::move(grasps), std::move(partner), std::move(choice), std::move(carry),
                            std::move(lower_confirmed), std::move(continue_confirmed)});
  const std::shared_ptr<RunStepper> run(made.release(), [](RunStepper* r) {
    if (r->of_this_process()) delete r;
  });
  keep_in_mind(run);
  return run;
}

std::vector<std::tuple<std::string, std::string, std::string>> scenarios() {
  std::vector<std::tuple<std::string, std::string, std::string>> out;
  for (const tools::ShippedFile& f : tools::shipped_files(tools::ShippedKind::Scenario))
    out.emplace_back(f.name, f.file.string(), f.about);
  return out;
}

}  // namespace

void bind_run(py::module_& m) {
  py::class_<Status>(m, "Status", "What a running job says of itself; None where something is not known.")
      .def_readonly("t_s", &Status::t_s, "Time since the job began, on the robot's clock (s).")
      .def_readonly("state", &Status::state, "State of the job, as in docs/task.md: \"await-partner\", ...")
      .def_readonly("reason", &Status::reason, "Why it came into this state.")
      .def_readonly("doing", &Status::doing, "What it does in particular.")
      .def_readonly("done", &Status::done, "Fraction of the state's work that is done, 0 to 1.")
      .def_readonly("partner", &Status::partner, "Where the partner's hand is seen (W, m).")
      .def_readonly("load_n", &Status::load_n, "Vertical load on the hand (N); 0 while nothing is carried.")
      .def_readonly("height_m", &Status::height_m, "How far the object is raised (m).")
      .def_readonly("tilt_rad", &Status::tilt_rad, "Tilt of the object against its pose on the ground (rad).")
      .def_readonly("slip_m", &Status::slip_m, "Slip of the object in the hand (m).")
      .def_readonly("share_robot", &Status::share_robot, "The robot's share of the load, 0 to 1.")
      .def_readonly("speed_scale", &Status::speed_scale, "Of the planned speed, 0 to 1.")
      .def_readonly("distance_m", &Status::distance_m, "Of the nearest person or thing to the arm (m).")
      .def("__repr__", [](const Status& s) {
        return fmt::format("<colift.Status {:.2f} s {}: {}>", s.t_s, s.state, s.doing);
      });
  py::class_<RunStepper, std::shared_ptr<RunStepper>>(m, "Run")
      .def(py::init(&stepper_of), py::arg("scenario"), py::arg("method"), py::arg("seed"), py::arg("share"),
           py::arg("share_strict"), py::arg("rig"), py::arg("dry_run"), py::arg("settings"),
           py::arg("config_files"), py::arg("grasps"), py::arg("partner"), py::arg("choice"),
           py::arg("carry"), py::arg("lower_confirmed"), py::arg("continue_confirmed"))
      .def("step", &RunStepper::step)
      .def("stop", &RunStepper::stop)
      .def("close", &RunStepper::close)
      .def_property_readonly("over", &RunStepper::over)
      .def_property_readonly("json_text", &RunStepper::document)
      .def("write_report", &RunStepper::write_report, py::arg("file"))
      .def("write_picture", &RunStepper::write_picture, py::arg("file"));
  m.def("scenarios", &scenarios);
  // while other threads may still take the interpreter's lock
  py::module_::import("atexit").attr("register")(py::cpp_function(&close_all_runs));
}

}  // namespace colift::python
