#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace backbend::validate {

/// `work(i)` for every i below `count`, begun in this order, as many at once as the pool has
/// threads, but at most `most`. A thread that waits for a part of its own piece never starts
/// another piece within it, so what a piece holds is held so many times at most. Rethrows what a
/// piece throws, when those under way have ended.
void for_each_side_by_side(std::size_t count, const std::function<void(std::size_t)>& work,
                           std::size_t most = SIZE_MAX);

/// How many pieces that hold so many bytes each may be under way at once, so that they fill no more
/// than half of the memory that is free: of the machine and of the control group that the program
/// is in. At least 1.
std::size_t pieces_in_memory(double bytes_each);

/// Pieces of work of several kinds, begun in the order in which they were added, as many at once as
/// the pool has threads. What comes last in a piece's results must not depend on that order.
class SideBySide {
 public:
  /// Pieces that something follows.
  using Group = std::size_t;
  Group group();
  void add(Group group, std::function<void()> work);
  /// `work` as soon as all pieces of the group are done, before pieces that have not begun by then.
  void after(Group group, std::function<void()> work);
  /// At most `most` pieces at once. Returns when all is done, and rethrows what a piece throws.
  void run(std::size_t most = SIZE_MAX);

 private:
  struct Piece {
    Group group = 0;
    std::function<void()> work;
  };
  struct Following {
    std::size_t pieces = 0;
    std::vector<std::function<void()>> work;
  };
  std::vector<Piece> pieces_;
  std::vector<Following> groups_;
};

}  // namespace backbend::validate
