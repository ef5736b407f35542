#pragma once
#include <tbb/task_arena.h>

namespace backbend::render {

/// `loop`, a parallel one, by so many threads; 0: by those of the pool that the caller is in, where
/// other frames may be under way. A thread that waits for the rest of its loop starts nothing else
/// meanwhile.
template <class Loop>
void on_threads(int threads, const Loop& loop) {
  if (threads > 0) {
    tbb::task_arena(threads).execute(loop);
  } else {
    tbb::this_task_arena::isolate(loop);
  }
}

}  // namespace backbend::render
