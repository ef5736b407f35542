#include "cli/python/working.h"

#include <pthread.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

#include "validate/tasks/interrupt_note.h"
#include "validate/tasks/progress.h"

namespace backbend::python {
namespace {

namespace py = pybind11;
using namespace std::chrono_literals;

constexpr auto kLook = 50ms;  // between looks for signals

// Written with the interpreter's lock held.
int calls_at_work = 0;
bool interpreter_exits = false, threads_were_used = false;
std::atomic<bool> is_forked_copy = false;
thread_local int poses_on_this_thread = 0;

/// One long work at a time: each uses every core, and an interrupt ends whatever is at work.
std::timed_mutex& one_at_a_time() {
  static std::timed_mutex mutex;
  return mutex;
}

void in_forked_copy() {
  calls_at_work = 0;
  is_forked_copy = threads_were_used;
}

/// Counts a call from its begin to its end, both with the interpreter's lock held.
struct AtWork {
  AtWork() { ++calls_at_work; }
  ~AtWork() { --calls_at_work; }
  AtWork(const AtWork&) = delete;
  AtWork& operator=(const AtWork&) = delete;
};

/// The interpreter must not be taken down under threads that come back to it.
void wait_for_all_work() {
  interpreter_exits = true;
  if (calls_at_work == 0) return;
  validate::note_interrupt(SIGINT);
  while (calls_at_work > 0) {
    const py::gil_scoped_release unlocked;
    std::this_thread::sleep_for(5ms);
  }
}

/// Runs signal handlers with the lock held; what one of them raised.
std::optional<py::error_already_set> raised_by_signals() {
  if (PyErr_CheckSignals() == 0) return std::nullopt;
  return py::error_already_set();
}

struct Job {
  std::mutex mutex;
  std::condition_variable ended;
  bool done = false;
  std::exception_ptr failure;

  void run(const std::function<void()>& work) {
    try {
      work();
    } catch (...) {
      failure = std::current_exception();
    }
    const std::lock_guard lock(mutex);
    done = true;
    ended.notify_one();
  }
  bool wait() {
    std::unique_lock lock(mutex);
    return ended.wait_for(lock, kLook, [&] { return done; });
  }
};

}  // namespace

void require_usable(Needs needs) {
  if (interpreter_exits) throw NotNow("the interpreter exits: no new work of backbend begins");
  if (needs == Needs::threads && is_forked_copy)
    throw NotNow(
        "this process is a forked copy of one that had used backbend, whose threads it does not "
        "have: start processes with multiprocessing's 'spawn', or fork before the first use");
  if (needs == Needs::threads) threads_were_used = true;
}

Unlocked::Unlocked(Needs needs) {
  require_usable(needs);
  ++calls_at_work;
  state_ = PyEval_SaveThread();
}

Unlocked::~Unlocked() {
  PyEval_RestoreThread(state_);
  --calls_at_work;
}

void Unlocked::check_signals() {
  std::optional<py::error_already_set> raised;
  PyEval_RestoreThread(state_);
  raised = raised_by_signals();
  if (raised) {
    // The destructor takes the lock again; what is thrown is touched under it alone.
    std::exception_ptr thrown = std::make_exception_ptr(std::move(*raised));
    raised.reset();
    state_ = PyEval_SaveThread();
    std::rethrow_exception(thrown);
  }
  state_ = PyEval_SaveThread();
  validate::poll_interrupt();
}

void run_long(const std::function<void()>& work) {
  if (poses_on_this_thread > 0)
    throw NotNow(
        "a rig's pose() cannot judge, compare, measure or render: that work is waiting for it");
  require_usable(Needs::threads);
  const AtWork at_work;
  std::exception_ptr raised;
  const auto look = [&] {  // without the lock, before and after
    const py::gil_scoped_acquire locked;
    if (raised) return;
    if (std::optional<py::error_already_set> error = raised_by_signals())
      raised = std::make_exception_ptr(std::move(*error));
  };
  Job job;
  {
    const py::gil_scoped_release unlocked;
    std::unique_lock turn(one_at_a_time(), std::defer_lock);
    while (!raised && !turn.try_lock_for(kLook)) look();
    if (!raised) {
      std::thread worker([&] { job.run(work); });
      bool noted = false;
      while (!job.wait()) {
        look();
        if (raised && !noted) {
          validate::note_interrupt(SIGINT);
          noted = true;
        }
      }
      worker.join();
      if (noted) {
        const py::gil_scoped_acquire locked;
        if (!interpreter_exits) validate::note_interrupt(0);
      }
    }
  }
  if (raised) std::rethrow_exception(raised);
  if (job.failure) std::rethrow_exception(job.failure);
}

PosingInPython::PosingInPython() { ++poses_on_this_thread; }
PosingInPython::~PosingInPython() { --poses_on_this_thread; }

void watch_process() {
  pthread_atfork(nullptr, nullptr, in_forked_copy);
  py::module_::import("atexit").attr("register")(py::cpp_function(wait_for_all_work));
}

}  // namespace backbend::python
