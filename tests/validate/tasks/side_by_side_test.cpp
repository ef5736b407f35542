#include "validate/tasks/side_by_side.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <stdexcept>
#include <vector>

namespace backbend::validate {
namespace {

void on(int threads, const std::function<void()>& work) {
  oneapi::tbb::task_arena(threads).execute(work);
}

/// The largest number of pieces that were under way at once.
class Crowd {
 public:
  void enter() {
    const int now = ++inside_;
    int most = most_;
    while (now > most && !most_.compare_exchange_weak(most, now)) {
    }
  }
  void leave() { --inside_; }
  int most() const { return most_; }

 private:
  std::atomic<int> inside_ = 0, most_ = 0;
};

TEST(SideBySide, DoesEveryPieceOnceAndOnOneThreadInTheirOrder) {
  for (const int threads : {1, 4}) {
    std::mutex mutex;
    std::vector<int> done;
    on(threads, [&] {
      SideBySide work;
      const SideBySide::Group group = work.group();
      for (int i = 0; i < 100; ++i)
        work.add(group, [&, i] {
          const std::lock_guard lock(mutex);
          done.push_back(i);
        });
      work.run();
    });
    ASSERT_EQ(done.size(), 100u);
    if (threads > 1) std::sort(done.begin(), done.end());
    for (int i = 0; i < 100; ++i) EXPECT_EQ(done[static_cast<std::size_t>(i)], i);
  }
}

TEST(SideBySide, WhatFollowsAGroupComesAfterAllOfItAndBeforeWhatHasNotBegun) {
  for (const int threads : {1, 4}) {
    std::atomic<int> first = 0, second = 0, followers = 0;
    std::atomic<bool> too_early = false, too_late = false;
    on(threads, [&] {
      SideBySide work;
      const SideBySide::Group a = work.group(), b = work.group(), empty = work.group();
      for (int i = 0; i < 20; ++i) work.add(a, [&] { ++first; });
      for (int i = 0; i < 200; ++i) work.add(b, [&] { ++second; });
      for (int i = 0; i < 3; ++i)
        work.after(a, [&] {
          ++followers;
          if (first != 20) too_early = true;
          if (threads == 1 && second != 0) too_late = true;
        });
      work.after(b, [&] {
        ++followers;
        if (second != 200) too_early = true;
      });
      work.after(empty, [&] { ++followers; });
      work.run();
    });
    EXPECT_EQ(followers, 5);
    EXPECT_FALSE(too_early);
    EXPECT_FALSE(too_late);
  }
}

TEST(SideBySide, NoMoreAreUnderWayThanAllowedThoughTheirLoopsUseAllThreads) {
  for (const std::size_t most : {1u, 2u}) {
    Crowd pieces, loops;
    on(4, [&] {
      const auto piece = [&] {
        pieces.enter();
        oneapi::tbb::parallel_for(0, 64, [](int i) {
          volatile double x = i;
          for (int k = 0; k < 2000; ++k) x = x * 0.5 + 1.0;
        });
        pieces.leave();
      };
      SideBySide work;
      const SideBySide::Group group = work.group();
      for (int i = 0; i < 40; ++i) work.add(group, piece);
      work.run(most);
      for_each_side_by_side(
          40,
          [&](std::size_t) {
            loops.enter();
            piece();
            loops.leave();
          },
          most);
    });
    EXPECT_LE(pieces.most(), static_cast<int>(most));
    EXPECT_LE(loops.most(), static_cast<int>(most));
  }
}

TEST(SideBySide, RethrowsWhatAPieceThrowsAndBeginsNoOther) {
  for (const int threads : {1, 4}) {
    std::atomic<int> begun = 0;
    const auto piece = [&] {
      if (++begun == 5) throw std::runtime_error("the fifth");
    };
    on(threads, [&] {
      SideBySide work;
      const SideBySide::Group group = work.group();
      for (int i = 0; i < 10000; ++i) work.add(group, piece);
      EXPECT_THROW(work.run(), std::runtime_error);
      if (threads == 1) {
        EXPECT_EQ(begun, 5);
      }
      EXPECT_LT(begun, 10000);
      begun = 0;
      EXPECT_THROW(for_each_side_by_side(10000, [&](std::size_t) { piece(); }), std::runtime_error);
      EXPECT_LT(begun, 10000);
    });
  }
}

TEST(SideBySide, MemoryAllowsFewerOfLargerPiecesAndAlwaysOne) {
  EXPECT_EQ(pieces_in_memory(1e18), 1u);
  EXPECT_GT(pieces_in_memory(1.0), 1000u);
}

}  // namespace
}  // namespace backbend::validate
