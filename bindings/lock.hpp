// Work without the interpreter's lock, and memory that a call inside a call does not share.
#pragma once

#include <nanobind/nanobind.h>

#include <chrono>
#include <thread>
#include <utility>

#include "pool.hpp"

namespace nb = nanobind;

// Takes the interpreter's lock back. While the interpreter shuts down, Python ends a thread that asks for the lock by
// unwinding its stack, which would abort the process in C++ code; the thread stays here until the process has ended.
inline void take_lock(PyThreadState* state) {
  try {
    PyEval_RestoreThread(state);
  } catch (...) {
    for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
  }
}

// run_blocks() without the interpreter's lock. Signals are handled now and then; where a handler raises, as for Ctrl-C,
// the work ends early and the error goes on.
template <class Work>
void run_unlocked(std::ptrdiff_t count, std::ptrdiff_t block, int threads, const Work& work) {
  PyThreadState* state = PyEval_SaveThread();
  const auto no_signal = [&state] {
    take_lock(state);
    const bool none = PyErr_CheckSignals() == 0;
    state = PyEval_SaveThread();
    return none;
  };
  bool finished;
  try {
    finished = run_blocks(count, block, threads, work, no_signal);
  } catch (...) {
    take_lock(state);
    throw;
  }
  take_lock(state);
  if (!finished) nb::raise_python_error();
}

// Memory that is kept from call to call. A call that begins while another one is under way, from a signal handler or a
// gradient, finds none and makes its own.
template <class T>
class Lease {
 public:
  explicit Lease(T& home) : home_(home), mine_(std::exchange(home, T{})) {}
  ~Lease() { home_ = std::move(mine_); }
  Lease(const Lease&) = delete;
  Lease& operator=(const Lease&) = delete;
  T& operator*() { return mine_; }
  T* operator->() { return &mine_; }

 private:
  T& home_;
  T mine_;
};
