#pragma once

#include <Python.h>
#include <unistd.h>

namespace colift::python {

/// While it lives, other Python threads run. For computations that touch no Python object. A daemon thread
/// that comes back after the interpreter has begun to end is kept here, as Python 3.14 does it: to end it
/// would unwind frames that do not expect that.
class Unlocked {
 public:
  Unlocked() : thread_(PyEval_SaveThread()) {}
  ~Unlocked() noexcept(false) {
    const bool main_thread = ::gettid() == ::getpid();
    while (_Py_IsFinalizing() != 0 && !main_thread) ::pause();
    PyEval_RestoreThread(thread_);
  }
  Unlocked(const Unlocked&) = delete;
  Unlocked& operator=(const Unlocked&) = delete;

 private:
  PyThreadState* thread_;
};

}  // namespace colift::python
