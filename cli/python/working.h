#pragma once
#include <pybind11/pybind11.h>

#include <functional>
#include <stdexcept>

namespace backbend::python {

// How work of ours lives with an interpreter: its lock is released meanwhile, Ctrl-C ends it, a
// forked copy of the process refuses what needs the threads that it does not have, and an
// interpreter that exits waits until every thread of ours is out of it.

/// Work that must not begin now: RuntimeError in Python.
struct NotNow : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What a call needs of this process.
enum class Needs { nothing, threads };

/// Throws NotNow where work must not begin: in a forked copy of a process that had begun to use
/// threads, and while the interpreter exits.
void require_usable(Needs needs);

/// Short work: no interpreter's lock as long as this lives. Call with it held.
class Unlocked {
 public:
  explicit Unlocked(Needs needs);
  ~Unlocked();
  Unlocked(const Unlocked&) = delete;
  Unlocked& operator=(const Unlocked&) = delete;
  /// Takes the lock for a moment and runs what signals ask for. Throws what a handler raised, as
  /// KeyboardInterrupt; call it every now and then.
  void check_signals();

 private:
  PyThreadState* state_;
};

/// Long work, one at a time for the whole process, on a thread of its own, while this one looks
/// for signals: where a handler raises (KeyboardInterrupt), the work is ended and that is thrown.
/// Call with the lock held; `work` runs without. Throws what `work` throws.
void run_long(const std::function<void()>& work);

/// While a rig that is written in Python computes a pose on this thread.
class PosingInPython {
 public:
  PosingInPython();
  ~PosingInPython();
  PosingInPython(const PosingInPython&) = delete;
  PosingInPython& operator=(const PosingInPython&) = delete;
};

/// Called once, when the module is imported.
void watch_process();

}  // namespace backbend::python
