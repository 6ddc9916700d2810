// The compiled part of the Python package `colift`; tools/python/colift/__init__.py is what people import.

#include "tools/analyse/rank_json.hpp"
#include "tools/python/bindings.hpp"

namespace colift::python {
namespace {

const char* word(hal::ErrorCode code) {
  switch (code) {
    case hal::ErrorCode::Timeout:
      return "timeout";
    case hal::ErrorCode::LinkLost:
      return "link-lost";
    case hal::ErrorCode::BadReply:
      return "bad-reply";
    case hal::ErrorCode::DeviceFault:
      return "device-fault";
    case hal::ErrorCode::LimitExceeded:
      return "limit-exceeded";
    case hal::ErrorCode::NotReady:
      return "not-ready";
    case hal::ErrorCode::BadConfig:
      return "bad-config";
    case hal::ErrorCode::BadInput:
      return "bad-input";
    case hal::ErrorCode::NotFound:
      return "not-found";
  }
  return "?";
}

void bind_errors(py::module_& m) {
  py::dict nothing;
  for (const char* attribute : {"code", "where", "detail"}) nothing[attribute] = "";
  static PyObject* type = PyErr_NewExceptionWithDoc(
      "colift.Error",
      "CoLift cannot do what was asked. str() is the sentence that the program prints.\n\n"
      "code    one of timeout, link-lost, bad-reply, device-fault, limit-exceeded, not-ready, bad-config,\n"
      "        bad-input, not-found\n"
      "where   the device, the entry, the argument or the place in a file\n"
      "detail  what was found and what was expected",
      PyExc_RuntimeError, nothing.ptr());
  m.add_object("Error", py::reinterpret_borrow<py::object>(type));
  py::register_exception_translator([](std::exception_ptr p) {
    try {
      if (p) std::rethrow_exception(p);
    } catch (const Failure& f) {
      py::object e = py::reinterpret_borrow<py::object>(type)(f.error.text());
      e.attr("code") = word(f.error.code);
      e.attr("where") = f.error.where;
      e.attr("detail") = f.error.detail;
      PyErr_SetObject(type, e.ptr());
    }
  });
}

std::string rank(const std::string& problem) {
  const auto parsed = value_of(tools::parse_rank_problem(problem, "problem"));
  return tools::rank_to_json(value_of(planner::rank(parsed)));
}

}  // namespace
}  // namespace colift::python

PYBIND11_MODULE(_colift, m) {
  using namespace colift::python;
  // what help() shows is where people find it, not the file that it was compiled into
  m.attr("__name__") = "colift";
  m.attr("__version__") = COLIFT_VERSION;
  bind_errors(m);
  bind_frame(m);
  bind_candidate(m);
  bind_analysis(m);
  bind_run(m);
  bind_recording(m);
  bind_experiments(m);
  bind_plot(m);
  m.def("rank", &rank, py::arg("problem"), py::call_guard<Unlocked>());
}
