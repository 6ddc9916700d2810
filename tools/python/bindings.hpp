#pragma once

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hal/drivers/recorded/frame_file.hpp"
#include "hal/types/result.hpp"
#include "tools/python/gil.hpp"

namespace colift::python {

namespace py = pybind11;

/// An error of CoLift on its way to Python, where it is a colift.Error with code, where and detail.
struct Failure {
  hal::Error error;
};

[[noreturn]] inline void refuse(const char* where, std::string detail) {
  throw Failure{{hal::ErrorCode::BadInput, where, std::move(detail)}};
}

/// The value, or the error thrown.
template <class T>
T value_of(hal::Result<T>&& result) {
  if (!result) throw Failure{result.error()};
  return std::move(*result);
}

inline void value_of(hal::Result<>&& result) {
  if (!result) throw Failure{result.error()};
}

/// An array that is a view of an object's data, read-only, and keeps the object alive.
template <class T>
py::array view(std::shared_ptr<const void> owner, const T* data, std::vector<py::ssize_t> shape) {
  using Owner = std::shared_ptr<const void>;
  py::capsule kept(new Owner(std::move(owner)), [](void* p) { delete static_cast<Owner*>(p); });
  py::array_t<T> array(std::move(shape), data, std::move(kept));
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

/// A depth frame as Python holds it; nothing changes it any more.
using Frame = hal::RecordedFrame;

void bind_frame(py::module_& m);
void bind_candidate(py::module_& m);
void bind_analysis(py::module_& m);
void bind_run(py::module_& m);
void bind_recording(py::module_& m);
void bind_experiments(py::module_& m);
void bind_plot(py::module_& m);

}  // namespace colift::python
