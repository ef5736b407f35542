#include "validate/tasks/side_by_side.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <deque>
#include <fstream>
#include <limits>
#include <mutex>
#include <string>
#include <utility>

namespace backbend::validate {

namespace {

/// The first number in a file that follows `name`, or NaN.
double number_in(const char* file, const std::string& name) {
  std::ifstream stream(file);
  std::string word;
  if (!name.empty())
    while (stream >> word && word != name) {
    }
  double value = 0.0;
  return stream >> value ? value : std::numeric_limits<double>::quiet_NaN();
}

double free_bytes() {
  constexpr double kPlenty = 1e15;  // where nothing says
  double bytes = 1024.0 * number_in("/proc/meminfo", "MemAvailable:");
  if (std::isnan(bytes)) bytes = kPlenty;
  // "max" means no limit; it reads as NaN.
  const double limit = number_in("/sys/fs/cgroup/memory.max", "");
  const double used = number_in("/sys/fs/cgroup/memory.current", "");
  return std::isnan(limit - used) ? bytes : std::min(bytes, limit - used);
}

std::size_t workers_for(std::size_t most) {
  const int threads = oneapi::tbb::this_task_arena::max_concurrency();
  return std::clamp<std::size_t>(most, 1, static_cast<std::size_t>(std::max(1, threads)));
}

}  // namespace

std::size_t pieces_in_memory(double bytes_each) {
  const double pieces = 0.5 * free_bytes() / std::max(1.0, bytes_each);
  return static_cast<std::size_t>(std::clamp(pieces, 1.0, 1e6));
}

void for_each_side_by_side(std::size_t count, const std::function<void(std::size_t)>& work,
                           std::size_t most) {
  namespace tbb = oneapi::tbb;
  std::atomic<std::size_t> next = 0;
  tbb::parallel_for(
      std::size_t{0}, std::min(count, workers_for(most)),
      [&](std::size_t) {
        while (!tbb::is_current_task_group_canceling()) {
          const std::size_t i = next++;
          if (i >= count) return;
          tbb::this_task_arena::isolate([&] { work(i); });
        }
      },
      tbb::simple_partitioner());
}

SideBySide::Group SideBySide::group() {
  groups_.emplace_back();
  return groups_.size() - 1;
}

void SideBySide::add(Group group, std::function<void()> work) {
  pieces_.push_back({group, std::move(work)});
}

void SideBySide::after(Group group, std::function<void()> work) {
  groups_[group].work.push_back(std::move(work));
}

void SideBySide::run(std::size_t most) {
  namespace tbb = oneapi::tbb;
  constexpr auto kNone = static_cast<Group>(-1);
  std::mutex mutex;
  std::deque<Piece> line(std::make_move_iterator(pieces_.begin()),
                         std::make_move_iterator(pieces_.end()));
  for (const Piece& piece : line) ++groups_[piece.group].pieces;
  pieces_.clear();
  tbb::task_group tasks;
  const std::size_t workers = workers_for(most);
  std::size_t busy = 0;
  // Ends when nothing is left to begin. What a piece brings to the line brings threads with it.
  std::function<void()> work_off;
  const auto bring = [&](Group group) {  // under the lock
    const std::size_t count = groups_[group].work.size();
    for (std::size_t i = count; i-- > 0;)
      line.push_front({kNone, std::move(groups_[group].work[i])});
    groups_[group].work.clear();
    for (std::size_t i = 0; i < count; ++i) tasks.run(work_off);
  };
  work_off = [&] {
    while (!tbb::is_current_task_group_canceling()) {
      Piece piece;
      {
        const std::lock_guard lock(mutex);
        if (line.empty() || busy == workers) return;
        ++busy;
        piece = std::move(line.front());
        line.pop_front();
      }
      tbb::this_task_arena::isolate([&] { piece.work(); });
      piece.work = nullptr;  // what it held goes with it
      const std::lock_guard lock(mutex);
      --busy;
      if (piece.group == kNone) continue;
      if (--groups_[piece.group].pieces == 0) bring(piece.group);
    }
  };
  {
    const std::lock_guard lock(mutex);
    for (Group group = 0; group < groups_.size(); ++group)
      if (groups_[group].pieces == 0) bring(group);
  }
  for (std::size_t i = 0; i < workers; ++i) tasks.run(work_off);
  tasks.wait();
  groups_.clear();
}

}  // namespace backbend::validate
